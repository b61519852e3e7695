from lmic.dsl import *

(m,) = dims("m")
eps = given("eps")
theorem = Theorem(lmis={"a": PD([[eps * I(m)]])}, source=Source("N. N.", "Notes", "unpublished", 2026))
