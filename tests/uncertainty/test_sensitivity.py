"""Sobol indices: closed forms, intervals that hold, failures that are told."""

import json
import pickle

import matplotlib.pyplot as plt
import numpy as np
import pytest

import locosweep as ls
from locosweep.cli import main
from locosweep.uncertainty import picture as room_pictures
from locosweep.uncertainty import sensitivity as room
from locosweep.uncertainty.evaluate import Evaluated

MASS_AND_FRICTION = {"mu_coulomb": (0.1, 0.5), "mass": (0.2, 0.3), "gravity": (9.0, 10.6)}
"""Of friction mu_C m g, a product."""


def of_product(bounds):
    """First-order and total indices of a product of independent, uniform factors."""
    squares = np.array([((b - a) / (a + b)) ** 2 / 3.0 for a, b in bounds])
    whole = np.prod(1.0 + squares) - 1.0
    return squares / whole, squares * (whole + 1.0) / (1.0 + squares) / whole


def test_indices_of_a_product_are_those_of_its_closed_form():
    found = ls.sensitivity("friction_force", MASS_AND_FRICTION, speed=1.0)
    first, total = of_product(list(MASS_AND_FRICTION.values()))
    np.testing.assert_allclose(found.first, first, atol=2e-3)
    np.testing.assert_allclose(found.total, total, atol=2e-3)
    assert found.names == list(MASS_AND_FRICTION)


def test_indices_of_ishigami_s_function(monkeypatch):
    # The usual test: x1 acts with x3, which alone makes no variance.
    a, b = 7.0, 0.1

    def ishigami(*given):
        x1, x2, x3 = given[2].values()
        values = np.sin(x1) + a * np.sin(x2) ** 2 + b * x3**4 * np.sin(x1)
        return Evaluated(values, np.zeros(values.size, np.uint8), {}, {})

    monkeypatch.setattr(room, "evaluate", ishigami)
    around = (-np.pi, np.pi)
    names = ("slope_deg", "drive_force", "start_speed")
    found = ls.sensitivity("final_position", dict.fromkeys(names, around), samples=2**16)
    first_variance = 0.5 * (1.0 + b * np.pi**4 / 5.0) ** 2
    second, together = a**2 / 8.0, 8.0 * b**2 * np.pi**8 / 225.0
    variance = first_variance + second + together
    expected = np.array([first_variance, second, 0.0]) / variance
    np.testing.assert_allclose(found.first, expected, atol=5e-3)
    expected = np.array([first_variance + together, second, together]) / variance
    np.testing.assert_allclose(found.total, expected, atol=5e-3)
    assert found.deviation == pytest.approx(np.sqrt(variance), rel=1e-2)


def test_intervals_hold_as_often_as_they_say():
    first, total = of_product(list(MASS_AND_FRICTION.values()))
    inside = []
    for seed in range(100):
        found = ls.sensitivity(
            "friction_force", MASS_AND_FRICTION, speed=1.0, samples=512, seed=100 * seed
        )
        for index, ends in ((first, found.first_interval), (total, found.total_interval)):
            inside += ((ends[:, 0] <= index) & (index <= ends[:, 1])).tolist()
    assert 0.90 <= np.mean(inside) <= 0.98


def test_one_unknown_makes_all_of_the_variance():
    found = ls.sensitivity("friction_force", {"mass": (0.2, 0.3)}, mu_coulomb=0.3, speed=1.0)
    assert found.first == pytest.approx([1.0], abs=1e-3)
    assert found.total == pytest.approx([1.0], abs=1e-3)


def test_points_without_a_value_need_a_word():
    unknown = {"mu_static": "0.4:0.6", "slope_deg": "normal:12:4"}
    known = {"mu_coulomb": 0.3, "segments": 5, "samples": 1024}
    with pytest.raises(ls.InputError, match="say what they count as"):
        ls.sensitivity("mean_velocity", unknown, **known)
    found = ls.sensitivity("mean_velocity", unknown, failed=0.0, **known)
    assert 0.0 < found.without_value < 1.0
    assert "have no value, and count as 0" in repr(found)
    moves = ls.sensitivity("feasible", unknown, **known)
    assert moves.without_value == 0.0


def test_an_index_that_may_be_zero_is_told_as_a_bound():
    # The mean velocity does not depend on the mass.
    found = ls.sensitivity("mean_velocity", {"mu_static": "0.4:0.6", "mass": "0.2:0.3"},
                           mu_coulomb=0.3, segments=5)  # fmt: skip
    assert found.to_polars()["unknown"].to_list() == ["mu_static", "mass"]
    assert "below 0.01" in repr(found).splitlines()[-1]
    assert "<img" in found._repr_html_()
    again = pickle.loads(pickle.dumps(found))  # noqa: S301
    assert repr(again) == repr(found)
    assert list(found.to_pandas()["unknown"]) == ["mu_static", "mass"]
    assert found.plot().get_xlabel().startswith("share of the variance")
    plt.close("all")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"samples": 64}, "from 128"),
        ({"segments": [3, 4]}, "segments has 2 values"),
        ({"mass": (0.2, 0.3)}, "mass has 2 values"),
        ({"quantity": ["mean_velocity"]}, "allowed is one name"),
    ],
)
def test_bad_input_is_told_in_one_line(given, said):
    known = {"quantity": "mean_velocity", "mu_coulomb": 0.3, "segments": 4} | given
    with pytest.raises(ls.InputError, match=said):
        ls.sensitivity(unknown={"mu_static": "0.4:0.6"}, **known)


def test_what_does_not_vary_is_refused():
    with pytest.raises(ls.InputError, match="does not vary with mass"):
        ls.sensitivity("best_segments", {"mass": "0.2:0.3"}, mu_static=0.5, mu_coulomb=0.3)


def test_command(tmp_path, capsys):
    picture = tmp_path / "indices.png"
    arguments = ["sensitivity", "mean_velocity", "--set", "segments=5", "--set", "mu_static=0.6",
                 "--unknown", "mu_coulomb=normal:0.3:0.03", "--unknown", "slope_deg=normal:5:1",
                 "--samples", "1024"]  # fmt: skip
    assert main([*arguments, "--plot", str(picture)]) == 0
    assert "standard deviation" in capsys.readouterr().out
    assert picture.read_bytes()[1:4] == b"PNG"
    assert main([*arguments, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert {row["unknown"] for row in report["indices"]} == {"mu_coulomb", "slope_deg"}
    assert main([*arguments, "--unknown", "slope=1:2"]) == 2
    assert "slope" in capsys.readouterr().err


@pytest.mark.parametrize("failed", [float("nan"), float("-inf"), "x", True])
def test_what_failures_count_as_is_a_number(failed):
    with pytest.raises(ls.InputError, match="allowed is a finite number"):
        ls.sensitivity("friction_force", MASS_AND_FRICTION, speed=1.0, failed=failed)


def test_too_few_samples_are_not_called_a_quantity_that_does_not_vary():
    unknown = {"slope_deg": "0:23.2", "mu_coulomb": "0.2:0.3"}
    with pytest.raises(ls.InputError, match="samples is 128"):
        ls.sensitivity("feasible", unknown, segments=4, mu_static=0.6, samples=128)


def test_intervals_stand_where_they_are_beside_an_index_below_zero():
    found = ls.sensitivity(
        "friction_force", {**MASS_AND_FRICTION, "stroke": (0.01, 0.02)}, speed=1.0
    )
    ax = room_pictures.bars(found)
    low, high = (found.to_polars()[f"first_{end}"].to_numpy() for end in ("low", "high"))
    (first, _) = (bars.errorbar for bars in ax.containers if hasattr(bars, "errorbar"))
    spans = np.array([s[:, 0] for s in first.lines[2][0].get_segments()])
    shown = np.maximum(found.to_polars()["first"].to_numpy(), 0.0)
    np.testing.assert_allclose(spans[:, 1], np.maximum(high, shown))
    np.testing.assert_allclose(spans[:, 0], np.minimum(low, shown))
