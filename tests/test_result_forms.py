"""Results in other hands: processes, copies, arrays, tables, parts, notebooks."""

import copy
import multiprocessing
import pickle
import re
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import polars as pl
import pytest

import locosweep as ls

MU = {"mu_static": 0.5, "mu_coulomb": 0.3}
SLOPES = [0.0, 10.0, 20.0, 40.0]


@pytest.fixture
def speed():
    return ls.sweep("mean_velocity", **MU, slope_deg=SLOPES, segments=range(2, 6))


@pytest.fixture
def both():
    return ls.sweep(["mean_velocity", "net_force"], **MU, slope_deg=SLOPES, segments=[3, 4])


def same(one, other):
    assert repr(one) == repr(other)
    assert one.fixed == other.fixed
    for output in one.outputs:
        np.testing.assert_array_equal(one[output.name], other[output.name])
        np.testing.assert_array_equal(one.status_of(output.name), other.status_of(output.name))


def through_bytes(result):
    return pickle.loads(pickle.dumps(result))  # noqa: S301


@pytest.mark.parametrize("copied", [copy.deepcopy, copy.copy, through_bytes])
def test_copies_hold_values_and_statuses(both, copied):
    same(both, copied(both))


def speed_at(slope):
    return ls.sweep("mean_velocity", **MU, slope_deg=[slope, 40.0], segments=[3, 4])


def test_results_come_back_from_other_processes():
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as pool:
        for there, here in zip(pool.map(speed_at, [0, 5]), map(speed_at, [0, 5]), strict=True):
            same(there, here)


def test_one_output_is_an_array_and_two_are_none(speed, both):
    assert np.asarray(speed).dtype == np.float64
    np.testing.assert_array_equal(np.asarray(speed), speed.values)
    assert np.asarray(speed, np.float32).dtype == np.float32
    assert np.nanmax(speed) == np.nanmax(speed.values)
    assert np.asarray(speed) is speed.values
    assert np.array(speed) is not speed.values
    with pytest.raises(ls.InputError, match=r"2 outputs: take one, result\['mean_velocity'\]"):
        np.asarray(both)


def test_pandas_gets_the_same_table(both):
    frame, table = both.to_pandas(), both.to_polars()
    assert list(frame) == table.columns
    np.testing.assert_array_equal(frame["net_force"], table["net_force"].to_numpy())
    assert frame["net_force_status"].tolist() == table["net_force_status"].to_list()
    assert "slides_back" in frame["mean_velocity_status"].cat.categories


def test_libraries_of_tables_take_a_result_as_it_is(speed):
    frame = pl.DataFrame(speed)
    assert frame.columns == ["slope_deg", "segments", "mean_velocity", "status"]
    assert frame.height == speed.values.size


def test_a_part_is_what_a_smaller_sweep_gives(both):
    part = both.sel(slope_deg=[20, 0], segments=4)
    same(part, ls.sweep(["mean_velocity", "net_force"], **MU, slope_deg=[20, 0], segments=4))
    assert part.axes["slope_deg"].tolist() == [20, 0]
    assert part.shape == (2,)
    assert both.sel(segments=4).sel(slope_deg=40).status == both.status[3, 1]
    assert both.sel(slope_deg=[12, 33], method="nearest").axes["slope_deg"].tolist() == [10, 40]
    same(both.sel(), both)
    part.values[:] = 7
    assert not (both.values == 7).any()


def test_a_part_of_a_reduction_keeps_what_was_reduced(tmp_path):
    best = ls.sweep("mean_velocity", **MU, slope_deg=SLOPES, segments=range(2, 6),
                    over="segments", reduce="argmax")  # fmt: skip
    part = best.sel(slope_deg=[0, 10])
    assert (part.over, part.outputs) == ("segments", best.outputs)
    part.save(tmp_path / "part.parquet")
    same(ls.load(tmp_path / "part.parquet"), part)


@pytest.mark.parametrize(("asked", "said"), [
    ({"slope": 1}, "unknown axis 'slope': did you mean 'slope_deg'"),
    ({"slope_deg": 5}, "slope_deg is 5: allowed are the values of that axis, 0, 10, 20, 40"),
    ({"slope_deg": "ten"}, "slope_deg is 'ten'"),
    ({"slope_deg": 5, "method": "linear"}, "method is 'linear'"),
])  # fmt: skip
def test_faults_of_a_part_are_one_line(speed, asked, said):
    with pytest.raises(ls.InputError, match=re.escape(said)):
        speed.sel(**asked)


def friction_fit():
    t = np.linspace(0, 10, 400)
    v = 0.02 * np.sin(2 * t)
    noise = np.random.default_rng(1).normal(0, 0.01, t.size)
    measured = {"t": t, "v": v, "force": 0.8 * np.sign(v) + 5 * v + noise}
    return ls.fit_friction(measured, laws=["coulomb", "coulomb_viscous"])


RESULTS = {
    "map": lambda: speed_at(0),
    "line": lambda: ls.sweep("mean_velocity", **MU, segments=range(2, 6)),
    "number": lambda: ls.sweep("mean_velocity", **MU, segments=3),
    "whole": lambda: ls.sweep("best_segments", **MU, slope_deg=[0, 10], stroke=[0.01, 0.02],
                              anchor_weight=[0, 1]),
    "nothing": lambda: ls.sweep("mean_velocity", **MU, slope_deg=[40, 50], segments=[3, 4]),
    "infinite": lambda: ls.sweep("mean_velocity", **MU, drive_limit=[1, np.inf], segments=[3, 4]),
    "trajectory": lambda: ls.simulate(law="coulomb", mu_coulomb=0.3, drive_force=2),
    "trajectories": lambda: ls.simulate(law="coulomb", mu_coulomb=np.linspace(0.1, 0.3, 30),
                                        drive_force=2),
    "gait": lambda: ls.run_gait("single", segments=4, **MU, drive_limit=0.85, break_away=0),
    "friction": friction_fit,
}  # fmt: skip


@pytest.mark.parametrize("name", RESULTS)
def test_every_result_is_short_as_text_and_has_a_picture_where_there_is_one(name):
    found = RESULTS[name]()
    text = repr(found)
    assert len(text) < 1500
    assert "array" not in text
    html = found._repr_html_()
    assert ("data:image/png" in html) == (name not in {"number", "infinite", "trajectories"})
    assert len(html) < 150_000
    pickled = through_bytes(found)
    assert repr(pickled) == text


def test_a_notebook_shows_what_cannot_be_computed_again(speed):
    moved = through_bytes(speed)
    assert moved._repr_html_() == speed._repr_html_()


def test_text_of_a_number_is_no_range_and_counts_have_no_unit():
    assert "mean velocity: 0.0873499 m/s" in repr(RESULTS["number"]())
    assert "best segments: 3 .. 5, 100.0% of the cells" in repr(RESULTS["whole"]())


def test_text_of_a_trajectory_names_what_failed():
    given = {"law": "dahl", "method": "rosenbrock_fixed", "time_step": 0.05, "mass": 0.3}
    run = ls.simulate(**given, **MU, drive_force=[0.1, 1e8], samples=11)
    assert "2 trajectories of 11 samples up to 1 s" in repr(run)
    assert "1 with status diverged" in repr(run)
