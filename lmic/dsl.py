"""All words of the definition language: ``from lmic.dsl import *`` in a theorem file."""

from sympy import Rational, sqrt

from lmic.language.declarations import (
    BlockDiagonal,
    Data,
    Diagonal,
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
    trace,
    zeros,
)
from lmic.language.lmi import ND, PD
from lmic.language.parameters import Box, Parameter, Simplex
from lmic.language.source import Source
from lmic.language.star import star
from lmic.language.systems import (
    Bound,
    ContinuousSystem,
    DelayedFornasiniMarchesini,
    DelaySystem,
    DiscreteSystem,
    FornasiniMarchesini,
    Hurwitz,
    Schur,
)
from lmic.language.theorem import Bisection, Theorem, Variant

__all__ = [
    "ND",
    "PD",
    "Bisection",
    "BlockDiagonal",
    "Bound",
    "Box",
    "ContinuousSystem",
    "Data",
    "DelaySystem",
    "DelayedFornasiniMarchesini",
    "Diagonal",
    "DiscreteSystem",
    "FornasiniMarchesini",
    "He",
    "Hurwitz",
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
    "trace",
    "zeros",
]
