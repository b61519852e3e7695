"""All words of the definition language: ``from lmic.dsl import *`` in a theorem file."""

from sympy import Rational, sqrt

from lmic.language.declarations import (
    BlockDiagonal,
    Data,
    He,
    I,
    Matrix,
    Scalar,
    Symmetric,
    block,
    diag,
    dims,
    dot,
    given,
    inv,
    kron,
    star,
    zeros,
)
from lmic.language.parameters import Box, Parameter, Simplex
from lmic.language.theorem import ND, PD, Bound, DiscreteSystem, Schur, Source, Theorem, Variant

__all__ = [
    "ND",
    "PD",
    "BlockDiagonal",
    "Bound",
    "Box",
    "Data",
    "DiscreteSystem",
    "He",
    "I",
    "Matrix",
    "Parameter",
    "Rational",
    "Scalar",
    "Schur",
    "Simplex",
    "Source",
    "Symmetric",
    "Theorem",
    "Variant",
    "block",
    "diag",
    "dims",
    "dot",
    "given",
    "inv",
    "kron",
    "sqrt",
    "star",
    "zeros",
]
