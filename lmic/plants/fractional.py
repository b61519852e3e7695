"""Linear and nonlinear fractional transformations: a polynomial plant as one that is affine in α.

Write a plant's equations as the rows and its signals u (state, disturbance) as the columns of a
block matrix M(α), polynomial in α on a simplex. The model

    M(α) = M_0(α) + B_Δ(α) Δ(α) (I − D_Δz Δ(α))⁻¹ C_Δ,   w_Δ = Δ z_Δ,   z_Δ = C_Δ u + D_Δz w_Δ,

is affine in α. LFT (linear): M_0 and B_Δ are constant, and every power of α passes through Δ. NFT
(nonlinear, Chen and Fong 2006): M_0 and B_Δ are affine, which leaves less to Δ.

A monomial is spelled as a word, its letters in order: α_1² α_3 is the word 113. Then M(α) is the sum
of α^word M_word(α), where M_word is constant (LFT), or has the monomial's last letter (NFT). Each
word and each of its prefixes takes one block of channels for its signal, as wide as that signal:

    w_word = α_last z_word,   z_word = w_prefix, or the signal itself where the prefix is empty,

so that w_word = α^word u. Hence M_0 is M_word of the empty word, B_Δ the row of all other M_word,
Δ = diag(α_last I), C_Δ has an identity at each word of one letter, and D_Δz one at each pair of word
and prefix. D_Δz Δ is nilpotent, so that the inverse exists everywhere and is a polynomial.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import accumulate, chain
from typing import Any, TypeAlias

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from lmic.algebra.polynomials import MatrixPolynomial, Monomials
from lmic.errors import PlantError
from lmic.plants.domains import SimplexDomain
from lmic.plants.expressions import quoted
from lmic.plants.plant import Plant

Array: TypeAlias = NDArray[Any]
#: places of components of α, ascending
Word: TypeAlias = tuple[int, ...]

#: for each model, the degree in α of M_0 and B_Δ
MODELS: Mapping[str, int] = {"lft": 0, "nft": 1}

MAX_CHANNELS = 200  # rows of Δ
MAX_COEFFICIENTS = 10**7  # of a matrix by which Δ's output enters


@dataclass(frozen=True)
class FractionalForm:
    """Which model to build, a key of MODELS, and the names of the matrices.

    ``system`` is the block matrix of the plant in this model, an equation in each row and a signal
    in each column, the signal w_Δ and the equation of z_Δ last::

        [["A",       "B",   "B_Delta"],
         ["C",       "D",   "D_Delta"],
         ["C_Delta", "D_z", "D_Delta_z"]]

    Its last row and column are made, like ``delta``; the other matrices are the plant's.
    """

    model: str
    system: tuple[tuple[str, ...], ...]
    delta: str

    def __post_init__(self) -> None:
        if self.model not in MODELS:
            raise PlantError(f"the model {quoted(self.model)} is unknown; use one of {', '.join(sorted(MODELS))}")
        lengths = {len(row) for row in self.system}
        if len(self.system) < 2 or len(lengths) != 1 or min(lengths) < 2:
            raise PlantError("system is no block matrix; give two or more rows with equally many names, at least two")
        repeated, count = Counter([*chain(*self.system), self.delta]).most_common(1)[0]
        if count > 1:
            raise PlantError(f"the name {repeated} stands in {count} places; use each name once")

    @property
    def stated(self) -> Array:
        """Names of the plant's matrices, shape (equations, signals)."""
        return np.array([row[:-1] for row in self.system[:-1]], dtype=object)

    @property
    def entering(self) -> tuple[str, ...]:
        """Names of the matrices by which w_Δ enters the equations (B_Δ)."""
        return tuple(row[-1] for row in self.system[:-1])

    @property
    def taken(self) -> tuple[str, ...]:
        """Names of the matrices by which z_Δ takes the signals (C_Δ)."""
        return self.system[-1][:-1]

    @property
    def feedback(self) -> str:
        """Name of D_Δz."""
        return self.system[-1][-1]


def fractional_plant(plant: Plant, form: FractionalForm, simplex: SimplexDomain) -> Plant:
    """The NFT or LFT model of a plant that is polynomial in the components of a simplex.

    Exact for any degree and mixed monomials. Coefficients may depend on scalars and on other
    parameters; B_Δ then does. Polynomials are taken as written: Σα = 1 is not used to shorten them.
    Where no word is left to Δ, as in the NFT model of an affine plant, one channel of zeros stands for it.

    Raises PlantError where a matrix is missing, is not polynomial in α or does not fit its row or
    column, where a matrix that is made is already there, and where Δ grows beyond MAX_CHANNELS.
    """
    stated = form.stated
    _check_names(plant, form)
    _check_shapes(plant, stated)
    degree = MODELS[form.model]
    spelled = {name: _spelled(name, plant.matrices[name], simplex, degree) for name in stated.flat}
    channels = _channels(
        [[word for name in names for word in spelled[name].words] for names in stated.T],
        [plant.matrices[name].shape[1] for name in stated[0]],
    )
    rows = zip(form.entering, stated, strict=True)
    made = {
        **{name: _entering(name, [spelled[part] for part in parts], channels) for name, parts in rows},
        **{name: channels.taken(signal) for signal, name in enumerate(form.taken)},
        form.feedback: channels.feedback(),
        form.delta: channels.delta(simplex),
    }
    kept = {name: matrix.of_no_word() for name, matrix in spelled.items()}
    return replace(plant, matrices={**plant.matrices, **kept, **made})


def _check_names(plant: Plant, form: FractionalForm) -> None:
    for name in form.stated.flat:
        if name not in plant.matrices:
            has = ", ".join(plant.matrices) or "none"
            raise PlantError(f"{name} is no matrix of the plant, which has {has}; state it, or correct the name")
    for name in (*form.entering, *form.taken, form.feedback, form.delta):
        if name in plant.matrices:
            raise PlantError(f"{name} is to be made, but the plant states it already; remove or rename one of them")


def _check_shapes(plant: Plant, stated: Array) -> None:
    for (equation, signal), name in np.ndenumerate(stated):
        found = plant.matrices[name].shape
        for axis, (beside, what) in enumerate(((stated[equation, 0], "rows"), (stated[0, signal], "columns"))):
            expected = plant.matrices[beside].shape[axis]
            if found[axis] != expected:
                raise PlantError(
                    f"{name} has {found[axis]} {what} where {beside} in the same {what[:-1]} of system has "
                    f"{expected}; make them agree"
                )


# Monomials as words -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Spelled:
    """A matrix as Σ_m α^words[m] · rest[m] · coefficients[m]."""

    words: tuple[Word, ...]
    rest: Monomials
    coefficients: Array

    def of_no_word(self) -> MatrixPolynomial:
        """The part of the empty word."""
        places = [m for m, word in enumerate(self.words) if not word]
        if not places:
            return MatrixPolynomial.constant(_zeros(*self.coefficients.shape[1:]))
        rest = Monomials(self.rest.atoms, self.rest.exponents[places])
        return MatrixPolynomial(rest, self.coefficients[places]).merged()


def _spelled(name: str, matrix: MatrixPolynomial, simplex: SimplexDomain, degree: int) -> _Spelled:
    """Every monomial as a word times a rest, which keeps at most ``degree`` letters."""
    used = (matrix.coefficients != 0).any(axis=(1, 2))
    atoms, exponents = matrix.monomials.atoms, matrix.monomials.exponents[used]
    letter = {sp.Symbol(component): place for place, component in enumerate(simplex.components)}
    for column, atom in enumerate(atoms):
        if atom not in letter and atom.free_symbols & set(letter) and exponents[:, column].any():
            raise PlantError(
                f"{name} is not polynomial: it holds {quoted(str(atom))}; write it as a polynomial in "
                f"{', '.join(simplex.components[:2])}{', ...' if len(simplex.components) > 2 else ''}"
            )
    columns = sorted((column for column, atom in enumerate(atoms) if atom in letter), key=lambda c: letter[atoms[c]])
    rest, words = exponents.copy(), []
    for m, powers in enumerate(exponents[:, columns]):
        spelling = np.repeat(np.array(columns, dtype=int), powers)
        length = max(len(spelling) - degree, 0)
        np.subtract.at(rest[m], spelling[:length], 1)
        words.append(tuple(letter[atoms[column]] for column in spelling[:length]))
    return _Spelled(tuple(words), Monomials(atoms, rest), matrix.coefficients[used])


# Channels of Δ ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Channels:
    """Rows of w_Δ and z_Δ: for each signal, a block at ``blocks[signal][word]``, ``widths[signal]`` wide."""

    blocks: tuple[Mapping[Word, slice], ...]
    widths: tuple[int, ...]
    count: int

    def taken(self, signal: int) -> MatrixPolynomial:
        """C_Δ of a signal."""
        matrix = _zeros(self.count, self.widths[signal])
        for word, block in self.blocks[signal].items():
            if len(word) == 1:
                np.fill_diagonal(matrix[block], Fraction(1))
        return MatrixPolynomial.constant(matrix)

    def feedback(self) -> MatrixPolynomial:
        """D_Δz."""
        matrix = _zeros(self.count, self.count)
        for blocks in self.blocks:
            for word, block in blocks.items():
                if len(word) > 1:
                    np.fill_diagonal(matrix[block, blocks[word[:-1]]], Fraction(1))
        return MatrixPolynomial.constant(matrix)

    def delta(self, simplex: SimplexDomain) -> MatrixPolynomial:
        """Δ(α)."""
        letters = sorted({word[-1] for blocks in self.blocks for word in blocks})
        if not letters:
            return MatrixPolynomial.constant(_zeros(self.count, self.count))
        matrices = _zeros(len(letters), self.count, self.count)
        for blocks in self.blocks:
            for word, block in blocks.items():
                np.fill_diagonal(matrices[letters.index(word[-1]), block, block], Fraction(1))
        atoms = [sp.Symbol(simplex.components[letter]) for letter in letters]
        return MatrixPolynomial(Monomials.of(*atoms), matrices)


def _channels(words: Sequence[Sequence[Word]], widths: Sequence[int]) -> _Channels:
    """Blocks for each signal's words and all their prefixes, in order; one channel where there is no word."""
    closed = [sorted({word[:end] for word in found for end in range(1, len(word) + 1)}) for found in words]
    sizes = [width for found, width in zip(closed, widths, strict=True) for _ in found]
    if sum(sizes) > MAX_CHANNELS:
        raise PlantError(
            f"Δ would have {sum(sizes)} channels, one block for each monomial and signal; keep to {MAX_CHANNELS} "
            "by polynomials of fewer monomials or lower degree"
        )
    slices = (slice(end - size, end) for size, end in zip(sizes, accumulate(sizes), strict=True))
    blocks = tuple({word: next(slices) for word in found} for found in closed)
    return _Channels(blocks, tuple(widths), max(sum(sizes), 1))


def _entering(name: str, parts: Sequence[_Spelled], channels: _Channels) -> MatrixPolynomial:
    """B_Δ of one equation: side by side M_word of every signal and word."""
    atoms = tuple(sorted({atom for part in parts for atom in part.rest.atoms}, key=str))
    rests = Monomials(atoms, np.concatenate([part.rest.over(atoms) for part in parts]))
    entries = [
        (blocks.get(word), coefficient)
        for part, blocks in zip(parts, channels.blocks, strict=True)
        for word, coefficient in zip(part.words, part.coefficients, strict=True)
    ]
    left = [m for m, (block, _) in enumerate(entries) if block is not None]
    rows = parts[0].coefficients.shape[1]
    if not left:
        return MatrixPolynomial.constant(_zeros(rows, channels.count))
    monomials, inverse = Monomials(atoms, rests.exponents[left]).merged()
    if len(monomials) * rows * channels.count > MAX_COEFFICIENTS:
        raise PlantError(f"{name} would have more than {MAX_COEFFICIENTS} coefficients; use fewer monomials")
    coefficients = _zeros(len(monomials), rows, channels.count)
    for monomial, m in zip(inverse, left, strict=True):
        block, coefficient = entries[m]
        coefficients[monomial, :, block] = coefficient
    return MatrixPolynomial(monomials, coefficients)


def _zeros(*shape: int) -> Array:
    return np.full(shape, Fraction(0), dtype=object)
