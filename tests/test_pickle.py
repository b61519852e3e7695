"""Theorems travel to other processes: what comes out of a pickle is what went in."""

from __future__ import annotations

import pickle

import pytest

from lmic import library
from lmic.language.declarations import Scalar, dims, given
from lmic.language.star import star
from lmic.pipeline import finish, prepare
from lmic.plants.files import read_plant


@pytest.mark.parametrize("name", library.names())
def test_a_theorem_is_equal_and_prints_the_same(name: str) -> None:
    theorem = library.theorem(name)
    copy = pickle.loads(pickle.dumps(theorem))
    assert copy == theorem
    assert copy is not theorem
    assert copy._repr_latex_() == theorem._repr_latex_()
    assert (copy.unknowns, copy.data, copy.parameters) == (theorem.unknowns, theorem.data, theorem.parameters)


def test_symbols_keep_their_kind_and_latex_name() -> None:
    for symbol in (Scalar("mu", latex=r"\mu^\star"), given("eps", latex=r"\epsilon"), dims("nx")[0]):
        copy = pickle.loads(pickle.dumps(symbol))
        assert copy == symbol
        assert type(copy) is type(symbol)
        assert copy._latex(None) == symbol._latex(None)
    assert pickle.loads(pickle.dumps(star)) is star


def test_a_binding_compiles_to_the_same_arrays() -> None:
    plant = read_plant(library.root() / "peixoto2025" / "example2.toml")
    binding = prepare(library.theorem("peixoto2025.theorem1"), plant)
    copy = pickle.loads(pickle.dumps(binding))
    one, other = (finish(b, {"eps": 2, "rho": 10}).columns for b in (binding, copy))
    assert (one != other).nnz == 0
