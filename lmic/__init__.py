"""lmic: a symbolic-to-numeric compiler for parameter-dependent linear matrix inequalities."""

__version__ = "0.1.0"
