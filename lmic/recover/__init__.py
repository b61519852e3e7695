"""Stage 8, recover: what was designed, as matrices and systems for each value of the parameter."""
