"""Problems that the tests of formats and solvers share."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from lmic import library
from lmic.compiler.assemble import ConicProblem
from lmic.interchange.formats import FORMATS
from lmic.interchange.sdp import SDP, Notes, sdp_of_entries
from lmic.pipeline import compile
from lmic.plants.plant import Plant

SUFFIXES = list(FORMATS)

#: x⁺ = ±x/2 + w, z = x has the ℓ2 gain 1/(1 − 1/2)
LAG_GAIN = 2.0


def lag() -> ConicProblem:
    """The bounded-real lemma of a lag whose sign moves: a small problem with an interior."""
    plant = Plant.polytopic("rho", A=[[[0.5]], [[-0.5]]], B=[[1]], C=[[1]], D=[[0]])
    return compile(library.theorem("standard.bounded_real_discrete"), plant)


def identical(a: SDP, b: SDP) -> bool:
    """Whether all numbers are the same, bit for bit, and all notes."""
    parts = ("unknown", "lmi", "row", "column", "value")
    arrays = [(getattr(a.entries, part), getattr(b.entries, part)) for part in parts]
    arrays += [(a.cost, b.cost), (a.orders, b.orders), (np.array(a.constant), np.array(b.constant))]
    return (
        all(p.shape == q.shape and p.tobytes() == q.astype(p.dtype).tobytes() for p, q in arrays)
        and a.notes == b.notes
        and a.maximised == b.maximised
    )


finite = st.floats(allow_nan=False, allow_infinity=False).filter(lambda value: abs(value) < 8e307)


@st.composite
def programs(draw: st.DrawFn) -> SDP:
    """Programs of any numbers: subnormal and huge ones, LMIs of order 1, unknowns that no LMI sees."""
    size, orders = draw(st.integers(1, 4)), draw(st.lists(st.integers(1, 4), min_size=1, max_size=4))
    places = st.tuples(st.integers(0, size), st.integers(0, len(orders) - 1), st.integers(0, 3), st.integers(0, 3))
    found = draw(st.dictionaries(places, finite, max_size=20))
    kept = {
        (i, k, min(row, column), max(row, column)): value
        for (i, k, row, column), value in found.items()
        if max(row, column) < orders[k]
    }
    entries = [np.array([key[j] for key in kept], dtype=int) for j in range(4)]
    names = st.text(max_size=12)
    notes = Notes(
        draw(names),
        draw(st.sampled_from(["exact", "sufficient", "sampled", "not stated"])),
        tuple(draw(st.lists(names, min_size=size, max_size=size))),
        tuple(draw(st.lists(names, min_size=len(orders), max_size=len(orders)))),
    )
    cost = np.array(draw(st.lists(finite, min_size=size, max_size=size)))
    values = [*entries, np.array(list(kept.values()))]
    return sdp_of_entries(cost, draw(finite), np.array(orders), values, notes, draw(st.booleans()))
