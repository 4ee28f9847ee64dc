"""The diagnosis on runs whose cause is known."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from locosweep.diagnosis import Diagnosis, pipeline
from locosweep.diagnosis.pipeline import diagnose
from locosweep.diagnosis.select.search import Search
from locosweep.diagnosis.select.verdict import Choice, choose
from locosweep.errors import InputError
from locosweep.files.robot import Robot, load_robot
from locosweep.files.runs import Run, load_runs
from locosweep.simulation.replay import replay_runs

pytestmark = pytest.mark.whole

NOISE = 2e-5
ROBOT = Robot(
    {"mass": 0.25, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0, "viscous": 0.05},
    {"sensor.position_noise": NOISE},
)
PRACTICE = Path(os.environ.get("LOCOSWEEP_DATA", "")) / "practice"
needs_data = pytest.mark.skipif(
    not (os.environ.get("LOCOSWEEP_DATA") and PRACTICE.is_dir()),
    reason="LOCOSWEEP_DATA does not name a folder with practice cases",
)


def drives(*, both: bool = True, count: int = 4, samples: int = 300) -> list[Run]:
    """Runs of pulses and sines of several sizes, without readings."""
    t = np.linspace(0.0, 2.5, samples)
    runs = []
    for k in range(count):
        size = 1.0 + 0.12 * k
        wave = np.sin(2.0 * np.pi * (0.7 + 0.3 * k) * (t - 0.1))
        drive = size * (wave if both else np.abs(wave) * (wave > -0.3))
        drive[t < 0.1] = 0.0
        runs.append(Run(str(k), t, drive, {"x": np.zeros(samples)}))
    return runs


def measured(
    effects: dict[str, dict[str, float]], runs: list[Run], *extra: str, seed: int = 1
) -> pl.DataFrame:
    """What the sensors read where reality has `effects`."""
    frame = replay_runs(replace(ROBOT, effects=effects), runs)
    generator = np.random.default_rng(seed)
    noisy = {"run": frame["run"], "t": frame["t"]}
    noisy["drive"] = pl.Series(np.concatenate([run.drive for run in runs]))
    for name in ("x", *extra):
        values = frame[name].to_numpy()
        sd = NOISE if name.startswith("x") else 0.003
        noisy[name] = pl.Series(values + generator.normal(0.0, sd, values.size))
    return pl.DataFrame(noisy)


def test_no_gap() -> None:
    found = diagnose(measured({}, drives()), ROBOT)
    assert (found.status, found.effects, found.equivalent) == ("none", [], [])
    assert found.gap["shrink"] is None
    assert found.augmented.effects == {}


@pytest.mark.slow
def test_readings_that_freeze_are_told() -> None:
    frame = measured({}, drives(samples=150))
    x = frame["x"].to_numpy().copy()
    fast = int(np.argmax(np.diff(x[:150])))
    x[fast + 1] = x[fast]
    found = diagnose(frame.with_columns(x=x), ROBOT, max_effects=1)
    (one,) = found.report["readings"]
    assert (one["run"], one["column"], one["masked"]) == ("0", "x", True)
    assert one["t0"] == one["t1"] == frame["t"][fast + 1]
    assert any(f"x at {one['t0']:.4g} s" in w for w in found.warnings)
    assert found.status == "none"
    assert not diagnose(frame, ROBOT).report["readings"]


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("coulomb_error", {"d_mu": 0.02}),
        ("quadratic_drag", {"c2": 0.3}),
        ("drive_lag", {"T": 0.02}),
        ("drive_saturation", {"F_max": 1.05}),
        ("position_dependent_friction", {"a": 0.05, "L": 0.04, "p": 1.0}),
        ("sensor_scale", {"e": 0.02}),
        ("payload_mass", {"dm": 0.03}),
    ],
)
def test_one_effect(name: str, values: dict[str, float]) -> None:
    found = diagnose(measured({name: values}, drives()), ROBOT)
    assert found.status == "explained", found
    assert found.effects == [name]
    assert found.gap["after"] < 1.3 * NOISE < found.gap["before"]
    low, high = found.gap["shrink_ci"]
    assert low <= found.gap["shrink"] <= high
    row = next(c for c in found.candidates if c["effects"] == [name])
    for key, value in values.items():
        told = row["parameters"][name][key]
        assert abs(told["value"] - value) < 5.0 * told["std"] + 1e-3 * abs(value), key


@pytest.mark.slow
def test_two_effects() -> None:
    both = {"viscous_friction": {"c": 0.2}, "drive_deadzone": {"d": 0.05}}
    found = diagnose(measured(both, drives(), "force"), ROBOT)
    assert found.status in ("explained", "ambiguous"), found
    assert len(found.effects) == 2
    for name in both:
        assert any(name in names for names in found.equivalent), found.equivalent


@pytest.mark.slow
def test_anchor_slip_shows_in_the_rear() -> None:
    slip = {"anchor_slip": {"mu_static": 0.11, "mu_coulomb": 0.1}}
    found = diagnose(measured(slip, drives(), "x_rear"), ROBOT)
    assert found.equivalent == [["anchor_slip"]], found
    assert found.gap["channel"] == "x_rear"
    assert found.where["site"] == "body"


def test_twins_are_named_together_and_the_next_run_splits_them() -> None:
    """One way without a load sensor: mass, gain and load friction are one signal."""
    frictionless = replace(ROBOT, parameters={**ROBOT.parameters, "viscous": 0.0})
    truth = replace(frictionless, effects={"drive_gain_error": {"e": -0.05}})
    runs = drives(both=False)
    frame = replay_runs(truth, runs).select("run", "t", "x")
    noise = np.random.default_rng(3).normal(0.0, NOISE, frame.height)
    frame = frame.with_columns(
        pl.col("x") + pl.Series(noise), drive=pl.Series(np.concatenate([r.drive for r in runs]))
    )
    found = diagnose(frame, frictionless)
    assert found.status == "ambiguous", found
    assert {"drive_gain_error", "payload_mass"} <= set(found.equivalent[0])
    assert found.next_experiment["separates"]
    assert found.next_experiment["suggestion"]


def tethered(runs: list[Run], stiffness: float, slack: float | None = None) -> pl.DataFrame:
    """The nominal head on a spring, or a line with slack, in no list; in steps of 2e-5 s."""
    mass, level, c = 0.25, 0.3 * 0.25 * 9.81, 0.05
    frames = []
    generator = np.random.default_rng(5)
    for run in runs:
        x = v = 0.0
        reads = []
        for a, b, force in zip(run.t, np.append(run.t[1:], run.t[-1]), run.drive, strict=True):
            reads.append(x)
            steps = max(1, round((b - a) / 2e-5))
            h = (b - a) / steps
            for _ in range(steps if b > a else 0):
                push = force - stiffness * (x if slack is None else max(x - slack, 0.0))
                if v == 0.0 and abs(push) <= level:
                    continue
                way = np.sign(v) if v != 0.0 else np.sign(push)
                after = v + h * (push - way * level - c * v) / mass
                v = 0.0 if after * way < 0.0 else after
                x += h * v
        noisy = np.array(reads) + generator.normal(0.0, NOISE, len(reads))
        frames.append(
            pl.DataFrame(
                {"run": [run.label] * run.t.size, "t": run.t, "drive": run.drive, "x": noisy}
            )
        )
    return pl.concat(frames)


@pytest.mark.slow
def test_a_cause_in_no_list_stays_unexplained() -> None:
    found = diagnose(tethered(drives(samples=120), 6.0), ROBOT)
    assert found.status == "unexplained", found
    assert found.effects == []
    assert found.augmented.effects == {}


def test_one_run_keeps_its_last_part() -> None:
    runs = drives(count=1, samples=600)
    found = diagnose(measured({"coulomb_error": {"d_mu": 0.03}}, runs), ROBOT)
    assert any("coulomb_error" in names for names in found.equivalent)
    assert any("one run" in warning for warning in found.warnings)
    assert found.gap["held_out"] == []
    assert "last part" in found.gap["metric"]


def test_runs_that_are_refuted_by_the_one_kept_are_all_fitted() -> None:
    # Only the stronger of two runs reaches the limit, and it is the one that is kept.
    frame = measured({"drive_saturation": {"F_max": 1.05}}, drives(count=2))
    found = diagnose(frame, ROBOT)
    assert "drive_saturation" in found.equivalent[0]
    assert found.gap["held_out"] == []
    assert found.gap["shrink"] is None
    assert any("all are fitted" in warning for warning in found.warnings)


def test_what_kept_runs_refute_names_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuted(search: Search, most: int) -> Choice:
        return replace(choose(search, most), law_mismatch=True, missed=True)

    monkeypatch.setattr(pipeline, "choose", refuted)
    monkeypatch.setattr(pipeline, "_graded", lambda _data, _task, first: first)
    frame = measured({"coulomb_error": {"d_mu": 0.03}}, drives())
    found = diagnose(frame, ROBOT, holdout=["1"])
    assert found.status == "unexplained"
    verdict = found.report["verdict"]
    assert (verdict["equivalent"], verdict["alternatives"]) == ([], [])
    assert not verdict["law_mismatch"]


def test_runs_asked_for_are_kept() -> None:
    frame = measured({"coulomb_error": {"d_mu": 0.03}}, drives())
    found = diagnose(frame, ROBOT, holdout=["2"])
    assert found.gap["held_out"] == ["2"]
    assert found.gap["used_for_fit"] == ["0", "1", "3"]
    with pytest.raises(InputError, match="no run 7"):
        diagnose(frame, ROBOT, holdout=["7"])


@pytest.mark.slow
def test_same_report_for_any_number_of_threads_and_any_form_of_runs(tmp_path: Path) -> None:
    frame = measured({"sensor_scale": {"e": 0.03}}, drives(samples=150))
    one = diagnose(frame, ROBOT, threads=1)
    assert diagnose(frame, ROBOT, threads=3).report == one.report
    frame.write_csv(tmp_path / "runs.csv")
    for form in (tmp_path / "runs.csv", frame.to_dict()):
        other = diagnose(form, ROBOT)
        assert other.report["verdict"] == one.report["verdict"]


def test_the_augmented_model_replays_to_the_stated_error(tmp_path: Path) -> None:
    frame = measured({"drive_lag": {"T": 0.03}}, drives())
    found = diagnose(frame, ROBOT, holdout=["1"])
    frame.write_csv(tmp_path / "runs.csv")
    runs, _ = load_runs(tmp_path / "runs.csv")
    read = replay_runs(found.augmented, runs)
    kept = frame.filter(pl.col("run") == "1")["x"].to_numpy()
    error = kept - read.filter(pl.col("run") == "1")["x"].to_numpy()
    assert np.sqrt(np.mean(error**2)) < 1.5 * found.gap["after"]


def test_runs_that_carry_little_say_so() -> None:
    runs = [replace(run, drive=0.1 * run.drive) for run in drives()]
    found = diagnose(measured({"coulomb_error": {"d_mu": 0.05}}, runs), ROBOT)
    assert found.status == "none"
    assert any("never moves" in warning for warning in found.warnings)
    assert len(found.not_visible) > 10


def test_a_gap_in_force_of_a_head_that_never_moves_is_told() -> None:
    """The error of x is 0 then, with any model."""
    noise = np.random.default_rng(1)
    t = np.arange(0.0, 2.0, 0.01)
    parts = []
    for i in range(4):
        drive = 0.4 * np.sin(2.0 * np.pi * (0.5 + 0.3 * i) * t)
        force = drive + 0.05 * np.sin(40.0 * t) + noise.normal(0.0, 1e-3, t.size)
        columns = {"run": np.full(t.size, i), "t": t, "drive": drive, "x": 0.0 * t, "force": force}
        parts.append(pl.DataFrame(columns))
    found = diagnose(pl.concat(parts), replace(ROBOT, other={}))
    assert found.status == "unexplained"
    assert any("never moves" in warning for warning in found.warnings)


@pytest.mark.slow
def test_millimetres_are_suspected() -> None:
    frame = measured({}, drives(samples=100)).with_columns(pl.col("x") * 1e3)
    found = diagnose(frame, ROBOT, max_effects=1)
    assert any("--unit x=mm" in warning for warning in found.warnings)
    assert {one["kind"] for one in found.report["readings"]} == {"unit"}
    assert found.effects == []


def test_arguments() -> None:
    frame = measured({}, drives(samples=60))
    with pytest.raises(InputError, match="max_effects"):
        diagnose(frame, ROBOT, max_effects=4)
    with pytest.raises(InputError, match="effects"):
        diagnose(frame, replace(ROBOT, effects={"drive_lag": {"T": 0.1}}))
    with pytest.raises(InputError, match="one length"):
        diagnose({"t": [0.0, 1.0], "x": [0.0]}, ROBOT)


def answer(found: Diagnosis, truth: dict[str, object]) -> bool:
    """Whether a verdict is right, up to what fits as well."""
    if truth["status"] != "explained":
        return found.status == truth["status"]
    effects = truth["effects"]
    assert isinstance(effects, list)
    named = len(found.equivalent) == len(effects)
    return named and all(any(e in names for names in found.equivalent) for e in effects)


@needs_data
@pytest.mark.parametrize("case", ["case_006", "case_008", "case_011", "case_013", "case_022"])
def test_practice(case: str) -> None:
    truth = json.loads((PRACTICE / "truth.json").read_text())["cases"][case]
    folder = PRACTICE / case
    found = diagnose(folder / "runs.csv", folder / "nominal.toml")
    assert answer(found, truth), found
    if found.effects:
        check, _ = load_runs(folder / "check.csv")
        read = {}
        for model in (load_robot(folder / "nominal.toml"), found.augmented):
            x = replay_runs(model, check)["x"].to_numpy()
            kept = np.concatenate([run.channels["x"] for run in check])
            read[bool(model.effects)] = float(np.sqrt(np.nanmean((kept - x) ** 2)))
        shrink = 1.0 - read[True] / read[False]
        assert shrink > 0.5


@pytest.mark.slow
def test_valley_that_bends() -> None:
    """Fits to whole runs of stick-slip stop far from the truth; windows lead there."""
    t = np.linspace(0.0, 10.0, 2000)
    runs = []
    for k in range(6):
        wave = np.sin(2.0 * np.pi * (0.4 + 0.13 * k) * t)
        drive = (0.9 + 0.12 * k) * (wave if k % 2 else np.sign(wave) * (np.abs(wave) > 0.4))
        drive[t < 0.1] = 0.0
        runs.append(Run(str(k), t, drive, {"x": np.zeros(t.size)}))
    truth = {"F_s": 0.9, "v_s": 0.03, "delta": 1.5}
    robot = replace(ROBOT, parameters={**ROBOT.parameters, "viscous": 0.0})
    frame = replay_runs(replace(robot, effects={"stribeck_friction": truth}), runs)
    noise = np.random.default_rng(1).normal(0.0, NOISE, frame.height)
    drive = pl.Series("drive", np.concatenate([run.drive for run in runs]))
    measured_runs = frame.select("run", "t", pl.col("x") + pl.Series(noise)).with_columns(drive)
    found = diagnose(measured_runs, robot)
    assert (found.status, found.equivalent) == ("explained", [["stribeck_friction"]])
    assert not found.report["verdict"]["law_mismatch"]
    values = found.augmented.effects["stribeck_friction"]
    assert values == pytest.approx(truth, rel=0.01)
