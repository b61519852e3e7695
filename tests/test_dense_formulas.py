"""Every LMI of the library equals an independent dense formula at random numbers.

The values are those of the named matrices as they stand in the statement, ``P(rho+)`` or
``dot(P(rho))``, and nothing of a plant, a basis or a relaxation takes part.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from types import SimpleNamespace as Values
from typing import Any

import dense_formulas as dense
import dense_maps as maps
import dense_standard as known
import numpy as np
import pytest
import sympy as sp
from dense_maps import Array
from numpy.linalg import inv

from lmic import library
from lmic.compiler.lower import lower_lmi
from lmic.errors import Place
from lmic.language.nodes import Leaf
from lmic.language.theorem import Theorem
from lmic.recover.evaluate import evaluate


@dataclass(frozen=True)
class Case:
    """Values of what a theorem's statement names, and what its LMIs must be there.

    ``dissipation`` is the form whose Schur complement an LMI is, with the way back from the LMI;
    ``design`` gives pairs (found, expected) from the recovered matrices.
    """

    sizes: Mapping[str, int]
    leaves: Mapping[str, Array]
    scalars: Mapping[str, float]
    lmis: Mapping[str, Array]
    dissipation: tuple[Callable[[Array], Array], Array] | None = None
    design: Callable[[Mapping[str, Array]], tuple[Array, Array]] | None = None

    def stated(self, theorem: Theorem, name: str) -> Array:
        """The LMI as printed, evaluated block by block."""
        lmi = lower_lmi(theorem.lmis[name], Place(theorem.name, name))
        sizes = self.symbols(theorem)
        starts = np.cumsum([0, *(int(size.subs(sizes)) for size in lmi.partition)])
        upper = np.zeros((starts[-1], starts[-1]))
        for (i, j), node in lmi.blocks.items():
            block = evaluate(node, lambda leaf: self.leaves[str(leaf)], self.scalars, sizes)
            upper[starts[i] : starts[i + 1], starts[j] : starts[j + 1]] = block
            upper[starts[j] : starts[j + 1], starts[i] : starts[i + 1]] = block.T
        return lmi.sense * upper

    def recovered(self, theorem: Theorem) -> dict[str, Array]:
        sizes = self.symbols(theorem)
        return {
            key: evaluate(node, lambda leaf: self.leaves[str(leaf)], self.scalars, sizes)
            for key, node in theorem.recover.items()
        }

    def symbols(self, theorem: Theorem) -> dict[sp.Symbol, int]:
        found = set().union(*(size.free_symbols for node in theorem.nodes for x in node.leaves() for size in x.shape))
        return {symbol: self.sizes[symbol.name] for symbol in found}


@dataclass(frozen=True)
class Random:
    """Random matrices from one generator."""

    generator: np.random.Generator

    def matrix(self, rows: int, columns: int) -> Array:
        return self.generator.standard_normal((rows, columns))

    def positive(self, n: int) -> Array:
        root = self.matrix(n, n + 2)
        return root @ root.T + 0.3 * np.eye(n)

    def symmetric(self, n: int) -> Array:
        root = self.matrix(n, n)
        return root + root.T

    def named(self, shapes: Mapping[str, tuple[int, int]]) -> Values:
        return Values(**{name: self.matrix(*shape) for name, shape in shapes.items()})


def at(place: str, values: Values) -> dict[str, Array]:
    """Leaves ``A(rho)`` … of the values in a namespace."""
    return {f"{name}({place})": value for name, value in vars(values).items()}


def transfer(*systems: tuple[Array, Array, Array, Array]) -> tuple[Array, Array]:
    """Transfer functions at a few points."""
    first, second = (
        np.array([C @ inv(z * np.eye(len(A)) - A) @ B + D for z in (9.0, 12.0 + 3j, -20.0)]) for A, B, C, D in systems
    )
    return first, second


def transfer_2d(*systems: tuple[Array, ...]) -> tuple[Array, Array]:
    """Transfer functions of Fornasini–Marchesini systems at a few points."""
    points = ((0.1, 0.03), (0.02 + 0.1j, -0.05))
    first, second = (
        np.array([C @ inv(np.eye(len(A1)) - x * A1 - y * A2) @ (x * B1 + y * B2) for x, y in points])
        for A1, A2, B1, B2, C in systems
    )
    return first, second


# One function per group of theorems ----------------------------------------------------------------


def delay_lpv(random: Random) -> dict[str, Case]:
    n, m, p, nw = 3, 2, 2, 4
    sizes = {"n": n, "m": m, "p": p, "l": nw}
    plant = random.named(
        {"A": (n, n), "A_d": (n, n), "B": (n, nw), "C": (m, n), "C_d": (m, n), "D": (m, nw)}
        | {"H": (p, n), "H_d": (p, n), "L": (p, nw)}
    )
    f = random.named({"A_F": (n, n), "B_F": (n, m), "C_F": (p, n), "D_F": (p, m)})
    P, following, Q = random.positive(2 * n), random.positive(2 * n), random.positive(n)
    W, delay, gamma2 = random.matrix(2 * n, 2 * n), 3.0, 2.7
    scalars = {"gamma2": gamma2, "d_Delta": delay}
    leaves = at("rho", plant) | at("rho", f) | {"P(rho)": P, "P(rho+)": following, "Q": Q, "W": W}

    def analysis(matrix: Array, **more: Any) -> Case:
        return Case(sizes, leaves, scalars, {"performance": matrix}, **more)

    matrix, u = dense.delay_theorem3(plant, f, P, following, Q, W, delay, gamma2)
    T = np.block([[np.eye(n), np.eye(n)], [np.zeros((n, n)), u.S]])
    new = {name: getattr(u, name) for name in ("P_1", "P_2", "P_3", "Ahat_F", "Bhat_F", "Chat_F", "Dhat_F")}
    unknowns = at("rho", Values(**new)) | {"Q": Q, "E": u.E, "F": u.F, "U": u.U}
    unknowns |= {f"{name}(rho+)": getattr(u, f"{name}_next") for name in ("P_1", "P_2", "P_3")}
    return {
        "theorem1": analysis(
            dense.delay_theorem1(plant, f, P, following, Q, delay, gamma2),
            dissipation=(
                lambda lmi: maps.eliminate(lmi, 2 * n + p),
                dense.delay_dissipation(plant, f, P, following, Q, delay, gamma2),
            ),
        ),
        "theorem2": analysis(dense.delay_theorem2(plant, f, P, following, Q, W, delay, gamma2)),
        "corollary1": analysis(dense.no_delay_theorem(plant, f, P, following, gamma2)),
        "corollary2": analysis(dense.no_delay_theorem(plant, f, P, following, gamma2, W)),
        "theorem3": Case(
            sizes,
            at("rho", plant) | unknowns,
            scalars,
            {"performance": matrix, "P": T.T @ P @ T},
            design=lambda found: transfer(
                (found["A_F"], found["B_F"], found["C_F"], found["D_F"]), (f.A_F, f.B_F, f.C_F, f.D_F)
            ),
        ),
    }


def wu2007(random: Random) -> dict[str, Case]:
    n, m, q, nw = 3, 2, 2, 2
    sizes = {"n": n, "m": m, "q": q, "l": nw}
    data = {"A_1": (n, n), "A_2": (n, n), "B_1": (n, nw), "B_2": (n, nw), "C": (m, n), "D": (m, nw), "L": (q, n)}
    filters = {"A_1F": (n, n), "A_2F": (n, n), "B_1F": (n, m), "B_2F": (n, m), "C_F": (q, n)}
    a, b = random.named(data | filters), random.named(data | filters)
    P_a, P_b, P_c, Q_a, Q_b = (random.positive(2 * n) for _ in range(5))
    X, gamma2 = random.matrix(2 * n, 2 * n), 1.9
    scalars = {"gamma2": gamma2}
    both = at("r[a]", a) | at("r[b]", b)
    lyapunov = {"P(r[a])": P_a, "P(r[b])": P_b, "P(r[c])": P_c, "Q(r[a])": Q_a, "Q(r[b])": Q_b}
    analysis = both | lyapunov | {"X": X}
    u, G = dense.fm_unknowns(a, b, X), dense.fm_congruence(X)
    synthesis = {key: value for key, value in both.items() if not key.partition("(")[0].endswith("F")}
    synthesis |= {"U": u.U, "V": u.V, "W": u.W, "Abar_1F(r[a])": u.Abar_1F, "Abar_2F(r[b])": u.Abar_2F}
    synthesis |= {"Bbar_1F(r[a])": u.Bbar_1F, "Bbar_2F(r[b])": u.Bbar_2F}
    synthesis |= {"Cbar_F(r[a])": u.Cbar_F_a, "Cbar_F(r[b])": u.Cbar_F_b}
    synthesis |= {f"{key[0]}bar{key[1:]}": G.T @ value @ G for key, value in lyapunov.items()}
    synthesis |= {"Abar_1F(r)": u.Abar_1F, "Abar_2F(r)": u.Abar_2F, "Bbar_1F(r)": u.Bbar_1F, "Bbar_2F(r)": u.Bbar_2F}
    synthesis |= {"Cbar_F(r)": u.Cbar_F_a}
    order = [2 * n, q, q, 2 * n, 2 * n, nw, nw]

    def design(found: Mapping[str, Array]) -> tuple[Array, Array]:
        filters = (found["A_1F"], found["A_2F"], found["B_1F"], found["B_2F"], found["C_F"])
        return transfer_2d(filters, (a.A_1F, b.A_2F, a.B_1F, b.B_2F, a.C_F))

    peak = dense.fm_peak(a, b, P_a, P_b, gamma2)
    energy6, peak6 = dense.fm_theorem6(a, b, P_a, P_b, P_c, Q_a, Q_b, gamma2, X)
    return {
        "theorem1": Case(
            sizes,
            analysis,
            scalars,
            {"performance": dense.fm_theorem1(a, b, P_a, P_c, Q_a, Q_b, gamma2)},
            dissipation=(
                lambda lmi: maps.eliminate(maps.reorder(lmi, order, [3, 4, 5, 6, 0, 1, 2]), 2 * n + 2 * q),
                dense.fm_dissipation(a, b, P_a, P_c, Q_a, Q_b, gamma2),
            ),
        ),
        "theorem2": Case(
            sizes, analysis, scalars, {"performance": dense.fm_theorem1(a, b, P_a, P_c, Q_a, Q_b, gamma2, X)}
        ),
        "theorem3": Case(
            sizes,
            synthesis,
            scalars,
            {"performance": dense.fm_theorem3(a, b, P_a, P_c, Q_a, Q_b, gamma2, X)},
            design=design,
        ),
        "theorem4": Case(
            sizes, analysis, scalars, {"energy": dense.fm_theorem4(a, b, P_a, P_c, Q_a, Q_b), "peak": peak}
        ),
        "theorem5": Case(
            sizes, analysis, scalars, {"energy": dense.fm_theorem4(a, b, P_a, P_c, Q_a, Q_b, X), "peak": peak}
        ),
        "theorem6": Case(sizes, synthesis, scalars, {"energy": energy6, "peak": peak6}, design=design),
    }


def chen2006(random: Random) -> dict[str, Case]:
    nx, nw, ny, nz, nd = 2, 3, 2, 1, 2
    sizes = {"nx": nx, "nw": nw, "ny": ny, "nz": nz, "nd": nd}
    p = random.named(
        dict.fromkeys(("A_1", "A_2", "A_d1", "A_d2"), (nx, nx))
        | {"B_1": (nx, nw), "B_2": (nx, nw), "B_Delta_1": (nx, nd), "B_Delta_2": (nx, nd), "C_Delta": (nd, nx)}
        | {"D_Delta_z": (nd, nd), "D_z": (nd, nw), "C": (ny, nx), "D_Delta": (ny, nd), "D": (ny, nw), "L": (nz, nx)}
        | {"Delta": (nd, nd)}
    )
    filters = {"A_f1": (nx, nx), "A_f2": (nx, nx), "B_f1": (nx, ny), "B_f2": (nx, ny), "C_f": (nz, nx)}
    f = random.named(filters)
    hats = random.named({f"{name[0]}hat{name[1:]}": shape for name, shape in filters.items()})
    gamma, mu, eps = 1.7, 2.3, 0.35
    scalars = {"gamma": gamma, "mu": mu, "epsilon": eps}
    small: Any = [random.positive(nx) for _ in range(4)]
    P: Any = [random.positive(2 * nx) for _ in range(4)]
    X: Any = [random.positive(2 * nx) for _ in range(4)]
    H, J = random.matrix(2 * nx, 2 * nx), random.matrix(2 * nx, 2 * nx)
    slack: Any = [random.matrix(nx, nx) for _ in range(3)]
    multipliers: dict[str, Array] = {}
    for k, size in ((1, 2 * nd), (2, nd), (3, 2 * nd)):
        multipliers |= {f"E_{k}(alpha)": random.positive(size), f"F_{k}(alpha)": -random.positive(size)}
        multipliers |= {f"V_{k}": random.matrix(size, size), f"K_{k}": random.matrix(size, size)}
    E, F = ([multipliers[f"{s}_{k}(alpha)"] for k in (1, 2, 3)] for s in "EF")
    V, K = ([multipliers[f"{s}_{k}"] for k in (1, 2, 3)] for s in "VK")

    def lyapunov(hat: str) -> dict[str, Array]:
        names = ("P", "Q"), ("X", "Y")
        return {
            f"{name}{hat}_{k + 1}(alpha)": values[2 * i + k]
            for pair, values in zip(names, (P, X), strict=True)
            for i, name in enumerate(pair)
            for k in (0, 1)
        }

    analysis = at("alpha", p) | vars(f) | multipliers | lyapunov("") | {"H": H, "J": J}
    synthesis = at("alpha", p) | vars(hats) | multipliers | lyapunov("hat")
    synthesis |= {f"{s}hat_{k + 1}": slack[k] for s in "HJ" for k in range(3)}
    uncertainty = [dense.nft_uncertainty(p.Delta, *m) for m in zip(E, F, V, strict=True)]
    state: Any = ((1 - eps) / 2, None)
    peak: Any = (eps, mu)
    h_infinity = dense.nft_synthesis(p, hats, *P, E[0], F[0], slack, K[0], gamma, gamma)
    energy = {
        "output_uncertainty": uncertainty[1],
        "state_uncertainty": uncertainty[2],
        "output": dense.nft_synthesis_output(p, hats, *X, E[1], F[1], slack, K[1], *peak),
        "state": dense.nft_synthesis(p, hats, *X, E[2], F[2], slack, K[2], *state),
    }

    def design(found: Mapping[str, Array]) -> tuple[Array, Array]:
        expected = vars(dense.nft_unknowns(*slack, hats)[0])
        first, second = (np.concatenate([m[key].ravel() for key in sorted(found)]) for m in (found, expected))
        return first, second

    return {
        "theorem1": Case(
            sizes,
            vars(p) | dict(zip(("P_1", "P_2", "Q_1", "Q_2"), small, strict=True)),
            scalars,
            {"W": dense.nft_theorem1(p, *small)},
        ),
        "lemma1": Case(
            sizes,
            analysis,
            scalars,
            {
                "uncertainty": uncertainty[0],
                "performance": dense.nft_performance(p, f, *P, E[0], F[0], H, K[0], gamma, gamma),
            },
        ),
        "lemma2": Case(
            sizes,
            analysis,
            scalars,
            {
                "output_uncertainty": uncertainty[1],
                "state_uncertainty": uncertainty[2],
                "output": dense.nft_output(p, f, *X, E[1], F[1], K[1], *peak),
                "state": dense.nft_performance(p, f, *X, E[2], F[2], J, K[2], *state),
            },
        ),
        "theorem4": Case(
            sizes, synthesis, scalars, {"uncertainty": uncertainty[0], "performance": h_infinity}, design=design
        ),
        "theorem5": Case(sizes, synthesis, scalars, energy, design=design),
        "theorem6": Case(
            sizes,
            synthesis,
            scalars,
            {"h_infinity_uncertainty": uncertainty[0], "h_infinity": h_infinity, **energy},
            design=design,
        ),
    }


def mustafa(random: Random) -> dict[str, Case]:
    n, m, r, s = 3, 2, 2, 1
    sizes = {"n": n, "m": m, "r": r, "s": s}
    p = random.named({"A": (n, n), "B": (n, m), "Phi": (n, n), "Gamma": (n, m), "C": (r, n), "D": (r, m), "L": (s, n)})
    f = random.named({"A_f": (n, n), "B_f": (n, r), "C_f": (s, n)})
    P, gamma2 = random.positive(2 * n), 2.1
    scalars = {"gamma2": gamma2}
    data = vars(p) | {"Phi(h)": p.Phi, "Gamma(h)": p.Gamma}

    def step(x: Array, w: Array) -> tuple[Array, Array]:
        return dense.sampled_step(p, f, x, w)

    def dissipated(x: Array, w: Array) -> float:
        following, error = step(x, w)
        return float(following @ inv(P) @ following - x @ inv(P) @ x + error @ error - gamma2 * w @ w)

    def back(lmi: Array) -> Array:
        turned = maps.reorder(lmi, [2 * n, s, 2 * n, m], [2, 3, 0, 1])
        return maps.congruence(maps.eliminate(turned, 2 * n + s), inv(P), np.eye(m))

    def synthesis(formula: Callable[..., tuple[Array, Values]]) -> Case:
        matrix, unknowns = formula(p, f, P, gamma2)
        zero = np.zeros((s, r))
        return Case(
            sizes,
            data | vars(unknowns),
            scalars,
            {"performance": matrix},
            design=lambda found: transfer(
                (found["A_f"], found["B_f"], found["C_f"], zero), (f.A_f, f.B_f, f.C_f, zero)
            ),
        )

    return {
        "lemma1": Case(
            sizes,
            data | vars(f) | {"Pbar": P},
            scalars,
            {"performance": dense.sampled_analysis(step, (2 * n, m), P, gamma2)},
            dissipation=(back, maps.quadratic_form(dissipated, (2 * n, m))),
        ),
        "theorem3": synthesis(dense.sampled_theorem3),
        "robust_performance": synthesis(dense.sampled_robust_performance),
    }


def standard(random: Random) -> dict[str, Case]:
    n, nw, nu, nz, ny = 3, 2, 2, 2, 1
    sizes = {"n": n, "nw": nw, "nu": nu, "nz": nz, "ny": ny}
    p = random.named({"A": (n, n), "B_w": (n, nw), "B_u": (n, nu), "C_z": (nz, n), "D_zw": (nz, nw), "D_zu": (nz, nu)})
    A, B, C, D = p.A, p.B_w, p.C_z, p.D_zw
    C_y, K, L, G = random.matrix(ny, n), random.matrix(nu, n), random.matrix(n, ny), random.matrix(n, n)
    P, following, rate, Z = random.positive(n), random.positive(n), random.symmetric(n), random.positive(nw)
    beta, gamma, mu, index = 0.7, 1.6, 2.2, 0.4
    shared = at("rho", p) | {"B(rho)": B, "C(rho)": C, "D(rho)": D, "Z(rho)": Z, "G": G, "G(rho)": G}
    for name in "PQS":
        shared |= {f"{name}(rho)": P, f"{name}(rho+)": following, f"dot({name}(rho))": rate}

    def case(leaves: Mapping[str, Array] | None = None, **lmis: Array) -> Case:
        return Case(sizes, {**shared, **(leaves or {})}, {"beta": beta, "gamma": gamma, "mu": mu, "nu": index}, lmis)

    def stored(x: Array, w: Array) -> float:
        step, z = A @ x + B @ w, C @ x + D @ w
        return float(step @ following @ step - x @ P @ x + z @ z / gamma - gamma * w @ w)

    trace = np.array([[mu - np.trace(Z)]])
    bounded_real = known.bounded_real_discrete(A, B, C, D, P, following, gamma)
    by_P, by_G = ({"B(rho)": p.B_u, "Y(rho)": K @ slack} for slack in (P, G))
    measured = {"C(rho)": C_y}
    return {
        "stability_continuous": case(decrease=known.lyapunov_continuous(A, P, rate)),
        "stability_discrete": case(decrease=known.lyapunov_discrete(A, P, following)),
        "decay_rate_continuous": case(decrease=known.lyapunov_continuous(A, P, rate, beta)),
        "decay_rate_discrete": case(decrease=known.lyapunov_discrete(A, P, following, beta)),
        "stability_slack_deoliveira": case(decrease=known.slack_stability(A, P, G)),
        "stability_poly_daafouz": case(decrease=known.slack_poly_stability(A, P, following, G)),
        "bounded_real_continuous": case(dissipation=known.bounded_real_continuous(A, B, C, D, P, rate, gamma)),
        "bounded_real_discrete": Case(
            sizes,
            shared,
            {"gamma": gamma},
            {"dissipation": bounded_real},
            dissipation=(lambda lmi: -maps.eliminate(lmi, n + nz), maps.quadratic_form(stored, (n, nw))),
        ),
        "passivity_continuous": case(passivity=known.passivity_continuous(A, B, C, D, P, rate, index)),
        "passivity_discrete": case(passivity=known.passivity_discrete(A, B, C, D, P, following, index)),
        "generalised_h2_continuous": case(
            energy=known.energy_continuous(A, B, P, rate), peak=known.peak(P, C, None, mu)
        ),
        "generalised_h2_discrete": case(energy=known.energy_discrete(A, B, P, following), peak=known.peak(P, C, D, mu)),
        "h2_continuous": case(
            energy=known.h2_continuous(A, C, P, rate), impulse=known.h2_trace(B, None, P, Z), trace=trace
        ),
        "h2_discrete": case(
            energy=known.h2_discrete(A, C, P, following), impulse=known.h2_trace(B, D, following, Z), trace=trace
        ),
        "state_feedback_continuous": case(by_P, decrease=known.state_feedback_continuous(A, p.B_u, K, P, rate)),
        "state_feedback_discrete": case(by_P, decrease=known.state_feedback_discrete(A, p.B_u, K, P, following, P)),
        "state_feedback_slack_discrete": case(
            by_G, decrease=known.state_feedback_discrete(A, p.B_u, K, P, following, G)
        ),
        "state_feedback_hinf_continuous": case(
            by_P, dissipation=known.state_feedback_hinf_continuous(p, K, P, rate, gamma)
        ),
        "state_feedback_hinf_discrete": case(
            by_G, dissipation=known.state_feedback_hinf_discrete(p, K, P, following, G, gamma)
        ),
        "observer_continuous": case(
            measured | {"Z(rho)": P @ L}, decrease=known.observer_continuous(A, C_y, L, P, rate)
        ),
        "observer_discrete": case(
            measured | {"Z(rho)": G @ L}, decrease=known.observer_discrete(A, C_y, L, P, following, G)
        ),
    }


GROUPS: dict[str, Callable[[Random], dict[str, Case]]] = {
    "delay_lpv": delay_lpv,
    "wu2007": wu2007,
    "chen2006": chen2006,
    "mustafa": mustafa,
    "standard": standard,
}


@cache
def case(name: str, seed: int) -> Case:
    group, _, theorem = name.partition(".")
    return GROUPS[group](Random(np.random.default_rng(seed)))[theorem]


# peixoto2025 is printed whole and compared in test_square
NAMES = [name for name in library.files() if name.partition(".")[0] in GROUPS]


def is_sign(theorem: Theorem, lmi: str) -> bool:
    """An LMI that only says that one unknown is definite."""
    rows = theorem.lmis[lmi].rows
    return len(rows) == 1 and isinstance(rows[0][0], Leaf)


def agree(found: Array, expected: Array, tolerance: float = 1e-9) -> None:
    assert found.shape == expected.shape
    assert np.abs(found - expected).max() <= tolerance * np.abs(expected).max()


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("name", NAMES)
def test_statement_equals_dense_formula(name: str, seed: int) -> None:
    theorem, numbers = library.theorem(name), case(name, seed)
    assert set(numbers.lmis) | {lmi for lmi in theorem.lmis if is_sign(theorem, lmi)} == set(theorem.lmis)
    for lmi, expected in numbers.lmis.items():
        agree(numbers.stated(theorem, lmi), expected)


@pytest.mark.parametrize("name", [name for name in NAMES if case(name, 1).dissipation])
def test_schur_complement_is_the_dissipation(name: str) -> None:
    """Nothing is forgotten in what the LMI was lifted from: storage, supply and outputs."""
    numbers = case(name, 1)
    assert numbers.dissipation is not None
    back, expected = numbers.dissipation
    agree(back(numbers.stated(library.theorem(name), next(iter(numbers.lmis)))), expected)


@pytest.mark.parametrize("name", [name for name in NAMES if case(name, 1).design])
def test_recovered_filter_is_the_one_of_the_congruence(name: str) -> None:
    numbers = case(name, 1)
    assert numbers.design is not None
    agree(*numbers.design(numbers.recovered(library.theorem(name))), tolerance=1e-8)
