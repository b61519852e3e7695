from lmic.dsl import *

(n,) = dims("n")
P = Symmetric("P", n)
theorem = Theorem(lmis={"a": PD([[P - 1]])}, source=Source("N. N.", "Notes", "unpublished", 2026))
