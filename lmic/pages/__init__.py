"""Pages: the gallery of theorems and the report of a reproduction, made from the theorems and results themselves."""
