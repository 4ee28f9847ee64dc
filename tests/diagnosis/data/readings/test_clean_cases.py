"""No finding where readings are as they should be: false alarms on runs of every effect."""

from __future__ import annotations

import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from locosweep.diagnosis.data.noise import noise_warnings
from locosweep.diagnosis.data.readings.columns import check_columns
from locosweep.diagnosis.data.readings.drive_spikes import check_drives
from locosweep.diagnosis.data.readings.find import check_readings
from locosweep.diagnosis.effects.catalogue import parameters_of, starts_of
from locosweep.diagnosis.effects.scale import scale_of
from locosweep.files.robot import Robot, load_robot
from locosweep.files.runs import Run, load_runs
from locosweep.simulation.replay import effects, nominal_of, replay_runs, sensor_of
from locosweep.validation import cases
from locosweep.validation.case_files import runs_file, write_case
from locosweep.validation.experiment import Experiment, World
from locosweep.validation.laws import LAWS, draw_cause
from locosweep.validation.rigs import draw_rig, draw_sensors

NAMES = ["none", *(record.name for record in effects())]
RIG = {"mass": 0.3, "gravity": 9.81, "mu_coulomb": 0.25, "segments": 4.0, "viscous": 0.1}
STEP = 1e-4


def findings(runs: list[Run], robot: Robot) -> list[str]:
    """All that is said of readings, but for a head that an effect holds in all runs."""
    columns = check_columns(runs, robot)
    checked = check_readings(columns.runs, nominal_of(robot), sensor_of(robot))
    found = [*check_drives(runs)[1], *columns.findings, *checked.findings]
    said = [
        f"{one.run} {one.t0} {one.column} {one.kind}" for one in found if "dead" not in one.note
    ]
    return said + noise_warnings(runs, sensor_of(robot))


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("noise", "coarse"), [(2e-5, False), (8e-5, True)])
def test_replayed_effects(name: str, noise: float, coarse: bool) -> None:
    rate = 50.0 if coarse else 400.0
    t = np.arange(0.0, 3.0, 1.0 / rate)
    rng = np.random.default_rng(zlib.crc32(name.encode()))
    robot = Robot(RIG, {"sensor.position_noise": noise, "sensor.force_noise": 0.01})
    if coarse:
        robot.other["sensor.position_resolution"] = STEP
    runs = []
    for k in range(4):
        wave = np.sin(2.0 * np.pi * (0.6 + 0.5 * k) * (t - 0.2))
        drive = 1.6 * (np.sign(wave) if k % 2 else wave) + 0.3
        runs.append(Run(str(k), t, np.where(t < 0.2, 0.0, drive), {"x": 0.1 * t}))
    given: dict[str, dict[str, float]] = {}
    if name != "none":
        scale = scale_of(robot, runs)
        free = parameters_of(name, scale)
        values = starts_of(name, scale)[0]
        given = {name: {f.name: float(v) for f, v in zip(free, values, strict=True)}}
    read = replay_runs(replace(robot, effects=given), runs)
    measured = []
    for k, run in enumerate(runs):
        own = slice(k * t.size, (k + 1) * t.size)
        channels = {c: read[c].to_numpy()[own] for c in ("x", "x_rear", "force")}
        for c, sd in (("x", noise), ("x_rear", noise), ("force", 0.01)):
            channels[c] = channels[c] + rng.normal(0.0, sd, t.size)
            if coarse and c != "force":
                channels[c] = np.round(channels[c] / STEP) * STEP
        measured.append(replace(run, channels=channels))
    assert findings(measured, robot) == []


def simulated(name: str, form: str, out: Path) -> tuple[list[Run], Robot] | None:
    """Runs of a drawn rig in the reality of the blind check; None where the cause has no place."""
    rng = np.random.default_rng([77, zlib.crc32(f"{name} {form}".encode())])
    for _ in range(50):
        rig = draw_rig(rng, exact=False)
        level = "coulomb_force" in rig.nominal
        if name in cases.absent_of(rig) or (name == "coulomb_error" and (form == "force") != level):
            continue
        plan = cases._plan(rng, rig)
        drives = tuple(cases._drives(rng, rig, plan["count"], plan))
        blind = Experiment(rig, drives, cases._NO_SENSORS)
        scale = cases.scale_of_runs(blind)
        if scale.travel < 0.1 * plan["travel"]:
            continue
        sensors = draw_sensors(rng, rig, scale.travel, scale.speed, scale.force)
        strength = float(np.exp(rng.uniform(np.log(0.02), 0.0)))
        effect = draw_cause(rng, scale, name, form).effect(strength)
        experiment = Experiment(rig, drives, sensors)
        world = World({}, ((*effect[:2], cases._rounded(effect[2])),))
        truth = {"effects": [], "accepted": [], "kind": "one", "plan": plan, "channels": []}
        write_case(cases.Case("one", experiment, experiment, world, truth), "a", out, [1])
        file = runs_file(out / "a")
        runs = load_runs(file)[0]
        return runs, load_robot(out / "a" / "nominal.toml")
    return None


@pytest.mark.slow
@pytest.mark.parametrize(("name", "form"), [law for law in LAWS if "reading" not in law[0]])
def test_simulated_causes(name: str, form: str, tmp_path: Path) -> None:
    drawn = simulated(name, form, tmp_path)
    assert drawn is not None
    assert findings(*drawn) == []
