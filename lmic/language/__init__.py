"""The definition language: the words in which a theorem is stated."""
