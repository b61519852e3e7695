"""Recession: unknowns that may grow without end at no cost, and the face that they leave to the dual matrices.

Where the linear part G(d) of F is positive semidefinite and c·d = 0, every dual matrix has ⟨G(d), Z⟩ = 0. None is
positive definite then, and solvers lose their digits. With the columns of V spanning the null space of
G(d), Z = V W Vᵀ lies on a face of the cone, and the problem is that of the compressed LMIs VᵀF(x)V ⪰ 0:
fewer unknowns, the same optimum, and an interior on the dual side too (facial reduction: Borwein and
Wolkowicz, J. Austral. Math. Soc. A 30, 1981). A strictly feasible point of it comes back to all of F by a
step that evens out what lies between the face and its complement, and by a multiple of d.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
import scipy.linalg
import scipy.sparse as sps
from numpy.typing import NDArray

from lmic.algebra import svec
from lmic.algebra.integer_bases import free_rows, integer_complement
from lmic.solve.cone import ConeData, ConeSolver
from lmic.solve.lineality import Lineality, lineality
from lmic.solve.scaling import initial, slack_matrices

Array: TypeAlias = NDArray[Any]

#: the traces of all G(d) sum up to 1: eigenvalues above the first are growth, between the two is no clear answer.
#: Beside growth, what is zero to 1e-10 may show off its diagonal as the root of that
GROWTH, NO_GROWTH = 1e-4, 1e-5
#: denominators of the null space that are looked for, and how near its entries have to be to such fractions: a
#: direction is known to the root of the solver's tolerance
DENOMINATOR, NEAR = 8, 2e-3
#: how far the direction may move, relative to its length, to leave the face alone exactly
MOVED = 1e-2
#: rank of the equations for that, relative
RANK = 1e-10
#: what the multiple of d exceeds the least one by
BEYOND = 2.0


@dataclass(frozen=True)
class Face:
    """One reduction: a direction ``ray`` of the unknowns, and an integer V for each LMI that grows along it.

    ``whole`` is the problem, ``compressed`` that of VᵀFV in all its unknowns.
    """

    whole: ConeData
    ray: Array
    bases: tuple[Array | None, ...]
    compressed: ConeData
    seen: Lineality

    @cached_property
    def core(self) -> ConeData:
        """The compressed problem without LMIs that grow as a whole, in independent unknowns."""
        kept, orders = self.seen.kept, self.compressed.orders
        cost, matrix = self.compressed.cost[kept], self.compressed.matrix[:, kept]
        return replace(self.compressed, cost=cost, matrix=matrix, orders=orders[orders > 0])

    def dual(self, packed: Array) -> Array:
        """svec of V W Vᵀ for every LMI, from that of W."""
        parts = []
        for order, base, matrix in zip(
            self.whole.orders, self.bases, slack_matrices(packed, self.compressed.orders), strict=True
        ):
            spread = matrix if base is None else base @ matrix @ base.T
            rows, cols = svec.triangle(int(order))
            parts.append(spread[rows, cols] * svec.weights(int(order)))
        return np.concatenate(parts)

    def lifted(self, x: Array) -> Array:
        """A point strictly inside all cones from one of ``core`` strictly inside its own.

        The step that the face does not see brings VᵀFU near zero, in the metric of VᵀFV, with the unit
        vectors U that complete V. Then UᵀFU is raised along the ray until it outweighs the rest. Raises
        LinAlgError where the core's point is not inside.
        """
        found = np.zeros(len(self.whole.cost))
        found[self.seen.kept] = x
        matrices = slack_matrices(self.whole.matrix @ found + self.whole.offset, self.whole.orders)
        rows, right = [], []
        for across, base, matrix in zip(self._across, self.bases, matrices, strict=True):
            if base is not None and base.shape[1]:
                root = np.linalg.cholesky(base.T @ matrix @ base)
                n, m = len(root), across.shape[0] // len(root)
                columns = across.reshape(n, m * across.shape[1])
                rows.append(scipy.linalg.solve_triangular(root, columns, lower=True).reshape(n * m, -1))
                rest = base.T @ matrix[:, _complement(base)]
                right.append(scipy.linalg.solve_triangular(root, rest, lower=True).ravel())
        if rows:
            found += self._unseen @ np.linalg.lstsq(np.concatenate(rows), -np.concatenate(right), rcond=RANK)[0]
        return found + self._multiple(found) * self.ray

    def _multiple(self, x: Array) -> float:
        """How much of the ray brings x inside all cones."""
        whole = self.whole
        needed = 0.0
        for base, matrix, growth in zip(
            self.bases,
            slack_matrices(whole.matrix @ x + whole.offset, whole.orders),
            slack_matrices(whole.matrix @ self.ray, whole.orders),
            strict=True,
        ):
            if base is not None:
                out = _complement(base)
                across = base.T @ matrix[:, out]
                short = across.T @ np.linalg.solve(base.T @ matrix @ base, across) - matrix[np.ix_(out, out)]
                short = (short + short.T) / 2
                needed = max(needed, scipy.linalg.eigh(short, growth[np.ix_(out, out)], eigvals_only=True)[-1])
        return BEYOND * needed

    @cached_property
    def _unseen(self) -> sps.csc_array:
        """Columns that span the directions which ``compressed`` does not see."""
        out, kept = self.seen.left_out, self.seen.kept
        columns = np.zeros((len(self.whole.cost), len(out)))
        columns[out, np.arange(len(out))] = 1.0
        columns[kept] = -self.seen.combinations
        columns[np.abs(columns) < RANK] = 0.0
        return sps.csc_array(columns / np.linalg.norm(columns, axis=0))

    @cached_property
    def _across(self) -> list[Array]:
        """VᵀGU along each unseen direction, row by row in the first axis."""
        return _across(self.whole, self.bases, self._unseen)


@dataclass(frozen=True)
class Reduction:
    """Faces one within the other; ``core`` is what remains to be solved."""

    faces: tuple[Face, ...]

    @property
    def core(self) -> ConeData:
        """The problem on the innermost face."""
        return self.faces[-1].core

    @cached_property
    def bases(self) -> tuple[Array | None, ...]:
        """V of the innermost face for every LMI of the problem; it has no columns where an LMI grows as a whole."""
        found = list(self.faces[0].bases)
        for face in self.faces[1:]:
            left = [k for k, outer in enumerate(found) if outer is None or outer.shape[1]]
            for k, inner in zip(left, face.bases, strict=True):
                outer = found[k]
                found[k] = inner if outer is None else outer if inner is None else outer @ inner
        return tuple(found)

    def matrices(self, packed: Array) -> list[Array]:
        """W for every LMI of the problem, from svec of the core's; none has rows where an LMI grows as a whole."""
        orders = self.faces[0].whole.orders
        sizes = [n if base is None else base.shape[1] for n, base in zip(orders, self.bases, strict=True)]
        return slack_matrices(packed, np.array(sizes))

    def dual(self, packed: Array) -> Array:
        """svec of the dual matrices of the problem, from that of the core's."""
        for face in reversed(self.faces):
            packed = face.dual(packed)
        return packed

    def lifted(self, x: Array) -> Array:
        """A point strictly inside all cones of the problem, from one of the core strictly inside its own.

        Raises LinAlgError where the core's point is not.
        """
        for face in reversed(self.faces):
            x = face.lifted(x)
        return x


def reduction(data: ConeData, solver: ConeSolver) -> Reduction | None:
    """The faces of a problem whose columns are independent; None where nothing may grow, or no face is found."""
    faces: list[Face] = []
    current = data
    while len(current.orders) and (found := _face(current, solver)) is not None:
        faces.append(found)
        current = found.core
    return Reduction(tuple(faces)) if faces and len(current.orders) else None


def _face(data: ConeData, solver: ConeSolver) -> Face | None:
    """The face of the direction in which most LMIs grow in most of their directions; None where there is none."""
    ray = _ray(data, solver)
    if ray is None:
        return None
    bases = []
    for matrix in slack_matrices(data.matrix @ ray, data.orders):
        values, vectors = np.linalg.eigh(matrix)
        grows = values > GROWTH
        if (values[~grows] > NO_GROWTH).any():
            return None
        base = None
        if grows.any() and (base := integer_complement(vectors[:, grows].T, DENOMINATOR, NEAR)) is None:
            return None
        bases.append(base)
    compressed = _compressed(data, bases)
    face = Face(data, ray, tuple(bases), compressed, lineality(compressed.matrix))
    return _exact(face)


def _ray(data: ConeData, solver: ConeSolver) -> Array | None:
    """A direction of largest rank along which all G(d) are positive semidefinite at no cost.

    An interior point solver that maximises a bounded sum of traces ends in the middle of all such directions.
    """
    identity = np.concatenate([svec.identity(int(order)) for order in data.orders])
    traces = data.matrix.T @ identity
    cost = data.cost / np.linalg.norm(data.cost)
    problem = ConeData(
        -traces,
        sps.csc_array(sps.vstack([data.matrix, sps.csc_array(-traces[None, :]), sps.csc_array(-cost[None, :])])),
        np.concatenate([np.zeros(len(data.offset)), [1.0, 0.0]]),
        np.concatenate([data.orders, [1, 1]]),
    )
    scaled, transform = initial(problem)
    answer = solver(scaled)
    found = transform.x(answer.y)
    return found if np.isfinite(found).all() and traces @ found > 0.5 else None


def _exact(face: Face) -> Face | None:
    """With the ray moved so that G(d)V = 0 to rounding; None where it moves far or the rest does not grow."""
    coordinates = np.linalg.lstsq(face._unseen.toarray(), face.ray, rcond=None)[0]
    across = np.concatenate(face._across)
    coordinates -= np.linalg.lstsq(across, across @ coordinates, rcond=RANK)[0]
    ray = face._unseen @ coordinates
    if np.linalg.norm(ray - face.ray) > MOVED * np.linalg.norm(face.ray):
        return None
    for base, growth in zip(face.bases, slack_matrices(face.whole.matrix @ ray, face.whole.orders), strict=True):
        if base is not None:
            out = _complement(base)
            if np.linalg.eigvalsh(growth[np.ix_(out, out)])[0] <= 0:
                return None
    return replace(face, ray=ray)


def _complement(base: Array) -> Array:
    """Rows whose unit vectors complete V."""
    return np.setdiff1d(np.arange(len(base)), free_rows(base))


def _compressed(data: ConeData, bases: list[Array | None]) -> ConeData:
    maps = [
        sps.eye_array(svec.length(int(order))) if base is None else _folded(base) @ _products(base, base)
        for order, base in zip(data.orders, bases, strict=True)
    ]
    every = sps.csr_array(sps.block_diag(maps, format="csr"))
    orders = np.array([n if base is None else base.shape[1] for n, base in zip(data.orders, bases, strict=True)])
    return ConeData(data.cost, sps.csc_array(every @ data.matrix), every @ data.offset, orders)


def _across(data: ConeData, bases: tuple[Array | None, ...], directions: sps.csc_array) -> list[Array]:
    """VᵀGU along each of the directions: rows the entries, row by row; no rows for an LMI without a face."""
    found, start = [], 0
    for order, base in zip(map(int, data.orders), bases, strict=True):
        end = start + svec.length(order)
        if base is None:
            found.append(np.zeros((0, directions.shape[1])))
        else:
            units = np.eye(order, dtype=int)[:, _complement(base)]
            found.append((_products(base, units) @ (data.matrix[start:end] @ directions)).toarray())
        start = end
    return found


def _products(left: Array, right: Array) -> sps.csr_array:
    """The map from svec(F) to the entries of leftᵀ F right, row by row."""
    order = len(left)
    rows, cols = svec.triangle(order)
    off = rows != cols
    entries = np.arange(len(rows))
    places = np.concatenate([rows * order + cols, (cols * order + rows)[off]])
    values = 1 / svec.weights(order)
    spread = sps.csr_array(
        (np.concatenate([values, values[off]]), (places, np.concatenate([entries, entries[off]]))),
        shape=(order * order, len(rows)),
    )
    return sps.csr_array(sps.kron(sps.csr_array(left.T), sps.csr_array(right.T), format="csr") @ spread)


def _folded(base: Array) -> sps.csr_array:
    """The map from all entries of a symmetric matrix to its svec."""
    order = base.shape[1]
    rows, cols = svec.triangle(order)
    return sps.csr_array(
        (svec.weights(order), (np.arange(len(rows)), rows * order + cols)), shape=(len(rows), order * order)
    )
