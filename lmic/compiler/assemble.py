"""Stage 5, assemble: families become one conic problem, minimise c·x with every F_k(x) ⪰ 0."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.compiler.bind import Binding
from lmic.compiler.columns import stacked
from lmic.compiler.layout import Layout
from lmic.relax.family import LMIFamily, Soundness
from lmic.relax.relax import Relaxation

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class ConicProblem:
    """minimise cost·x + constant subject to F_k(x) ⪰ 0 for every LMI of every family.

    A feasibility problem has ``cost`` zero. ``matrix`` and ``offset`` hold svec(F_k(x)) =
    matrix·x + offset, the LMIs one after another in the order of :meth:`blocks`. ``relaxation`` is how the
    families were made.
    """

    binding: Binding
    families: tuple[LMIFamily, ...]
    cost: Array
    constant: float
    relaxation: Relaxation = field(default_factory=Relaxation)

    @property
    def layout(self) -> Layout:
        """Names ↔ columns."""
        return self.binding.layout

    @property
    def size(self) -> int:
        """Number of scalar unknowns."""
        return len(self.cost)

    @property
    def soundness(self) -> Soundness:
        """The weakest of the families'."""
        return Soundness.weakest([family.soundness for family in self.families])

    @cached_property
    def orders(self) -> Array:
        """Order of each LMI, in the order of the rows."""
        return np.concatenate([np.full(len(family), family.lmi.order) for family in self.families])

    @cached_property
    def starts(self) -> Array:
        """First row of each LMI, and the number of rows at the end."""
        lengths = self.orders * (self.orders + 1) // 2
        return np.concatenate([[0], np.cumsum(lengths)])

    def blocks(self) -> Iterator[tuple[LMIFamily, int]]:
        """Every LMI as (family, index within it)."""
        for family in self.families:
            for k in range(len(family)):
                yield family, k

    @cached_property
    def columns(self) -> sps.csc_array:
        """svec of all LMIs: column 0 the constant, column i the coefficient of x[i - 1]."""
        return stacked(self.families, self.size + 1)

    @cached_property
    def matrix(self) -> sps.csc_array:
        """Columns of the unknowns, rows svec of all LMIs; it shares its memory with ``columns``."""
        columns = self.columns
        first = int(columns.indptr[1])
        inside = (columns.data[first:], columns.indices[first:], columns.indptr[1:] - first)
        return sps.csc_array(inside, shape=(columns.shape[0], self.size))

    @cached_property
    def offset(self) -> Array:
        """svec of all LMIs at x = 0."""
        columns = self.columns
        first = int(columns.indptr[1])
        dense = np.zeros(columns.shape[0])
        dense[columns.indices[:first]] = columns.data[:first]
        return dense

    def restricted(self, chosen: Array) -> ConicProblem:
        """The problem with only the LMIs numbered ``chosen`` (increasing), in the same unknowns."""
        families, start = [], 0
        for family in self.families:
            mine = chosen[(chosen >= start) & (chosen < start + len(family))] - start
            start += len(family)
            if len(mine):
                families.append(family.subset(mine))
        return replace(self, families=tuple(families))

    def label(self, index: int) -> str:
        """Name of the LMI number ``index``: performance, alpha: alpha1^2, alpha+: vertex 2."""
        for family in self.families:
            if index < len(family):
                return ", ".join([family.lmi.place.lmi, *family.label(index)])
            index -= len(family)
        raise IndexError(index)

    def _repr_html_(self) -> str:
        """Sizes and relaxations, for notebooks."""
        from lmic.pages.notebook import problem_html

        return problem_html(self)


def assemble(binding: Binding, families: list[LMIFamily], relaxation: Relaxation) -> ConicProblem:
    """The conic problem of a binding whose scalars are fixed and whose LMIs were relaxed so."""
    cost, constant = np.zeros(binding.layout.size), 0.0
    if binding.objective is not None:
        row = binding.objective.evaluate({s: np.array([v]) for s, v in binding.values.items()})[0, 0]
        cost, constant = row[1:], float(row[0])
    return ConicProblem(binding, tuple(families), cost, constant, relaxation)
