"""Stage 3, bind: plant data and the unknowns' bases enter; an LMI becomes Σ_m g_m(θ) F_m(x).

Each F_m(x) = F_m0 + Σ_i x_i F_mi is affine in the unknowns' coordinates x. All F_m share one
sparsity pattern, so the LMI is one sparse array: monomials x pattern.
"""

from __future__ import annotations

import operator
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, reduce
from typing import Any, TypeAlias

import numpy as np
import scipy.sparse as sps
import sympy as sp
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.algebra.polynomials import MatrixPolynomial, Monomials, row_polynomial, scalar_polynomial
from lmic.compiler.bases import Choice
from lmic.compiler.expand import Factor, Factors, Selector, Stacked, canonical
from lmic.compiler.layout import Layout, UnknownLayout, combination, make_layout
from lmic.compiler.parametric import ParametricLMI
from lmic.compiler.terms import Term, TermList, objective
from lmic.errors import DomainError, Place, PlantError
from lmic.faults import Checked, demand
from lmic.language.nodes import Inverse, Leaf
from lmic.language.parameters import Parameter, instance_symbol, rate_symbol
from lmic.language.theorem import Theorem
from lmic.memory import Kept
from lmic.plants.domains import Domain
from lmic.plants.plant import Plant, exact_number
from lmic.plants.sizes import solve_sizes

Array: TypeAlias = NDArray[Any]


@dataclass(frozen=True)
class Binding:
    """A theorem with a plant: the parametric LMIs, the layout of the unknowns, and the objective.

    ``objective`` and ``constant``: what is minimised is objective·x + constant, as polynomials in
    the given scalars; ``instances`` names, for every parameter, the instances that occur.
    """

    theorem: Theorem
    plant: Plant
    sizes: Mapping[sp.Symbol, int]
    layout: Layout
    lmis: Mapping[str, ParametricLMI]
    objective: MatrixPolynomial | None
    instances: Mapping[str, tuple[Parameter, ...]]
    domains: Mapping[str, Domain]
    values: Mapping[sp.Symbol, float] = field(default_factory=dict)

    def fixed(self, scalars: Mapping[str, Any]) -> Binding:
        """The binding with every given scalar and plant scalar set; nothing is compiled again."""
        values = scalar_values(self.theorem, self.plant, scalars)
        lmis = {name: lmi.fixed(values) for name, lmi in self.lmis.items()}
        return replace(self, lmis=lmis, values=values)


def bind(
    theorem: Theorem,
    term_lists: Mapping[str, TermList],
    plant: Plant,
    dependence: Mapping[str, Choice] | None = None,
    sizes: Mapping[str, int] | None = None,
) -> Binding:
    """Bind a plant's data and the dependence of the unknowns to a theorem's terms.

    ``dependence`` maps an unknown's name to a :data:`lmic.compiler.bases.Choice`; ``sizes`` fixes
    dimensions that no matrix of the plant determines. The given scalars stay symbolic.
    """
    shape = _shapes.get(
        theorem, _key(plant, dependence or {}, sizes or {}), lambda: _shape(theorem, plant, dependence, sizes)
    )
    binder = _Binder(theorem, plant, shape)
    return Binding(
        theorem=theorem,
        plant=plant,
        sizes=shape.sizes,
        layout=shape.layout,
        lmis={name: binder.lmi(terms) for name, terms in term_lists.items()},
        objective=shape.objective,
        instances={name: tuple(found) for name, found in theorem.parameters.items() if name in shape.domains},
        domains=shape.domains,
    )


def scalar_values(theorem: Theorem, plant: Plant, scalars: Mapping[str, Any]) -> dict[sp.Symbol, float]:
    """Values of all given scalars and plant scalars; raises for a missing or unknown one."""
    place = Place(theorem.name)
    wanted = {symbol.name for symbol in theorem.givens}
    both = sorted(wanted & set(plant.scalars))
    if both:
        raise PlantError(
            f"{both[0]} is a scalar of the theorem and of {plant.name}; rename it in the plant, or remove it there and "
            f"give the theorem's, as {both[0]}=1",
            place,
        )
    components = {c: name for name, domain in plant.domains.items() for c in domain.components}
    for scalar in sorted(wanted & set(components)):  # its value would take the place of the whole interval
        raise PlantError(
            f"{scalar} is a scalar of the theorem and a component of {components[scalar]} in {plant.name}; "
            "rename it in the plant",
            place,
        )
    unknown = sorted(set(scalars) - wanted - set(plant.scalars))
    if unknown:
        known = ", ".join(sorted(wanted | set(plant.scalars))) or "none"
        raise PlantError(
            f"{unknown[0]} is no scalar of the theorem or of {plant.name} (there are: {known}); correct the name", place
        )
    missing = sorted(wanted - set(scalars))
    if missing:
        sought = theorem.bisect is not None and theorem.bisect.scalar.name == missing[0]
        search = f", or an interval to search, as {missing[0]}=0:1" if sought else ""
        raise PlantError(f"the scalar {missing[0]} has no value; give it, as {missing[0]}=1{search}", place)
    return {sp.Symbol(name): float(exact_number(value)) for name, value in {**plant.scalars, **scalars}.items()}


def domains_of(theorem: Theorem, plant: Plant, place: Place) -> Checked[dict[str, Domain]]:
    """The domain of every parameter of the theorem; a plant without parameters is time-invariant."""
    domains: dict[str, Domain] = {}
    if not plant.domains:
        return domains
    for name, instances in theorem.parameters.items():
        if name not in plant.domains:
            known = ", ".join(plant.domains) or "no parameter"
            yield DomainError(
                f"the parameter {name} has no domain in {plant.name}, which has {known}; add it there", place
            )
            continue
        domain, required = plant.domains[name], instances[0].required
        if required and domain.kind != required:
            yield DomainError(
                f"{name} ranges over a {domain.kind} in {plant.name}, but the theorem is stated on a {required}; "
                "change the plant's domain",
                place,
            )
        domains[name] = domain
    return domains


#: rows, columns and coordinates of the entries of an unknown that may be nonzero, and its shape
_Places: TypeAlias = tuple[Array, Array, Array, tuple[int, int]]


# Numbers enter ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Entries:
    """Contributions to an LMI: value · monomials[monomial] in packed row, column (0: constant)."""

    monomials: Monomials
    monomial: Array
    row: Array
    column: Array
    value: Array


@dataclass(frozen=True)
class _Shape:
    """What plants of the same dimensions and domains have in common."""

    domains: Mapping[str, Domain]
    sizes: Mapping[sp.Symbol, int]
    layout: Layout
    objective: MatrixPolynomial | None
    known_sizes: dict[sp.Expr, int] = field(default_factory=dict)
    bases: dict[Leaf, MatrixPolynomial] = field(default_factory=dict)
    entries: dict[Factor, _Places] = field(default_factory=dict)

    def size(self, expression: sp.Expr) -> int:
        """Value of a symbolic size."""
        if expression not in self.known_sizes:
            self.known_sizes[expression] = int(expression.subs(self.sizes))
        return self.known_sizes[expression]


_shapes: Kept[_Shape] = Kept()


def _key(plant: Plant, dependence: Mapping[str, Choice], sizes: Mapping[str, int]) -> Hashable:
    """Everything of a plant and the choices that a :class:`_Shape` depends on."""
    chosen = tuple((name, _choice_key(choice)) for name, choice in sorted(dependence.items()))
    shapes = tuple((name, matrix.shape) for name, matrix in plant.matrices.items())
    return tuple(plant.domains.items()), shapes, frozenset(plant.ingredients), chosen, tuple(sorted(sizes.items()))


def _choice_key(choice: Choice) -> Hashable:
    """A choice by its text, and by its expressions where it has any."""
    listed = [] if isinstance(choice, str) or not isinstance(choice, Sequence) else choice
    return repr(choice), tuple(f for f in listed if isinstance(f, sp.Expr))


def _shape(
    theorem: Theorem, plant: Plant, dependence: Mapping[str, Choice] | None, sizes: Mapping[str, int] | None
) -> _Shape:
    place = Place(theorem.name)
    domains = demand(domains_of(theorem, plant, place))
    values = solve_sizes(theorem, plant, sizes or {}, place)
    layout = make_layout(theorem, domains, values, dependence or {}, place)
    return _Shape(domains, values, layout, _objective(theorem, layout))


def _objective(theorem: Theorem, layout: Layout) -> MatrixPolynomial | None:
    """What is minimised as a 1 x (1 + n) polynomial in the given scalars, constant first."""
    parts = demand(objective(theorem))
    if parts is None:
        return None
    row = {1 + layout.unknowns[scalar.name].offset: _plain(slope) for scalar, slope in parts[1].items()}
    return row_polynomial({0: _plain(parts[0]), **row}, 1 + layout.size)


@dataclass(frozen=True)
class _Binder:
    theorem: Theorem
    plant: Plant
    shape: _Shape
    cache: dict[Factor | Factors, MatrixPolynomial] = field(default_factory=dict)

    def size(self, expression: sp.Expr) -> int:
        return self.shape.size(expression)

    @property
    def domains(self) -> Mapping[str, Domain]:
        return self.shape.domains

    @property
    def layout(self) -> Layout:
        return self.shape.layout

    # data

    def factor(self, factor: Factor) -> MatrixPolynomial:
        """Value of a data factor."""
        if factor not in self.cache:
            value = self._matrix(factor.matrix)
            value = value.T if factor.transposed else value
            self.cache[factor] = value.kron_identity(self.size(factor.before), self.size(factor.after))
        return self.cache[factor]

    def product(self, factors: Factors) -> MatrixPolynomial | None:
        """Value of a product of data factors; None for the empty product."""
        if not factors:
            return None
        if factors not in self.cache:
            head = self.product(factors[:-1])
            last = self.factor(factors[-1])
            self.cache[factors] = last if head is None else head @ last
        return self.cache[factors]

    def _matrix(self, matrix: Leaf | Inverse | Selector | Stacked) -> MatrixPolynomial:
        match matrix:
            case Leaf():
                return self._data(matrix)
            case Selector():
                total, offset, size = (self.size(s) for s in (matrix.total, matrix.offset, matrix.size))
                return MatrixPolynomial.constant(np.eye(total)[:, offset : offset + size])
            case Stacked():
                return MatrixPolynomial.constant(np.eye(self.size(matrix.size)).reshape(-1, 1))
            case Inverse():
                parts = [
                    value.scaled(scalar_polynomial(_plain(coefficient)))
                    for factors, coefficient in canonical(matrix.nodes[0]).items()
                    if (value := self.product(factors))
                ]
                return reduce(operator.add, parts).inverse()
        raise TypeError(matrix)

    def _data(self, leaf: Leaf) -> MatrixPolynomial:
        """A matrix of the plant at the leaf's parameters."""
        value = self.plant.matrices[leaf.name].numeric()
        allowed = {
            sp.Symbol(c) for p in leaf.arguments if p.name in self.domains for c in self.domains[p.name].components
        }
        allowed |= {sp.Symbol(scalar) for scalar in self.plant.scalars}
        for atom in value.monomials.atoms:
            foreign = atom.free_symbols - allowed
            if foreign:
                raise PlantError(
                    f"the matrix {leaf.name} of {self.plant.name} depends on {min(map(str, foreign))}, but the theorem "
                    f"states it as {leaf}; remove the dependence or use a theorem that allows it",
                    Place(self.theorem.name),
                )
        return value.renamed(self.instances(leaf))

    def instances(self, leaf: Leaf) -> dict[sp.Symbol, sp.Symbol]:
        """Components now → components at the leaf's instances."""
        return {
            sp.Symbol(component): instance_symbol(component, parameter.instance)
            for parameter in leaf.arguments
            if parameter.instance and parameter.name in self.domains
            for component in self.domains[parameter.name].components
        }

    # unknowns

    def basis(self, leaf: Leaf) -> MatrixPolynomial:
        """Basis functions of an unknown (or their time derivatives) at its instance, 1 x B."""
        if leaf not in self.shape.bases:
            self.shape.bases[leaf] = self._basis(leaf)
        return self.shape.bases[leaf]

    def _basis(self, leaf: Leaf) -> MatrixPolynomial:
        functions = self.layout.unknowns[leaf.name].functions
        if leaf.derivative:
            components = [c for p in leaf.arguments if p.name in self.domains for c in self.domains[p.name].components]
            functions = tuple(
                sp.Add(*(sp.diff(f, sp.Symbol(c)) * rate_symbol(c) for c in components)) for f in functions
            )
        return combination(functions).renamed(self.instances(leaf))

    # LMIs

    def lmi(self, terms: TermList) -> ParametricLMI:
        """The numeric form of one LMI."""
        partition = tuple(self.size(size) for size in terms.partition)
        starts = np.concatenate([[0], np.cumsum(partition)])
        parts = [
            self.term(term, int(starts[i]), int(starts[j])) for (i, j), block in terms.blocks.items() for term in block
        ]
        stated = [part for part in parts if part.value.size]
        if not stated:
            raise PlantError("the LMI is zero for this plant, which is never definite; remove it", terms.place)
        return _collect(terms.place, partition, stated)

    def term(self, term: Term, top: int, start: int) -> _Entries:
        """Entries of one term in the block whose first entry is (top, start)."""
        scale = scalar_polynomial(_plain(term.coefficient))
        if isinstance(term.unknown, Factor):
            monomial, row, col, column, value, monomials = self._matrix_term(term.left, term.unknown, term.right)
        else:
            product = self.product(term.left)
            assert product is not None
            monomial, row, col = np.nonzero(product.coefficients)
            value, monomials = product.coefficients[monomial, row, col], product.monomials
            first = 0 if term.unknown is None else 1 + self.layout.unknowns[term.unknown.name].offset
            column = np.full(len(row), first)
        if top == start:  # a diagonal block: its upper triangle is enough
            keep = row <= col
            monomial, row, col, column, value = (a[keep] for a in (monomial, row, col, column, value))
        packed = svec.packed_index(top + row, start + col)
        return _scaled(scale, _Entries(monomials, monomial, packed, column, value))

    def _matrix_term(self, left: Factors, unknown: Factor, right: Factors) -> tuple[Any, ...]:
        """Nonzero entries of L·X·R over monomials, entries and coordinates of X."""
        assert isinstance(unknown.matrix, Leaf)
        layout = self.layout.unknowns[unknown.matrix.name]
        if unknown not in self.shape.entries:
            self.shape.entries[unknown] = _unknown_entries(unknown, layout, self.shape)
        entry_row, entry_col, coordinate, shape = self.shape.entries[unknown]
        basis = self.basis(unknown.matrix)
        outer = self.product(left) or MatrixPolynomial.constant(np.eye(shape[0]))
        inner = self.product(right) or MatrixPolynomial.constant(np.eye(shape[1]))
        # (M_left, p, entries) and (M_right, entries, s): the columns of L and rows of R that X's entries meet
        tall, wide = outer.coefficients[:, :, entry_row], inner.coefficients[:, entry_col, :]
        monomials = outer.monomials.times(inner.monomials)
        found = []
        for m_left in range(len(tall)):
            for m_right in range(len(wide)):
                product = tall[m_left][:, None, :] * wide[m_right].T[None, :, :]  # p x s x entries
                row, col, entry = np.nonzero(product)
                found.append(
                    (
                        np.full(len(row), m_left * len(wide) + m_right),
                        row,
                        col,
                        coordinate[entry],
                        product[row, col, entry],
                    )
                )
        monomial, row, col, coord, value = (np.concatenate(part) for part in zip(*found, strict=True))
        # every basis function repeats the entries in its own columns
        m_basis, _, function = np.nonzero(basis.coefficients)
        weight = basis.coefficients[m_basis, 0, function]
        column = 1 + layout.offset + function[:, None] * layout.count + coord[None, :]
        repeat = len(m_basis)
        return (
            (m_basis[:, None] * len(monomials) + monomial[None, :]).ravel(),
            np.tile(row, repeat),
            np.tile(col, repeat),
            column.ravel(),
            (weight[:, None] * value[None, :]).ravel(),
            basis.monomials.times(monomials),
        )


@lru_cache(maxsize=4096)
def _plain(expression: sp.Expr) -> sp.Expr:
    """Given scalars as plain symbols, so that they meet the plant's."""
    return expression.xreplace({s: sp.Symbol(s.name) for s in expression.free_symbols})


def _unknown_entries(unknown: Factor, layout: UnknownLayout, sizes: _Shape) -> _Places:
    """Rows, columns and coordinates of the nonzero entries of I ⊗ X ⊗ I, and its shape."""
    marked = (layout.coordinate.T if unknown.transposed else layout.coordinate) + 1
    marked = np.kron(np.eye(sizes.size(unknown.before), dtype=int), marked)
    marked = np.kron(marked, np.eye(sizes.size(unknown.after), dtype=int))
    rows, cols = np.nonzero(marked)
    return rows, cols, marked[rows, cols] - 1, (marked.shape[0], marked.shape[1])


def _scaled(scale: MatrixPolynomial, entries: _Entries) -> _Entries:
    """Entries times a scalar polynomial."""
    count = len(scale.monomials)
    factors = scale.coefficients[:, 0, 0]
    if not scale.monomials.atoms:
        return replace(entries, value=factors[0] * entries.value)
    return _Entries(
        scale.monomials.times(entries.monomials),
        (np.arange(count)[:, None] * len(entries.monomials) + entries.monomial[None, :]).ravel(),
        np.tile(entries.row, count),
        np.tile(entries.column, count),
        (factors[:, None] * entries.value[None, :]).ravel(),
    )


def _collect(place: Place, partition: tuple[int, ...], parts: Iterable[_Entries]) -> ParametricLMI:
    """One pattern and one sparse coefficient array of all entries."""
    parts = list(parts)
    atoms = tuple(sorted({atom for part in parts for atom in part.monomials.atoms}, key=str))
    stacked = Monomials(atoms, np.concatenate([part.monomials.over(atoms) for part in parts]))
    merged, inverse = stacked.merged()
    offsets = np.concatenate([[0], np.cumsum([len(part.monomials) for part in parts])])
    monomial = inverse[np.concatenate([part.monomial + offsets[k] for k, part in enumerate(parts)])]
    row = np.concatenate([part.row for part in parts])
    column = np.concatenate([part.column for part in parts])
    value = np.concatenate([part.value for part in parts])
    # column-major over (unknown, packed row): the order of the solver's columns
    span = svec.length(sum(partition))
    key, position = np.unique(column * span + row, return_inverse=True)
    coefficients = sps.coo_array((value, (monomial, position)), shape=(len(merged), len(key))).tocsr()
    return ParametricLMI(place, partition, merged, key % span, key // span, coefficients)
