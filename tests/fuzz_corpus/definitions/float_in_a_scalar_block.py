from lmic.dsl import *

eps, mu = given("eps"), Scalar("mu")
theorem = Theorem(lmis={"a": PD([[1.5 / eps**2 - mu]])}, source=Source("N. N.", "Notes", "unpublished", 2026))
