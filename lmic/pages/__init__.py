"""Pages, made from theorems and results themselves: the gallery, a paper's report, a result, a notebook's display."""
