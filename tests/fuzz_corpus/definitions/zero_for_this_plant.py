from lmic.dsl import *

(n,) = dims("n")
P = Symmetric("P", n)
theorem = Theorem(lmis={"a": PD([[zeros(n, n) * P * zeros(n, n)]])}, source=Source("N. N.", "Notes", "-", 2026))
