"""A law as a report says it."""

from __future__ import annotations

import numpy as np

from locosweep.diagnosis.report.law_text import formula_of, row_of
from locosweep.diagnosis.select.force_law import ForceLaw
from locosweep.diagnosis.select.law_forms import Found, shortest

U = np.linspace(0.0, 0.5, 41)
GRAM = 1e4 * np.eye(U.size)


def law(heights: np.ndarray, variable: str = "terrain") -> ForceLaw:
    found = shortest(U, GRAM, GRAM @ heights)
    return ForceLaw(variable, U, heights, np.full(U.size, 0.01), found, share=0.8)


def formula(heights: np.ndarray, variable: str = "terrain", *, rotary: bool = False) -> str:
    text = formula_of(law(heights, variable), rotary=rotary)
    assert text is not None
    return text


def test_each_form_has_its_words() -> None:
    assert formula(-3.0 * np.maximum(U - 0.21, 0.0)) == "(-3.00 ± 0.024) N/m beyond x = 0.21 m"
    bump = formula(0.8 * np.exp(-0.5 * ((U - 0.2) / 0.05) ** 2))
    assert bump.startswith("(0.801 ± 0.0")
    # At half its height a bump of deviation 50 mm is 118 mm wide.
    assert bump.endswith("N around x = 0.2 m, 0.12 m wide")
    assert formula(0.5 + 0.0 * U).endswith("N, the same everywhere")
    assert formula(np.where(U > 0.2, 0.3, 0.0) + 0.1).count("beside") == 1
    wave = formula(0.3 * np.sin(2 * np.pi * U / 0.1) + 0.4 * np.cos(2 * np.pi * U / 0.1))
    assert wave.startswith("a wave of (0.498 ± ")
    power = formula((U / 0.5) ** 2, "speed")
    assert power.endswith("at |v| = 0.5 m/s, as its power 2")


def test_units_of_a_rig_that_turns() -> None:
    assert "N m/rad beyond x = 0.21 rad" in formula(-3.0 * np.maximum(U - 0.21, 0.0), rotary=True)
    assert formula(2.0 * U, "sag").endswith("1/s of t")


def test_a_row_holds_curve_and_formula_or_none() -> None:
    row = row_of(law(-3.0 * U), rotary=False)
    assert row["share"] == 0.8
    assert row["curve"]["unit"] == "N"
    assert row["curve"]["at_unit"] == "m"
    lengths = {len(row["curve"][key]) for key in ("at", "value", "std", "by_formula")}
    assert lengths == {U.size}
    bare = ForceLaw("terrain", U, U, U, None)
    assert formula_of(bare, rotary=False) is None
    assert row_of(bare, rotary=False)["curve"]["by_formula"] is None


def test_a_size_without_an_error_has_no_interval() -> None:
    found = law(-3.0 * U).found
    assert found is not None
    exact = Found(found.form, found.shape, found.sizes, 0.0 * found.sizes, found.constant, 1.0)
    assert formula_of(ForceLaw("terrain", U, U, U, exact), rotary=False) == "-3 N/m of x"
