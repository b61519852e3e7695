"""Plant files: the same plant from every format, with exact numbers."""

from __future__ import annotations

import json
import struct
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from plant_file_tools import (
    CONSTANT,
    TOML,
    VERTICES,
    described,
    document,
    mat_array,
    mat_header,
    write,
    write_mat,
    write_npz,
)

from lmic.algebra.polynomials import MatrixPolynomial, Monomials
from lmic.certify.document import same_plant
from lmic.errors import PlantError
from lmic.plants.domains import BoxDomain, Motion, SimplexDomain
from lmic.plants.files import read_plant
from lmic.plants.plant import Plant, exact_number

PAPER = Path(__file__).parents[1] / "theorems" / "peixoto2025"


# What is read ----------------------------------------------------------------------------------------


def test_the_four_formats_agree(tmp_path: Path) -> None:
    texts = {"name": "two vertices", "source": "made up", "parameter": "beta"}
    stacks = {name: np.array(vertices) for name, vertices in VERTICES.items()}
    tables = document(
        name="two vertices",
        source="made up",
        matrices={name: {"vertices": vertices} for name, vertices in VERTICES.items()} | {"C": CONSTANT},
    )
    matlab = {name: np.moveaxis(stack, 0, -1) for name, stack in stacks.items()}
    plants = [
        read_plant(write(tmp_path / "plant.toml", TOML)),
        read_plant(write(tmp_path / "plant.json", json.dumps(tables))),
        read_plant(write_npz(tmp_path / "plant.npz", **stacks, C=np.array(CONSTANT), **texts)),
        read_plant(write_mat(tmp_path / "plant.mat", **matlab, C=np.array(CONSTANT), **texts)),
    ]
    assert all(described(plant) == described(plants[0]) for plant in plants)
    expected = Plant.polytopic(parameter="beta", C=CONSTANT, **VERTICES)
    assert described(plants[0])["matrices"] == described(expected)["matrices"]
    assert plants[0].domains == {"beta": SimplexDomain(("beta1", "beta2"))}


def test_everything_that_a_text_file_may_state(tmp_path: Path) -> None:
    plant = read_plant(
        write(
            tmp_path / "full.toml",
            """
            [parameters.rho]
            box = { rho1 = [-1, 1], rho2 = [0, "1/3"] }
            rate = { rho1 = 0.1, rho2 = [-2, 3] }
            [parameters.alpha]
            simplex = 2
            step = "free"
            [parameters.beta]
            simplex = 1
            step = 0.25
            [scalars]
            c = 10
            d = "1/7"
            [matrices]
            A = [["1 + 0.5*rho1", "sin(rho2)"], [0, "c*alpha1"]]
            B = { vertices = [[["-0.05*c"]], [[0.3]]], parameter = "alpha" }
            K = { vertices = [[["c/4"]]], parameter = "beta" }
            """,
        )
    )
    assert plant.name == "full"
    assert plant.source == ""
    assert plant.scalars == {"c": Fraction(10), "d": Fraction(1, 7)}
    assert plant.domains == {
        "rho": BoxDomain(("rho1", "rho2"), (Fraction(-1), Fraction(0)), (Fraction(1), Fraction(1, 3))),
        "alpha": SimplexDomain(("alpha1", "alpha2")),
        "beta": SimplexDomain(("beta1",)),
    }
    assert plant.motions == {
        "rho": Motion(rate={"rho1": Fraction(1, 10), "rho2": (Fraction(-2), Fraction(3))}),
        "alpha": Motion(step="free"),
        "beta": Motion(step={"beta1": Fraction(1, 4)}),
    }
    rho1, rho2, alpha1, alpha2, c = sp.symbols("rho1 rho2 alpha1 alpha2 c")
    point = {rho1: 0.5, rho2: 0.25, alpha1: 0.75, alpha2: 0.25, c: 4.0}
    assert plant.matrices["A"].evaluate(point)[0] == pytest.approx(np.array([[1.25, np.sin(0.25)], [0, 3]]))
    assert plant.matrices["B"].evaluate(point)[0] == pytest.approx(np.array([[0.75 * -0.2 + 0.25 * 0.3]]))
    assert plant.matrices["K"].monomials.atoms == (c,)


def test_the_library_s_plants_go_by_name() -> None:
    assert same_plant(read_plant("peixoto2025.example1"), read_plant(PAPER / "example1.toml"))


def test_example_1_of_the_paper() -> None:
    plant = read_plant(PAPER / "example1.toml")
    theta = sp.Symbol("theta")
    printed = {
        "A": sp.Matrix([[0.265 - 0.165 * theta, 0.45 * (1 + theta)], [0.5 * (1 - theta), 0.265 - 0.215 * theta]]),
        "B_w": sp.Matrix([[1.5 - 0.5 * theta], [0.1]]),
        "C_z": sp.eye(2),
        "D_z": sp.zeros(2, 1),
        "C_y": sp.Matrix([[1, 0]]),
        "D_y": sp.Matrix([[1]]),
    }
    assert list(plant.matrices) == list(printed)
    for value in (-1.0, 0.3, 1.0):
        point = {sp.Symbol("alpha1"): (1 - value) / 2, sp.Symbol("alpha2"): (1 + value) / 2}
        for name, matrix in printed.items():
            expected = np.array(matrix.subs(theta, value), dtype=float)
            assert plant.matrices[name].evaluate(point)[0] == pytest.approx(expected), name


def test_example_2_of_the_paper_depends_on_rho_in_one_entry() -> None:
    plant = read_plant(PAPER / "example2.toml")
    first = {sp.Symbol("alpha1"): 1.0, sp.Symbol("alpha2"): 0.0, sp.Symbol("rho"): 20.0}
    assert plant.scalars == {"rho": 1}
    assert plant.matrices["A"].evaluate(first)[0].tolist() == [[1.05, 0.35], [-0.41, -1.0]]
    assert plant.matrices["C_y"].evaluate(first)[0].tolist() == [[1.7, 3.0]]
    assert {name for name, matrix in plant.matrices.items() if sp.Symbol("rho") in matrix.monomials.atoms} == {"A"}


@pytest.mark.parametrize("text", ["0.1", '"0.1"', '"1/10"', "1e-1", "0.10"])
def test_a_decimal_in_a_text_is_what_it_says(text: str, tmp_path: Path) -> None:
    for path in (
        write(tmp_path / "plant.toml", f"matrices.C = [[{text}]]"),
        write(tmp_path / "plant.json", f'{{"matrices": {{"C": [[{text}]]}}}}'),
    ):
        assert read_plant(path).matrices["C"].coefficients.tolist() == [[[Fraction(1, 10)]]]


def test_a_float_in_an_array_file_is_what_it_stores(tmp_path: Path) -> None:
    array = np.array([[0.1]])
    for path in (write_npz(tmp_path / "plant.npz", C=array), write_mat(tmp_path / "plant.mat", C=array)):
        assert read_plant(path).matrices["C"].coefficients.tolist() == [[[Fraction(0.1)]]]
    assert Fraction(0.1) == Fraction(3602879701896397, 2**55)


@pytest.mark.parametrize("kind", ["f4", "f8", ">f8", "i1", "i4", "i8", "u2", "u8"])
def test_array_files_may_hold_any_real_type(kind: str, tmp_path: Path) -> None:
    array = np.array([[1, 2], [3, 4], [5, 6]], dtype=kind)
    paths = [write_npz(tmp_path / "plant.npz", C=array), write_mat(tmp_path / "plant.mat", C=array)]
    for path in paths:
        plant = read_plant(path)
        assert plant.matrices["C"].coefficients.tolist() == [[[1, 2], [3, 4], [5, 6]]]
        assert plant.domains == {}


@pytest.mark.parametrize("order", ["<", ">"])
def test_matlab_files_as_matlab_writes_them(order: str, tmp_path: Path) -> None:
    # small integers in single bytes, texts in two bytes a character, short elements in eight bytes, nothing packed
    stacks = mat_array(order, "A", 6, (1, 2, 2), 2, bytes([1, 2, 3, 4]))
    text = mat_array(order, "parameter", 4, (1, 2), 4, struct.pack(f"{order}2H", *b"be"))
    plant = read_plant(write(tmp_path / "plant.mat", mat_header(order) + stacks + text))
    assert plant.domains == {"be": SimplexDomain(("be1", "be2"))}
    assert plant.matrices["A"].coefficients.tolist() == [[[1, 2]], [[3, 4]]]


def test_equal_vertices_are_a_constant(tmp_path: Path) -> None:
    tables = document(scalars={"c": 1}, matrices={"C": {"vertices": [[[1]]] * 2}, "D": {"vertices": [[["c"]]] * 2}})
    plant = read_plant(write(tmp_path / "plant.json", json.dumps(tables)))
    assert plant.matrices["C"].monomials.atoms == ()
    assert plant.matrices["D"].monomials.atoms == (sp.Symbol("c"),)


def test_suffixes_and_byte_order_marks_do_not_matter(tmp_path: Path) -> None:
    assert read_plant(str(write(tmp_path / "plant.TOML", b"\xef\xbb\xbf[matrices]\r\nC = [[1]]\r\n"))).name == "plant"


def test_matrices_are_exact_polynomials(tmp_path: Path) -> None:
    path = write(tmp_path / "plant.json", json.dumps(document(matrices={"C": [["beta1**2/3", "0.1*beta2 - beta1"]]})))
    matrix = read_plant(path).matrices["C"]
    assert isinstance(matrix, MatrixPolynomial)
    assert isinstance(matrix.monomials, Monomials)
    names = [str(atom) for atom in matrix.monomials.atoms]
    found = {
        "*".join(n if p == 1 else f"{n}**{p}" for n, p in zip(names, powers, strict=True) if p): values
        for powers, values in zip(matrix.monomials.exponents.tolist(), matrix.coefficients.tolist(), strict=True)
    }
    zero = Fraction(0)
    assert {key: value for key, value in found.items() if any(map(any, value))} == {
        "beta1**2": [[Fraction(1, 3), zero]],
        "beta1": [[zero, Fraction(-1)]],
        "beta2": [[zero, Fraction(1, 10)]],
    }


def test_numbers_given_in_python() -> None:
    assert exact_number(np.float64(0.1)) == exact_number(0.1) == exact_number("0.1") == Fraction(1, 10)
    assert exact_number(np.int32(3)) == 3
    assert exact_number("1/3") == Fraction(1, 3)
    for value in (np.bool_(True), 1j, "nan", float("inf"), "1e999999999", 10**400, None):
        with pytest.raises(PlantError):
            exact_number(value)
