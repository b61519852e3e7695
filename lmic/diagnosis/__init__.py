"""Diagnoses: what binds, what diverges, how the data are scaled, how far infeasible, and what would help."""
