"""Semi-real cases: sizes, same answers, controls, calibration and the plain baseline."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import replay_runs
from locosweep.validation.baseline import ALIKE, baseline
from locosweep.validation.calibration import calibrate
from locosweep.validation.planting import NotPlantable, Rig
from locosweep.validation.rig_problem import rms_of, see, weighed
from locosweep.validation.semi_real import Source, controls, draw
from locosweep.validation.sizes import RISES

T = np.arange(0.0, 2.0, 0.01)
BENCH = Robot(
    {"mass": 0.5, "segments": 1.0, "viscous": 0.8, "gain": 1.5},
    {"surface.coulomb_force": 1.2, "bench.kind": "linear", "sensor.position_noise": 1e-5},
)


def measured(real: Robot, model: Robot, *, channels: tuple[str, ...] = ("x",)) -> Rig:
    """Runs of a rig that is not quite its model, and the model."""
    drives = [
        2.4 * np.sin(5.0 * T + 2.0 * T**2),
        1.8 * np.sign(np.sin(7.0 * T)),
        2.2 * np.sin(9.0 * T) * (T > 0.2),
    ]
    runs = [Run(f"{i}", T, drive, {"x": np.zeros(T.size)}) for i, drive in enumerate(drives)]
    read = replay_runs(real, runs)
    rng = np.random.default_rng(3)
    parts = {c: np.split(read[c].to_numpy(), len(runs)) for c in channels}
    return Rig(model, tuple(
        replace(run, channels={c: parts[c][i] + rng.normal(0.0, 1e-5, T.size) for c in channels})
        for i, run in enumerate(runs)
    ))  # fmt: skip


@pytest.fixture(scope="module")
def source() -> Source:
    """A rig with a ripple and a drag that no model of it has."""
    unlisted = {
        "position_dependent_friction": {"a": 0.1, "L": 0.11, "p": 0.4},
        "quadratic_drag": {"c2": 0.05},
    }
    return Source(measured(replace(BENCH, effects=unlisted), BENCH))


def test_a_case_is_as_large_as_was_asked(source: Source) -> None:
    case = draw(source, "drive_gain_error", 10.0, [0])
    error = see(case.rig).plain_errors["x"] / see(source.rig).plain_errors["x"]
    assert error == pytest.approx(10.0, rel=0.05)
    assert case.truth["reached"] == pytest.approx(error, rel=1e-6)
    assert "drive_gain_error" in case.truth["accepted"]


def test_same_answers_are_measured_beside_what_is_left(source: Source) -> None:
    small = draw(source, "payload_mass", 3.0, [0]).truth
    large = draw(source, "payload_mass", 30.0, [0]).truth
    assert small["rises"]["payload_mass"] == pytest.approx(1.0, abs=0.01)
    for truth in (small, large):
        same = {name for name, rise in truth["rises"].items() if rise < RISES}
        assert set(truth["accepted"]) == same
    # What is the same answer beside much that is left need not be beside little.
    assert set(large["accepted"]) <= set(small["accepted"])


def test_viscous_friction_and_back_emf_are_one_answer(source: Source) -> None:
    assert {"viscous_friction", "back_emf"} <= set(
        draw(source, "viscous_friction", 10.0, [0]).truth["accepted"]
    )


def test_cases_of_a_seed_are_the_same(source: Source) -> None:
    one, two = (draw(source, "supply_sag", 3.0, [5, 1]) for _ in range(2))
    assert one.truth == two.truth
    assert one.truth != draw(source, "supply_sag", 3.0, [6, 1]).truth


def test_a_size_out_of_reach_says_how_far_it_goes(source: Source) -> None:
    with pytest.raises(NotPlantable, match=r"error [0-9.]+ times"):
        draw(source, "friction_drift", 1e4, [0])
    with pytest.raises(NotPlantable, match="not in the log"):
        draw(source, "transmission_backlash", 3.0, [0])


def test_a_case_that_the_effect_itself_does_not_mend_is_refused(source: Source) -> None:
    assert draw(source, "drive_gain_error", 10.0, [0]).truth["left"] == pytest.approx(1.0)
    # Slow sliding counts as rest: more than this rig's model leaves, which is next to nothing.
    with pytest.raises(NotPlantable, match="even with the effect"):
        draw(source, "stribeck_friction", 3.0, [5, 1])


def test_controls_have_other_runs_each_and_nothing_planted(source: Source) -> None:
    found = controls(source)
    labels = [tuple(run.label for run in case.rig.runs) for case in found]
    assert len(set(labels)) == len(labels)
    assert labels[0] == ("0", "1", "2")
    assert all(case.rig.robot == BENCH and case.truth["effect"] is None for case in found)


def test_the_baseline_names_a_planted_gain_error(source: Source) -> None:
    case = draw(source, "drive_gain_error", 10.0, [1])
    found = baseline(case.rig)
    assert found.name in case.truth["accepted"]
    assert "drive_gain_error" in found.alike
    assert found.share > 0.8
    assert found.errors[""] == pytest.approx(1.0)
    assert all(found.errors[n] <= ALIKE * min(found.errors.values()) for n in found.alike)


def test_the_baseline_names_nothing_where_the_model_is_as_good() -> None:
    found = baseline(measured(BENCH, BENCH))
    assert (found.name, found.share) == ("", 0.0)


def test_channels_may_count_in_units_of_other_errors(source: Source) -> None:
    seen = weighed(source.seen, {"x": 2.0})
    assert seen.problem.noise["x"].sd == 2.0
    assert rms_of(seen.problem, [seen.problem.plain()])[0]["x"] == source.rest["x"]


def test_calibration_finds_the_values_of_the_rig() -> None:
    raw = Robot(
        {"mass": 0.4, "segments": 1.0, "viscous": 0.0, "gain": 1.5},
        {**BENCH.other, "surface.coulomb_force": 0.7, "uncertainty.mass": 0.1},
    )
    rig = measured(BENCH, raw)
    robot, found = calibrate(rig.runs, raw)
    assert "uncertainty.mass" not in robot.other
    assert found["rms_x_after"] < 0.02 * found["rms_x_before"]
    # Mass and gain are not told apart where friction is fitted too: ratios are.
    gain = found["gain"] / 1.5
    assert found["mass"] / gain == pytest.approx(0.5, rel=1e-2)
    assert found["viscous"] / gain == pytest.approx(0.8, rel=2e-2)
    assert found["coulomb_force"] / gain == pytest.approx(1.2, rel=1e-2)
