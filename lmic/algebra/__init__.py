"""Arithmetic that the stages share: matrix polynomials, matrix functions, packed matrices, integer bases."""
