"""Planted effects: the new model with the effect is the calibrated model on the old log."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from locosweep.diagnosis.effects.catalogue import families
from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import effects, replay_runs
from locosweep.validation.extra_friction import LAWS, drives_with
from locosweep.validation.planting import IMPOSSIBLE, WAYS, NotPlantable, Rig, plant, true_values

T = np.arange(0.0, 3.0, 0.004)
LINEAR = Robot(
    {"mass": 0.5, "segments": 1.0, "viscous": 0.8, "gain": 1.5, "slope_deg": 2.0},
    {"surface.coulomb_force": 1.2, "bench.kind": "linear", "sensor.position_noise": 1e-7},
)
SNAKE = Robot(
    {"mass": 0.5, "segments": 4.0, "viscous": 0.8, "gain": 1.5, "mu_coulomb": 0.25},
    {"sensor.position_noise": 1e-7},
)
PENDULUM = Robot(
    {"mass": 0.02, "segments": 1.0, "viscous": 0.02, "gain": 1.5},
    {
        "surface.coulomb_force": 0.08, "bench.kind": "rotary", "bench.gravity_torque": 0.6,
        "sensor.position_noise": 1e-7,
    },
)  # fmt: skip


def rig(robot: Robot, strength: float) -> Rig:
    """Noise-free runs of a model, which is calibrated by construction."""
    # Weak at first: a delayed drive then begins as the log says, and where it is 0 until it
    # changes, positions are averaged.
    begins = T > 0.15
    drives = [
        strength * np.where(begins, np.clip(1.3 * np.sin(6.0 * T + 2.5 * T**2), -1.0, 1.0), 0.01),
        strength * np.where(begins & (T % 1.1 < 0.6), np.sin(11.0 * T), 0.01),
    ]
    runs = [Run(f"{i}", T, drive, {"x": np.zeros(T.size)}) for i, drive in enumerate(drives)]
    read = replay_runs(robot, runs)["x"].to_numpy().reshape(len(runs), -1)
    return Rig(robot, tuple(replace(r, channels={"x": x}) for r, x in zip(runs, read, strict=True)))


RIGS = {"linear": rig(LINEAR, 2.4), "snake": rig(SNAKE, 2.4), "pendulum": rig(PENDULUM, 0.4)}
EXACT = 1e-9
LEFT = {
    # Means over a sample of what bends within it.
    "supply_sag": 1e-5, "sensor_delay": 5e-4,
    # Jumps of the drive at rest fall within a sample: friction takes up a part of it.
    "drive_lag": 0.06, "drive_delay": 0.06,
    # Slow sliding counts as rest; friction that is highest there is met worst.
    **dict.fromkeys(LAWS, 0.03), "stribeck_friction": 0.08,
}  # fmt: skip
"""Share of the planted gap that is left, where a way is not exact."""
CASES = [
    (where, name, way) for where in RIGS for name, ways in WAYS.items() for way in range(len(ways))
]


def left(name: str, way: int, on: Rig, u: float) -> tuple[float, float]:
    """Largest error of the new model with the effect, and root mean square of the planted gap."""
    family = families(on.scale)[name]
    shapes = {s.name: 0.3 + s.starts[0] if s.name == "p" else s.starts[-1] for s in family.shapes}
    values = family.make(u, shapes)
    planted = plant(on, name, values, way)
    values = true_values(on, name, values)
    full = replace(planted.robot, effects={name: values})
    read = np.concatenate([run.channels["x"] for run in planted.runs])
    model, plain = (replay_runs(r, planted.runs)["x"].to_numpy() for r in (full, planted.robot))
    size = np.sqrt(np.nanmean((plain - read) ** 2))
    return float(np.sqrt(np.nanmean((model - read) ** 2))), float(size)


@pytest.mark.parametrize(("where", "name", "way"), CASES)
def test_the_new_model_with_the_effect_moves_as_was_measured(where, name, way):
    if name == "slope_error" and where == "pendulum":
        pytest.skip("a rotary bench has no slope")
    family = families(RIGS[where].scale)[name]
    exact = way == 0 and len(WAYS[name]) > 1
    for sign in family.signs:
        error, gap = left(name, way, RIGS[where], sign * (0.15 if name in LAWS else 0.03))
        assert gap > 2e-4
        assert error < (EXACT if exact else LEFT.get(name, EXACT)) * gap


@pytest.mark.parametrize("where", RIGS)
def test_a_wrong_strength_leaves_a_gap(where):
    on = RIGS[where]
    values = families(on.scale)["quadratic_drag"].make(0.05, {})
    planted = plant(on, "quadratic_drag", values)
    half = replace(planted.robot, effects={"quadratic_drag": {"c2": 0.5 * values["c2"]}})
    read = np.concatenate([run.channels["x"] for run in on.runs])
    errors = [
        np.sqrt(np.mean((replay_runs(r, planted.runs)["x"].to_numpy() - read) ** 2))
        for r in (half, planted.robot)
    ]
    assert 0.3 * errors[1] < errors[0] < 0.7 * errors[1]


def test_a_resting_head_goes_on_resting_under_a_higher_level():
    t = np.arange(0.0, 1.0, 0.01)
    run = Run("0", t, 0.6 * np.sin(9.0 * t), {"x": np.zeros(t.size)})
    still = Rig(LINEAR, (run,))
    (drive,) = drives_with(
        LAWS["coulomb_error"], still.nominal, still.runs, still.motions, {"d_force": 0.6}
    )
    # The excess over the slope's pull grows in the ratio of the levels.
    pull = 0.5 * 9.81 * np.sin(np.radians(2.0))
    assert 1.5 * drive - pull == pytest.approx(1.5 * (1.5 * run.drive - pull), rel=1e-9)


def test_every_effect_can_be_planted_or_it_is_said_why():
    names = {record.name for record in effects()}
    assert set(WAYS) | set(IMPOSSIBLE) == names
    assert not set(WAYS) & set(IMPOSSIBLE)


@pytest.mark.parametrize(
    ("name", "values", "why"),
    [
        ("transmission_backlash", {"b": 0.01, "m_d": 0.1}, "drive's side"),
        ("payload_mass", {"dm": 0.6}, "too little mass"),
        ("viscous_friction", {"c": 1.0}, "too little viscous"),
        ("drive_delay", {"T": 2.0}, "half of a run"),
        ("drive_gain_error", {"e": -1.0}, "no inverse"),
        ("supply_sag", {"a": 1.0, "T": 0.1}, "no inverse"),
        ("drive_saturation", {"F_max": 0.1}, "proportion"),
    ],
)
def test_what_a_log_does_not_allow_is_refused(name, values, why):
    with pytest.raises(NotPlantable, match=why):
        plant(RIGS["linear"], name, values)


def test_no_limit_is_planted_where_the_drive_never_stands_at_one():
    smooth = replace(RIGS["linear"].runs[0], drive=np.sin(3.0 * T))
    with pytest.raises(NotPlantable, match="never stands"):
        plant(Rig(LINEAR, (smooth,)), "drive_saturation", {"F_max": 2.0})


def test_a_drive_beyond_the_limit_of_the_file_is_refused():
    limited = replace(LINEAR, parameters={**LINEAR.parameters, "drive_limit": 3.6})
    with pytest.raises(NotPlantable, match="limit of the nominal file"):
        plant(Rig(limited, RIGS["linear"].runs), "drive_deadzone", {"d": 0.3})


def test_a_delayed_drive_is_logged_before_the_first_reading_of_a_resting_head():
    moving = Run("m", T, np.cos(4.0 * T) * 2.4, {"x": np.sin(4.0 * T)})
    resting = RIGS["linear"].runs[0]
    planted = plant(Rig(LINEAR, (resting, moving)), "drive_delay", {"T": 0.1})
    first, second = planted.runs
    assert np.isnan(first.channels["x"][:25]).all()
    assert np.isfinite(first.channels["x"][25:]).all()
    assert first.t[25] == resting.t[0]
    assert first.drive[:700] == pytest.approx(resting.drive[:700], abs=1e-9)
    assert second.t[0] == 0.0
    assert second.drive == pytest.approx(moving.drive[25:], abs=1e-9)


@pytest.mark.parametrize("name", [n for n in WAYS if n not in ("slope_error", "drive_delay")])
def test_a_force_sensor_reads_what_the_new_model_gives(name):
    on = RIGS["pendulum"]
    force = np.split(replay_runs(on.robot, on.runs)["force"].to_numpy(), len(on.runs))
    runs = [
        replace(run, channels={**run.channels, "force": f})
        for run, f in zip(on.runs, force, strict=True)
    ]
    on = Rig(on.robot, tuple(runs))
    family = families(on.scale)[name]
    values = family.make(0.03, {s.name: s.starts[0] for s in family.shapes})
    for way in range(len(WAYS[name])):
        try:
            planted = plant(on, name, values, way)
        except NotPlantable:
            assert (name, way) == ("back_emf", 0)
            continue
        full = replace(planted.robot, effects={name: true_values(on, name, values)})
        model = replay_runs(full, planted.runs)["force"].to_numpy()
        read = np.concatenate([run.channels["force"] for run in planted.runs])
        # A lag has the means of neighbouring samples at each.
        assert np.median(np.abs(model - read)) < 1e-2 * on.scale.force


def test_more_friction_is_not_planted_where_power_is_measured():
    on = RIGS["linear"]
    runs = tuple(replace(r, channels={**r.channels, "power": np.ones(T.size)}) for r in on.runs)
    with pytest.raises(NotPlantable, match="power column"):
        plant(Rig(LINEAR, runs), "quadratic_drag", {"c2": 0.1})


def test_a_slope_of_a_run_moves_with_that_of_the_model():
    runs = tuple(replace(run, slope_deg=5.0) for run in RIGS["linear"].runs)
    planted = plant(Rig(LINEAR, runs), "slope_error", {"d_alpha_deg": 1.5})
    assert planted.robot.parameters["slope_deg"] == 0.5
    assert [run.slope_deg for run in planted.runs] == [3.5, 3.5]
