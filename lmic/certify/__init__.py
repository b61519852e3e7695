"""What is proven of a number: exact rational and ball arithmetic, nothing from the solver's word."""
