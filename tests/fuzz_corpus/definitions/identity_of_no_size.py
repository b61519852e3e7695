from lmic.dsl import *

theorem = Theorem(lmis={"a": PD([[I(0)]])}, source=Source("N. N.", "Notes", "unpublished", 2026))
