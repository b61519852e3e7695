"""The compiler, stages 1 to 3 and 5: from a theorem's block matrices and a plant's data to the solver's arrays."""
