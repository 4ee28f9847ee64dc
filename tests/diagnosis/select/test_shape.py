"""What a force that nobody explains looks like."""

from __future__ import annotations

from diagnosis_search import search_of
from diagnosis_small import tethered
from locosweep.diagnosis.effects.catalogue import FURTHER
from locosweep.diagnosis.estimate.motion import ALL
from locosweep.diagnosis.select.law_mismatch import MASS
from locosweep.diagnosis.select.shape import KINDS, shape_of, shapes, unlisted_of
from locosweep.diagnosis.select.unlisted_rival import BY_TIME


def test_every_variable_has_words() -> None:
    assert set(KINDS) == {*ALL, *FURTHER.values(), BY_TIME, MASS, "line"}
    assert {kind.parity for kind in KINDS.values()} <= {"odd", "even", "none"}


def test_a_tether_is_a_force_by_place_both_ways_alike() -> None:
    read = tethered(stiffness=0.1)
    search = search_of(read, "viscous_friction")
    found = {(row["variable"], row["parity"]): row["share"]
             for row in shape_of(search.problem, search.none)}  # fmt: skip
    assert found["place", "even"] > 0.8


def test_rows_of_a_report() -> None:
    (row,) = shapes([("speed", 1.2)])
    assert row == {"variable": "speed", "parity": "odd", "share": 1.0,
                   "formula": KINDS["speed"].family}  # fmt: skip
    assert unlisted_of("terrain", {"share": 0.4})["share"] == 0.4
    assert unlisted_of("push", None)["formula"] is None
