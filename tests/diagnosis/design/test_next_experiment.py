"""The next experiment: distances by another route, and what no run can tell."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import polars as pl
import pytest
from scipy.optimize import least_squares

from locosweep.diagnosis import diagnose
from locosweep.diagnosis.design import next_experiment as experiment
from locosweep.diagnosis.design.menu import MENU, Change
from locosweep.diagnosis.effects.scale import scale_of
from locosweep.diagnosis.estimate.least_squares import (
    Fit,
    Nuisances,
    fit_all,
    point_of,
    start_fits,
)
from locosweep.diagnosis.estimate.problem import Problem
from locosweep.diagnosis.select.search import Search
from locosweep.files.runs import runs_from_frame
from locosweep.simulation.replay import replay_runs
from test_diagnosis import NOISE, ROBOT, drives, measured

GAIN = {"drive_gain_error": {"e": -0.05}}
FRICTIONLESS = replace(ROBOT, parameters={**ROBOT.parameters, "viscous": 0.0})


def one_way(step: float = 0.0) -> pl.DataFrame:
    """One way, without damping: mass and gain are one signal; readings in steps."""
    runs = drives(both=False)
    frame = replay_runs(replace(FRICTIONLESS, effects=GAIN), runs).select("run", "t", "x")
    x = frame["x"].to_numpy() + np.random.default_rng(3).normal(0.0, NOISE, frame.height)
    x = np.round(x / step) * step if step else x
    drive = np.concatenate([r.drive for r in runs])
    return frame.with_columns(x=pl.Series(x), drive=pl.Series(drive))


@pytest.fixture(scope="module")
def fitted() -> tuple[Search, list[Fit]]:
    """Gain and mass, each fitted to what a gain error makes."""
    records = runs_from_frame(one_way())
    scale = scale_of(FRICTIONLESS, records)
    problem = Problem(FRICTIONLESS, records, 1, speed_scale=scale.speed)
    nuisances = Nuisances((), (0.0, 0.0, 0.0, 0.0), scale.speed)
    found = Search(problem, nuisances, scale, ())
    starts = []
    for name in ("drive_gain_error", "payload_mass"):
        starts += start_fits(nuisances, found.model((name,)), np.zeros((1, 1)))
    return found, fit_all(problem, starts, steps=20)


@pytest.mark.parametrize("change", MENU, ids=lambda change: change.name)
def test_a_distance_is_what_another_least_squares_leaves(
    fitted: tuple[Search, list[Fit]], change: Change
) -> None:
    search, fits = fitted
    planned = experiment._planned(search, change)
    problem = planned.seen_by(fits[0])
    place = problem.parameter_index("payload_mass", "dm")

    def left(dm: np.ndarray) -> np.ndarray:
        point = point_of(problem, fits[1])
        point.values[place] = dm[0]
        return problem.residuals([point])[0]

    other = least_squares(left, fits[1].parameters, diff_step=1e-4, xtol=1e-12, ftol=1e-12)
    distance = float(np.sqrt(2.0 * other.cost))
    straight = experiment._linearised(planned, fits)
    assert straight[0, 1] == pytest.approx(distance, rel=0.1, abs=0.1)
    assert straight[1, 0] == pytest.approx(straight[0, 1], rel=0.1, abs=0.1)
    found = experiment._refitted(search, planned, fits, 0, straight[0])
    assert found == pytest.approx(distance, rel=1e-3, abs=0.1 if distance < 1.0 else 1e-6)


def test_a_run_that_tells_them_is_proposed_from_coarse_readings_too() -> None:
    for step in (0.0, 1e-4):
        found = diagnose(one_way(step), FRICTIONLESS)
        assert found.status == "ambiguous", found
        assert {"drive_gain_error", "payload_mass"} <= set(found.equivalent[0])
        told = found.next_experiment
        assert told["possible"], told
        assert told["menu"][0]["distance"] > experiment.RESOLVED, told


def test_no_run_is_proposed_where_none_can_tell() -> None:
    """A force that grows with the speed is one, whether the ground or the motor makes it."""
    frame = measured({"back_emf": {"k_e": 0.1}}, drives())
    found = diagnose(frame, ROBOT)
    assert [sorted(c) for c in found.equivalent] == [["back_emf", "viscous_friction"]], found
    told = found.next_experiment
    # Only what the drive delivers, measured, tells them.
    proposed = told["menu"][0]["run"] if told["possible"] else "force sensor"
    assert proposed == "force sensor", told
    assert all(row["distance"] < 1.0 for row in told["menu"] if row["run"] != "force sensor")


@pytest.mark.parametrize("change", MENU, ids=lambda change: change.name)
def test_the_truth_leaves_nothing_of_what_it_predicts(change: Change) -> None:
    """Also where the head slides down an incline before the drive sets in."""
    slippery = replace(ROBOT, parameters={**ROBOT.parameters, "mu_coulomb": 0.05})
    frame = replay_runs(slippery, drives()).select("run", "t", "x")
    frame = frame.with_columns(drive=pl.Series(np.concatenate([r.drive for r in drives()])))
    holes = frame.with_columns(
        x=pl.when(pl.col("t").is_between(1.0, 1.2)).then(float("nan")).otherwise("x")
    )
    for one in (frame, holes):
        records = runs_from_frame(one)
        scale = scale_of(slippery, records)
        problem = Problem(slippery, records, 1, speed_scale=scale.speed)
        nuisances = Nuisances((), (0.0, 0.0, 0.0, 0.0), scale.speed)
        found = Search(problem, nuisances, scale, (), lambda _: None)
        planned = experiment._planned(found, change)
        made = planned.seen_by(found.none)
        left = made.residuals([point_of(made, found.none)])[0]
        assert np.linalg.norm(left) < 1e-6
        new = len(records)
        assert np.isfinite(made.runs[new].channels["x"]).all()
        for run, old in zip(made.runs, records, strict=False):
            np.testing.assert_array_equal(np.isnan(run.channels["x"]), np.isnan(old.channels["x"]))


def test_repeats_are_asked_for_where_one_run_says_too_little(
    fitted: tuple[Search, list[Fit]], monkeypatch: pytest.MonkeyPatch
) -> None:
    search, fits = fitted
    for distance, said in ((1.7, "4 times"), (3.0, "2 times"), (9.0, "mass ("), (0.5, "no motion")):
        monkeypatch.setattr(experiment, "_refitted", lambda *_, d=distance: d)
        told = experiment.next_experiment(search, fits, [0.5, 0.5])
        assert said in told["suggestion"], told
        assert told["possible"] == (said != "no motion")
        assert told["menu"][0]["distance"] == pytest.approx(distance)


def test_formulas_that_are_far_apart_but_tie_are_told_apart_by_what_a_run_adds(
    fitted: tuple[Search, list[Fit]], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Under another law two causes tie whose formulas lie 50 deviations apart so far."""
    search, fits = fitted
    apart = np.array([[np.inf, 50.0], [50.0, np.inf]])
    monkeypatch.setattr(experiment, "_linearised", lambda *_: apart)
    for added, possible in ((8.0, True), (0.0, False)):
        monkeypatch.setattr(experiment, "_refitted", lambda *_, a=added: np.hypot(50.0, a))
        told = experiment.next_experiment(search, fits, [0.5, 0.5])
        assert told["possible"] == possible
        assert told["menu"][0]["distance"] == pytest.approx(np.hypot(3.0, added))


def test_runs_are_refitted_until_one_tells_nearly_always(
    fitted: tuple[Search, list[Fit]], monkeypatch: pytest.MonkeyPatch
) -> None:
    search, fits = fitted
    for distance, refitted in ((20.0, 1), (1.0, 4)):
        monkeypatch.setattr(experiment, "_refitted", lambda *_, distance=distance: distance)
        told = experiment.next_experiment(search, fits, [1.0] * len(fits))
        rows = told["menu"]
        assert len(rows) == 4
        assert sum(row["refitted"] for row in rows) == refitted
        assert rows[0]["refitted"]
        # What is farther than any doubt counts no more.
        assert all(row["distance"] <= 10.0 for row in rows)


def test_a_refit_that_ends_early_is_still_far(fitted: tuple[Search, list[Fit]]) -> None:
    """What the runs so far tell is no part of what a further one adds."""
    search, fits = fitted
    planned = experiment._planned(search, MENU[0])
    straight = experiment._linearised(planned, fits)
    whole = experiment._refitted(search, planned, fits, 0, straight[0], np.inf)
    for known in (0.0, 0.5 * whole**2):
        early = experiment._refitted(search, planned, fits, 0, straight[0], known)
        assert early >= whole - 1e-6
        assert early == pytest.approx(whole, rel=1e-6) or early**2 - known > 100.0


def test_the_way_back_is_proposed_without_a_menu() -> None:
    told = experiment.back_again()
    assert told["possible"]
    assert told["menu"] == []
    assert "reverses with the motion" in told["suggestion"]


def test_an_exact_repeat_is_proposed_once(fitted: tuple[Search, list[Fit]]) -> None:
    problem = fitted[0].problem
    assert "exactly" in experiment.once_more(problem)["suggestion"]
    again = replace(problem, runs=[*problem.runs, problem.runs[0]])
    assert experiment.once_more(again)["suggestion"] is None
    # The same drive on other ground is no repeat.
    steeper = replace(problem.runs[0], slope_deg=5.0)
    other = replace(problem, runs=[*problem.runs, steeper])
    assert experiment.once_more(other)["suggestion"]


@pytest.mark.whole
def test_a_force_along_a_way_that_is_driven_once_asks_for_the_way_back() -> None:
    """A spring to the start, in runs that only go forward."""
    forward = [replace(run, drive=np.abs(run.drive)) for run in drives(count=5)]
    nominal = replay_runs(ROBOT, forward)
    pulled = [
        replace(
            run, drive=run.drive - 0.05 * nominal.filter(pl.col("run") == run.label)["x"].to_numpy()
        )
        for run in forward
    ]
    frame = measured({}, pulled).with_columns(
        drive=pl.Series(np.concatenate([run.drive for run in forward]))
    )
    found = diagnose(frame, ROBOT)
    assert found.status == "unexplained", found
    assert found.unlisted, found
    assert "back over the same way" in found.next_experiment["suggestion"]
