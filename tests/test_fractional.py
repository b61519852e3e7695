"""NFT and LFT models: the closed form is the polynomial, exactly, and Δ has no more channels than it needs."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import isqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from flint import fmpq, fmpq_mat

from lmic.algebra.polynomials import MatrixPolynomial, homogeneous_exponents
from lmic.errors import PlantError
from lmic.plants.domains import BoxDomain, SimplexDomain
from lmic.plants.files import read_plant
from lmic.plants.fractional import MAX_CHANNELS, MAX_COEFFICIENTS, FractionalForm, fractional_plant
from lmic.plants.plant import Plant

NAMES = (("A", "B", "B_Delta"), ("C", "D", "D_Delta"), ("C_Delta", "D_z", "D_Delta_z"))
SIZES = {"A": (3, 3), "B": (3, 2), "C": (1, 3), "D": (1, 2)}


def polynomial_plant(seed: int, vertices: int, degree: int) -> Plant:
    """Random sparse polynomials with rational coefficients, mixed monomials among them."""
    generator = np.random.default_rng(seed)
    simplex = SimplexDomain.named("alpha", vertices)
    symbols = [sp.Symbol(name) for name in simplex.components]
    powers = np.concatenate([homogeneous_exponents(vertices, d).astype(int) for d in range(degree + 1)])

    def entry() -> sp.Expr:
        chosen = powers[generator.choice(len(powers), size=2)]
        values = generator.integers(-9, 10, size=2)
        return sp.Add(
            *(
                sp.Rational(int(value), 7) * sp.Mul(*(s ** int(p) for s, p in zip(symbols, row, strict=True)))
                for value, row in zip(values, chosen, strict=True)
            )
        )

    matrices = {
        name: MatrixPolynomial.from_sympy(sp.Matrix(*shape, lambda i, j: entry())) for name, shape in SIZES.items()
    }
    return Plant(matrices, {"alpha": simplex})


def at(matrix: MatrixPolynomial, point: dict[sp.Symbol, Fraction]) -> Any:
    """Exact value."""
    total = np.full(matrix.shape, Fraction(0), dtype=object)
    for row, coefficient in zip(matrix.monomials.exponents.tolist(), matrix.coefficients, strict=True):
        weight = Fraction(1)
        for atom, power in zip(matrix.monomials.atoms, row, strict=True):
            weight *= point[atom] ** power
        total = total + weight * coefficient
    return total


def flint(matrix: Any) -> fmpq_mat:
    return fmpq_mat([[fmpq(v.numerator, v.denominator) for v in row] for row in matrix.tolist()])


def closed_form(plant: Plant, rows: tuple[tuple[str, ...], ...], point: dict[sp.Symbol, Fraction]) -> Any:
    """M_0 + B_Δ Δ (I − D_Δz Δ)⁻¹ C_Δ by exact arithmetic, independently of how the model was made."""

    def block(names: Any) -> fmpq_mat:
        return flint(np.block([[at(plant.matrices[name], point) for name in row] for row in names]))

    nominal, entering = block([row[:-1] for row in rows[:-1]]), block([[row[-1]] for row in rows[:-1]])
    taken, feedback, delta = block([rows[-1][:-1]]), block([[rows[-1][-1]]]), block([["Delta"]])
    one = fmpq_mat(
        delta.nrows(), delta.nrows(), [int(i == j) for i in range(delta.nrows()) for j in range(delta.nrows())]
    )
    return nominal + entering * delta * (one - feedback * delta).inv() * taken


@pytest.mark.parametrize("model", ["nft", "lft"])
@pytest.mark.parametrize(("vertices", "degree"), [(2, 1), (2, 2), (2, 4), (3, 2), (3, 3), (4, 2)])
def test_the_closed_form_is_the_polynomial(model: str, vertices: int, degree: int) -> None:
    for seed in range(3):
        plant = polynomial_plant(seed, vertices, degree)
        simplex = plant.domains["alpha"]
        assert isinstance(simplex, SimplexDomain)
        built = fractional_plant(plant, FractionalForm(model, NAMES, "Delta"), simplex)
        assert all(built.matrices[row[-1]].monomials.exponents.sum(axis=1).max() <= 1 for row in NAMES)
        # the identity holds off the simplex as well
        values = np.random.default_rng(seed).integers(-5, 9, size=vertices)
        point = {
            sp.Symbol(name): Fraction(int(value), 6) for name, value in zip(simplex.components, values, strict=True)
        }
        expected = np.block([[at(plant.matrices[name], point) for name in row] for row in (("A", "B"), ("C", "D"))])
        assert closed_form(built, NAMES, point) == flint(expected)


def rows_plant(vertices: int, **matrices: Any) -> Plant:
    """A plant of rows of expressions on the simplex alpha."""
    polynomials = {name: MatrixPolynomial.from_sympy(sp.Matrix(rows)) for name, rows in matrices.items()}
    return Plant(polynomials, {"alpha": SimplexDomain.named("alpha", vertices)})


SMALL = (("A", "E"), ("F", "H"))


def shown(plant: Plant, model: str, system: tuple[tuple[str, ...], ...] = SMALL) -> dict[str, sp.Matrix]:
    """The matrices of the model as expressions."""
    simplex = plant.domains["alpha"]
    assert isinstance(simplex, SimplexDomain)
    built = fractional_plant(plant, FractionalForm(model, system, "Delta"), simplex)
    return {name: matrix.to_sympy() for name, matrix in built.matrices.items()}


def test_monomials_share_their_prefixes() -> None:
    """In the NFT model α1² α2, α1² α3 and α1² need the words 1 and 11; in the LFT model 112, 113 and 3 as well."""
    plant = rows_plant(3, A=[["alpha1**2*alpha2 + 5*alpha1**2*alpha3 - alpha1**2 + 2*alpha3 + 7"]])
    one, two, three = sp.symbols("alpha1:4")
    nft, lft = shown(plant, "nft"), shown(plant, "lft")
    assert nft["A"] == sp.Matrix([[7 + 2 * three]])
    assert nft["E"] == sp.Matrix([[-one, two + 5 * three]])
    assert nft["Delta"] == sp.diag(one, one)
    assert nft["F"] == sp.Matrix([1, 0])
    assert nft["H"] == sp.Matrix([[0, 0], [1, 0]])
    assert lft["A"] == sp.Matrix([[7]])
    assert lft["E"] == sp.Matrix([[0, -1, 1, 5, 2]])
    assert lft["Delta"] == sp.diag(one, one, two, three, three)
    assert lft["F"] == sp.Matrix([1, 0, 0, 0, 1])


def test_only_the_signals_that_need_channels_take_them() -> None:
    """A state of three that enters linearly, and a disturbance of two that enters by a square."""
    plant = rows_plant(2, A=sp.eye(3) * sp.Symbol("alpha1"), B=[[0, 0], [0, "alpha1**2"], [0, 0]])
    built = shown(plant, "nft", (("A", "B", "E"), ("F", "G", "H")))
    assert built["Delta"] == sp.eye(2) * sp.Symbol("alpha1")
    assert built["E"] == sp.Matrix([[0, 0], [0, "alpha1"], [0, 0]])
    assert built["F"] == sp.zeros(2, 3)
    assert built["G"] == sp.eye(2)


def test_components_beyond_the_ninth_are_in_order() -> None:
    plant = rows_plant(11, A=[["alpha2*alpha10 + 3*alpha11**2"]])
    built = shown(plant, "lft")
    assert built["Delta"] == sp.diag(*sp.symbols("alpha2 alpha10 alpha11 alpha11"))
    assert built["E"] == sp.Matrix([[0, 1, 0, 3]])


@pytest.mark.parametrize("model", ["nft", "lft"])
def test_coefficients_may_depend_on_scalars_and_other_parameters(model: str) -> None:
    entry = sp.sympify("c*alpha1**2*alpha2 + sin(rho1)*alpha2**2 + rho1*alpha1 + c**2")
    plant = rows_plant(2, A=[[entry]])
    box = BoxDomain(("rho1",), (Fraction(-1),), (Fraction(1),))
    built = shown(replace(plant, domains={**plant.domains, "rho": box}, scalars={"c": Fraction(3)}), model)
    delta = built["Delta"]
    loop = built["E"] * delta * (sp.eye(delta.rows) - built["H"] * delta).inv() * built["F"]
    assert sp.expand((built["A"] + loop)[0] - entry) == 0
    assert {str(s) for s in built["E"].free_symbols} >= {"c", "rho1"}


@pytest.mark.parametrize(("model", "entry"), [("nft", "1 + 2*alpha1"), ("nft", "0"), ("lft", "1"), ("lft", "0")])
def test_one_channel_of_zeros_stands_for_no_uncertainty(model: str, entry: str) -> None:
    built = shown(rows_plant(2, A=[[entry]]), model)
    assert built["A"] == sp.Matrix([[entry]])
    assert all(built[name] == sp.zeros(1, 1) for name in ("E", "F", "H", "Delta"))


def test_a_vertex_of_zeros_takes_no_channel() -> None:
    assert shown(Plant.polytopic(A=[[[0]], [[2]], [[0]]]), "lft")["Delta"] == sp.Matrix([["alpha2"]])


def test_too_many_channels_are_refused() -> None:
    most, more = (sp.Matrix([sum(sp.symbols(f"alpha1:{count + 1}"))]) for count in (MAX_CHANNELS, MAX_CHANNELS + 1))
    assert shown(rows_plant(MAX_CHANNELS, A=most), "lft")["Delta"].shape == (MAX_CHANNELS, MAX_CHANNELS)
    with pytest.raises(PlantError, match=f"Δ would have {MAX_CHANNELS + 1} channels.* keep to {MAX_CHANNELS} by"):
        shown(rows_plant(MAX_CHANNELS + 1, A=more), "lft")


def test_too_many_coefficients_are_refused_before_they_are_made() -> None:
    """As many rows as powers of c, beside a monomial that fills Δ."""
    rows = isqrt(MAX_COEFFICIENTS // MAX_CHANNELS) + 1
    c, alpha1 = sp.symbols("c alpha1")
    plant = rows_plant(
        1, A=[[c**row * alpha1] for row in range(rows)], B=sp.ones(rows, 1) * alpha1 ** (MAX_CHANNELS - 1)
    )
    with pytest.raises(PlantError, match=f"E would have more than {MAX_COEFFICIENTS} coefficients; use fewer"):
        shown(plant, "lft", (("A", "B", "E"), ("F", "G", "H")))


GOOD = """[parameters.alpha]
simplex = 2
[matrices]
A = [["alpha1**2"]]
B = [[1]]
[fractional]
model = "nft"
system = [["A", "B", "E"], ["F", "G", "H"]]
delta = "Delta"
"""


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"nft"', '"nfl"', "the model 'nfl' is unknown; use one of lft, nft"),
        ('["A", "B", "E"]', '["A", "X", "E"]', "X is no matrix of the plant"),
        ('"Delta"', '"E"', "the name E stands in 2 places"),
        ('["F", "G", "H"]', '["F", "G"]', "system is no block matrix"),
        ('[["A", "B", "E"], ["F", "G", "H"]]', '[["A", "B", "E"]]', "system is no block matrix"),
        ('[["A", "B", "E"], ["F", "G", "H"]]', '[["A"], ["F"]]', "system is no block matrix"),
        ('[["A", "B", "E"], ["F", "G", "H"]]', "[]", "system is no block matrix"),
        ('[["A", "B", "E"], ["F", "G", "H"]]', '["A", "E"]', "system is ['A', 'E']; give a list of rows"),
        ('["F", "G", "H"]', '["F", "G", "H-1"]', "'H-1' cannot be a name"),
        ("B = [[1]]", "B = [[1], [2]]", "B has 2 rows where A"),
        ("B = [[1]]", "B = [[1]]\nE = [[1]]", "E is to be made, but the plant states it already"),
        ('"alpha1**2"', '"sin(alpha1)"', "A is not polynomial: it holds 'sin(alpha1)'"),
        ('"alpha1**2"', '"1/alpha2"', "A is not polynomial: it holds '1/alpha2'"),
        ("simplex = 2", "box = { alpha1 = [0, 1] }", "fractional: has polynomials without a simplex"),
        ('delta = "Delta"', 'delta = "Delta"\nparameter = "beta"', "without a simplex; add parameter = one of: alpha"),
        ('"alpha1**2"', '"alpha1**50"', None),
        ("delta =", "dleta =", "the key 'dleta' means nothing here"),
        ('delta = "Delta"', "", "the key delta is missing"),
        ('model = "nft"', "model = 1", "1 is not a name"),
    ],
)
def test_wrong_tables_are_explained(old: str, new: str, message: str | None, tmp_path: Path) -> None:
    file = tmp_path / "plant.toml"
    file.write_text(GOOD.replace(old, new))
    if message is None:
        assert read_plant(file).matrices["Delta"].shape == (49, 49)
        return
    with pytest.raises(PlantError) as error:
        read_plant(file)
    assert message in str(error.value).replace('"', "'")
