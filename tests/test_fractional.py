"""NFT and LFT models: the closed form is the polynomial, exactly; the printed models come out."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp
from flint import fmpq, fmpq_mat

from lmic.domains import SimplexDomain
from lmic.errors import PlantError
from lmic.library import root
from lmic.plants.files import read_plant
from lmic.plants.fractional import FractionalForm, fractional_plant
from lmic.plants.plant import Plant
from lmic.polynomials import MatrixPolynomial
from lmic.relax.polya import homogeneous_exponents

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


def library_plant(name: str) -> Plant:
    return read_plant(root() / "chen2006" / f"{name}.toml")


def vertex(plant: Plant, name: str, number: int) -> Any:
    symbols = [sp.Symbol(component) for component in plant.domains["alpha"].components]
    return at(plant.matrices[name], {s: Fraction(int(k == number)) for k, s in enumerate(symbols)}).astype(float)


# (56): the squares' coefficients Γ_4, Γ_5, Γ_6 and the vertices Γ_0 + Γ_j
SQUARES = [[[0.02, 0.06], [0.01, 0]], [[0.05, 0], [0.01, 0.08]], [[0.02, 0.05], [0.01, 0.06]]]
CORNERS = [[[0.02, 0.2], [0, 0.16]], [[-0.02, 0.2], [0, 0.16]], [[0, 0.2], [0, 0.16]]]


def test_the_nft_model_is_the_printed_one() -> None:
    """(57)-(59): at vertex j, A_1 = Γ_0 + Γ_j, block j of B_Δ1 is Γ_{3+j}, and Δ = e_j e_jᵀ ⊗ I."""
    plant = library_plant("example1_nft")
    for j in range(3):
        np.testing.assert_allclose(vertex(plant, "A_1", j), CORNERS[j], atol=1e-15)
        entering = np.zeros((2, 6))
        entering[:, 2 * j : 2 * j + 2] = SQUARES[j]
        np.testing.assert_allclose(vertex(plant, "B_Delta_1", j), entering, atol=1e-15)
        np.testing.assert_allclose(vertex(plant, "Delta", j), np.kron(np.diag(np.eye(3)[j]), np.eye(2)))
    np.testing.assert_allclose(vertex(plant, "C_Delta", 0), np.tile(np.eye(2), (3, 1)))
    assert not vertex(plant, "D_Delta_z", 0).any()


def test_the_lft_model_has_the_printed_size() -> None:
    """(60)-(62): two blocks of two channels for each of α_1, α_2, α_3."""
    plant = library_plant("example1_lft")
    assert plant.matrices["Delta"].shape == (12, 12)
    for name in ("A_1", "A_2", "B_Delta_1", "B_Delta_2"):
        assert not plant.matrices[name].monomials.atoms


def test_an_affine_plant_keeps_one_channel_of_zeros() -> None:
    plant = library_plant("example1_no_delay")
    assert plant.matrices["Delta"].shape == (1, 1)
    assert not (plant.matrices["Delta"].coefficients != 0).any()


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
        ("B = [[1]]", "B = [[1], [2]]", "B has 2 rows where A"),
        ("B = [[1]]", "B = [[1]]\nE = [[1]]", "E is to be made, but the plant states it already"),
        ('"alpha1**2"', '"sin(alpha1)"', "A is not polynomial"),
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
