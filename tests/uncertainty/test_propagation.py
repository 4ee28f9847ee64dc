"""Forward uncertainty: the same numbers as single sweeps, and what is said of them."""

import json
import pickle

import matplotlib.pyplot as plt
import numpy as np
import polars as pl
import pytest
from scipy import stats

import locosweep as ls
from locosweep.cli import main
from locosweep.uncertainty.propagation import Need

FRICTION = {"mu_static": "0.4:0.6", "mu_coulomb/mu_static": "0.5:0.9"}


def assert_as_single_sweeps(found, quantity, **known):
    for k in range(found.samples):
        at = {name: values[k] for name, values in found.points.items()}
        one = ls.sweep(quantity, **at, **found.axes, **known)
        np.testing.assert_array_equal(one.values, found.values[..., k])
        np.testing.assert_array_equal(one.status, found.status[..., k])


def test_every_point_has_the_bits_of_a_single_sweep():
    known = {"slope_deg": 12.0, "stroke": 0.02}
    axes = {"segments": [2, 3, 6, 9], "mass": [0.2, 0.3]}
    found = ls.propagate("mean_velocity", FRICTION, samples=32, **known, **axes)
    assert found.shape == (4, 2)
    assert {0} < set(found.status.ravel().tolist())
    assert_as_single_sweeps(found, "mean_velocity", **known)


def test_what_is_simulated_is_propagated_likewise():
    how = {"law": "stribeck", "drive": "sine"}
    known = {"drive_amplitude": 2.0, "mu_static": 0.5, "duration": 0.5, **how}
    found = ls.propagate("final_position", {"mu_coulomb": "0.2:0.4"}, samples=16, **known)
    assert_as_single_sweeps(found, "final_position", **known)
    known = {"mu_static": 0.6, "skin_ratio": 3.0, "segments": 4, "gait": "wave"}
    found = ls.propagate("gait_advance", {"mu_coulomb": "0.2:0.4"}, samples=8, **known)
    assert_as_single_sweeps(found, "gait_advance", **known)


def test_a_linear_quantity_is_distributed_like_its_parameter():
    # Friction on one segment on level ground is mu_C m g.
    found = ls.propagate("friction_force", {"mu_coulomb": "normal:0.3:0.02"}, mass=0.2,
                         speed=1.0)  # fmt: skip
    law = stats.norm(0.3 * 0.2 * 9.81, 0.02 * 0.2 * 9.81)
    for q in (0.05, 0.5, 0.95):
        assert float(found.quantile(q)) == pytest.approx(law.ppf(q), rel=1e-3)
    assert float(found.mean) == pytest.approx(law.mean(), rel=1e-5)
    found = ls.propagate("friction_force", {"mu_coulomb": "normal:0.3:0.02"}, mass=0.2, speed=1.0,
                         need=f"<= {law.ppf(0.8)}")  # fmt: skip
    assert float(found.share) == pytest.approx(0.8, abs=1e-3)
    low, high = found.share_interval
    assert low < 0.8 < high
    exact = stats.binomtest(round(float(found.share) * found.samples), found.samples)
    interval = exact.proportion_ci(method="exact")
    assert (float(low), float(high)) == pytest.approx((interval.low, interval.high))


def test_points_without_a_value_are_counted_and_are_the_worst():
    found = ls.propagate("mean_velocity", FRICTION, need="> 0", slope_deg=15, segments=5,
                         stroke=0.02, samples=1024)  # fmt: skip
    failing = np.isnan(found.values).mean()
    assert 0.02 < failing < 0.1
    assert float(found.with_value) == float(found.share) == 1.0 - failing
    assert np.isnan(found.quantile(0.9 * failing))
    assert 0.0 < float(found.quantile(1.1 * failing)) < np.nanmedian(found.values)
    assert found.to_polars()["without_value"].to_list() == ["anchors_too_weak"]
    assert "without: " in repr(found)
    # Of times less is better: those without one are the longest.
    times = ls.propagate(
        "cycle_time", FRICTION, slope_deg=15, segments=5, stroke=0.02, samples=1024
    )
    assert np.isnan(times.quantile(1.0))
    assert float(times.quantile(0.0)) == np.nanmin(times.values)


def test_quantiles_of_a_grid_are_those_of_its_cells():
    found = ls.propagate("mean_velocity", FRICTION, segments=[3, 4, 5], slope_deg=[5.0, 15.0],
                         samples=256)  # fmt: skip
    some = found.quantile([[0.1, 0.5], [0.6, 0.9]])
    assert some.shape == (2, 2, 3, 2)
    cell = found.sel(segments=4, slope_deg=15.0)
    np.testing.assert_array_equal(some[:, :, 1, 1], cell.quantile([[0.1, 0.5], [0.6, 0.9]]))
    assert found.mean.shape == found.with_value.shape == (3, 2)
    known = found.values[1, 1][np.isfinite(found.values[1, 1])]
    assert cell.mean == pytest.approx(known.mean())


def test_the_same_seed_gives_the_same_bits_on_any_threads():
    same = [ls.propagate("mean_velocity", FRICTION, segments=[3, 4], threads=n) for n in (1, 2)]
    np.testing.assert_array_equal(same[0].values, same[1].values)
    other = ls.propagate("mean_velocity", FRICTION, segments=[3, 4], seed=1)
    assert (other.values != same[0].values).all()


def test_shares_differ_from_seed_to_seed_by_what_the_documentation_says():
    unknown = FRICTION | {"slope_deg": "normal:8:2"}
    shares = [
        ls.propagate("mean_velocity", unknown, need=">= 0.05", segments=[4, 6, 8], stroke=0.02,
                     seed=seed).share
        for seed in range(12)
    ]  # fmt: skip
    assert (np.std(shares, axis=0) > 0.0).all()
    assert np.std(shares, axis=0).max() < 1e-3


def test_results_come_back_from_copies_and_are_tables_and_arrays():
    found = ls.propagate("final_position", {"mu_coulomb": "0.2:0.4"}, law="stribeck",
                         drive="sine", drive_amplitude=2.0, mu_static=0.5, duration=0.2,
                         mass=[0.2, 0.3], samples=16)  # fmt: skip
    again = pickle.loads(pickle.dumps(found))  # noqa: S301
    assert repr(again) == repr(found)
    np.testing.assert_array_equal(np.asarray(again), found.values)
    assert found.how["law"] == "stribeck"
    assert list(found.to_pandas()["mass"]) == [0.2, 0.3]
    assert "law stribeck" in found.sel(mass=0.2).plot().get_title(loc="left")
    plt.close("all")


def test_a_part_and_its_pictures():
    found = ls.propagate("mean_velocity", FRICTION, segments=[3, 4, 5], slope_deg=[0.0, 5.0],
                         need=">= 0.06", samples=256)  # fmt: skip
    with pytest.raises(ls.InputError, match="allowed is one"):
        found.plot()
    part = found.sel(slope_deg=5.0)
    assert part.fixed["slope_deg"] == 5.0
    np.testing.assert_array_equal(part.values, found.values[:, 1])
    ax = part.plot()
    assert ax.get_xlabel() == "number of segments of the robot $N$"
    alone = part.sel(segments=4)
    words = [text.get_text() for text in alone.plot().get_legend().get_texts()]
    assert any(word.startswith("need >= 0.06") for word in words)
    assert "<img" in alone._repr_html_()
    plt.close("all")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"need": "about 3"}, "need is 'about 3'"),
        ({"mu_static": 0.5}, "mu_static is given twice"),
        ({"samples": 1000}, "such as 512"),
        ({"seed": -1}, "seed is -1"),
        ({"memory_limit": 1000}, "the sample"),
    ],
)
def test_bad_input_is_told_in_one_line(given, said):
    with pytest.raises(ls.InputError, match=said) as raised:
        ls.propagate("mean_velocity", FRICTION, segments=4, **given)
    assert "\n" not in str(raised.value)


def test_a_ratio_to_an_axis_is_refused():
    with pytest.raises(ls.InputError, match="mu_static is an axis"):
        ls.propagate("mean_velocity", {"mu_coulomb/mu_static": "0.5:0.9"}, mu_static=[0.5, 0.6],
                     segments=4)  # fmt: skip


def test_need_without_one_is_asked_for():
    found = ls.propagate("mean_velocity", FRICTION, segments=4, samples=64)
    with pytest.raises(ls.InputError, match="need is missing"):
        _ = found.share
    assert Need.of(" >=1e-2 ") == Need(">=", 0.01)


def test_what_is_unknown_goes_before_the_robot():
    robot = ls.Robot({"mass": 0.25, "mu_coulomb": 0.3, "mu_static": 0.5, "segments": 4.0})
    found = ls.propagate("mean_velocity", {"mu_coulomb": "0.2:0.3"}, robot=robot, samples=64)
    assert found.fixed["mass"] == 0.25
    assert "mu_coulomb" not in found.fixed


def test_command(tmp_path, capsys):
    out, picture = tmp_path / "table.csv", tmp_path / "speed.png"
    arguments = ["propagate", "mean_velocity", "--axis", "segments=2:6", "--set", "slope_deg=5",
                 "--unknown", "mu_static=0.4:0.6", "--unknown", "mu_coulomb/mu_static=0.5:0.9",
                 "--need", ">= 0.06", "--samples", "256"]  # fmt: skip
    assert main([*arguments, "--out", str(out), "--plot", str(picture)]) == 0
    said = capsys.readouterr().out
    assert "% of the points" in said
    assert "segments" in said
    assert pl.read_csv(out).columns[0] == "segments"
    assert picture.read_bytes()[1:4] == b"PNG"
    assert main([*arguments, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert [row["segments"] for row in report["designs"]] == [2, 3, 4, 5, 6]
    assert sum(report["statuses"].values()) == 5 * 256
    assert main([*arguments, "--unknown", "mass=3:1"]) == 2
    assert "allowed is LOW < HIGH" in capsys.readouterr().err


def test_a_picture_that_cannot_be_drawn_leaves_no_table(tmp_path, capsys):
    out, picture = tmp_path / "table.csv", tmp_path / "speed.png"
    arguments = ["propagate", "mean_velocity", "--axis", "segments=2:6", "--axis", "slope_deg=0,5",
                 "--set", "mu_static=0.5", "--unknown", "mu_coulomb=0.2:0.3"]  # fmt: skip
    assert main([*arguments, "--out", str(out), "--plot", str(picture)]) == 2
    assert "a picture of 2 axes, segments, slope_deg" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
