"""Stage 6, solve: lineality, congruence rescaling, the conic solver, and what can be said of its answer."""
