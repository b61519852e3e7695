"""Formulas for papers and pages: LaTeX of statements and of numbers, and MathML."""
