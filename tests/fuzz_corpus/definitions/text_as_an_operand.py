from lmic.dsl import *

(n,) = dims("n")
X = Matrix("X", n, n)
theorem = Theorem(lmis={"a": PD([[X.T - "P"]])}, source=Source("N. N.", "Notes", "unpublished", 2026))
