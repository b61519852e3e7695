"""Plants: the numeric data that a theorem is applied to, and the files they come from."""
