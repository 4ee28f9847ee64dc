"""Whole diagnoses of bad readings: they are named, and the verdict is that of the good ones."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import polars as pl
import pytest

from locosweep.diagnosis import diagnose
from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import replay_runs

pytestmark = pytest.mark.whole

NOISE = 2e-5
ROBOT = Robot(
    {"mass": 0.25, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0, "viscous": 0.05},
    {"sensor.position_noise": NOISE},
)
LAG = {"drive_lag": {"T": 0.03}}
T = np.linspace(0.0, 2.5, 300)
Fault = Callable[[np.ndarray, np.random.Generator], np.ndarray]


def measured(samples: int = 300, **effects: dict[str, float]) -> pl.DataFrame:
    t, runs = np.linspace(0.0, 2.5, samples), []
    for k in range(4):
        wave = (1.0 + 0.12 * k) * np.sin(2.0 * np.pi * (0.7 + 0.3 * k) * (t - 0.1))
        runs.append(Run(str(k), t, np.where(t < 0.1, 0.0, wave), {"x": np.zeros(t.size)}))
    x = replay_runs(replace(ROBOT, effects=effects), runs)["x"].to_numpy()
    x = x + np.random.default_rng(1).normal(0.0, NOISE, x.size)
    columns = {"run": np.repeat(list("0123"), t.size), "t": np.tile(t, 4)}
    return pl.DataFrame({**columns, "drive": np.concatenate([r.drive for r in runs]), "x": x})


def spikes(x: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return x + (rng.random(x.size) < 0.01) * 0.01 * rng.choice([-1.0, 1.0], x.size)


def zeros(x: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return np.where(rng.random(x.size) < 0.05, 0.0, x)


def holds(x: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    held = np.append(False, rng.random(x.size - 1) < 0.03)
    return x[np.maximum.accumulate(np.where(held, 0, np.arange(x.size)))]


def frozen(x: np.ndarray, _: np.random.Generator) -> np.ndarray:
    x = x.copy()
    x[700:740], x[1050:] = x[699], x[1049]
    return x


def slip(x: np.ndarray, _: np.random.Generator) -> np.ndarray:
    return x + np.where((np.arange(x.size) >= 450) & (np.arange(x.size) < 600), 0.01, 0.0)


def huge(x: np.ndarray, _: np.random.Generator) -> np.ndarray:
    x = x.copy()
    x[450] = 1e186
    return x


FAULTS: dict[str, tuple[Fault, str]] = {
    "spikes": (spikes, "spike"), "zeros": (zeros, "dropout"), "holds": (holds, "dropout"),
    "frozen": (frozen, "frozen"), "slip": (slip, "slip"), "huge": (huge, "spike"),
}  # fmt: skip


def with_x(frame: pl.DataFrame, x: np.ndarray) -> pl.DataFrame:
    return frame.with_columns(pl.Series("x", x))


@pytest.mark.filterwarnings("error")
class TestMasked:
    @pytest.mark.parametrize("fault", FAULTS)
    @pytest.mark.parametrize("effects", [{}, LAG], ids=["no gap", "lag"])
    def test_the_verdict_is_that_of_good_readings(self, fault: str, effects: dict[str, Any]):
        put, kind = FAULTS[fault]
        frame = measured(**effects)
        x = put(frame["x"].to_numpy(), np.random.default_rng(5))
        found = diagnose(with_x(frame, x), ROBOT, threads=1)
        assert (found.status, found.effects) == (
            ("explained", ["drive_lag"]) if effects else ("none", [])
        )
        rows = found.report["readings"]
        assert kind in {row["kind"] for row in rows}
        assert all(row["masked"] and row["column"] == "x" for row in rows)
        assert any("left out" in said for said in found.warnings)

    def test_noise_far_beyond_the_stated_one(self):
        frame = measured()
        more = np.random.default_rng(5).normal(0.0, 30.0 * NOISE, frame.height)
        found = diagnose(with_x(frame, frame["x"].to_numpy() + more), ROBOT, threads=1)
        assert found.status == "none"
        assert any("times the stated 2e-05" in said for said in found.warnings)

    def test_a_spike_of_the_drive(self):
        frame = measured(**LAG)
        drive = frame["drive"].to_numpy().copy()
        drive[450] = 1e38
        found = diagnose(frame.with_columns(pl.Series("drive", drive)), ROBOT, threads=1)
        assert found.effects == ["drive_lag"]
        assert found.report["readings"][0]["column"] == "drive"

    def test_good_readings_have_no_finding(self):
        found = diagnose(measured(**LAG), ROBOT, threads=1)
        assert found.report["readings"] == []
        assert found.warnings == []


@pytest.mark.filterwarnings("error")
class TestHopeless:
    def check(self, frame: pl.DataFrame, kind: str, says: str) -> None:
        begin = time.process_time()
        found = diagnose(frame, ROBOT, threads=1)
        assert time.process_time() - begin < 1.5
        assert (found.status, found.effects) == ("unexplained", [])
        assert {(row["kind"], row["masked"]) for row in found.report["readings"]} == {(kind, False)}
        assert says in found.warnings[0]
        assert found.summary.startswith("No cause is looked for")

    def test_wrong_columns_end_it_at_once(self):
        frame = measured(**LAG)
        self.check(frame.with_columns(pl.col("x") * 1e3), "unit", "--unit x=mm")
        self.check(frame.with_columns(pl.col("drive") * 1e2), "unit", "--unit drive=percent")
        self.check(frame.with_columns(-pl.col("x")), "sign", "wrong sign")
        self.check(frame.rename({"x": "drive", "drive": "x"}), "swapped", "--column x=drive")

    def test_a_dead_encoder(self):
        frame = measured()
        self.check(frame.with_columns(x=pl.lit(0.0)), "frozen", "is the encoder dead")
        rest = np.random.default_rng(2).normal(0.0, NOISE, frame.height)
        self.check(with_x(frame, rest), "frozen", "is the encoder dead")

    def test_the_report_can_be_saved(self, tmp_path):
        frame = measured().with_columns(pl.col("x") * 1e3)
        diagnose(frame, ROBOT, threads=1).save(tmp_path / "out")
        assert "--unit x=mm" in (tmp_path / "out" / "report.html").read_text()


@pytest.mark.filterwarnings("error")
class TestDegenerate:
    @pytest.mark.parametrize("robot", [ROBOT, Robot(dict(ROBOT.parameters))])
    def test_25_samples_a_run(self, robot: Robot):
        assert diagnose(measured(25), robot, threads=1).status == "none"

    @pytest.mark.parametrize("robot", [ROBOT, Robot(dict(ROBOT.parameters))])
    @pytest.mark.parametrize("samples", [25, 300])
    @pytest.mark.parametrize("noise", [0.0, NOISE])
    def test_drives_that_only_rest(self, robot: Robot, samples: int, noise: float):
        frame = measured(samples)
        x = np.random.default_rng(2).normal(0.0, noise, frame.height)
        found = diagnose(with_x(frame.with_columns(drive=pl.lit(0.0)), x), robot, threads=1)
        assert found.status == "none"
        assert any("never moves beyond the noise" in said for said in found.warnings)

    def test_one_dead_run_is_left_out(self):
        frame = measured(**LAG)
        x = frame["x"].to_numpy().copy()
        x[300:600] = 0.0
        found = diagnose(with_x(frame, x), ROBOT, threads=1)
        assert found.effects == ["drive_lag"]
        assert [row["run"] for row in found.report["where"]["runs"]] == ["0", "2", "3"]

    def test_one_short_run(self):
        frame = measured(**LAG).filter((pl.col("run") == "1") & (pl.col("t") < 0.35))
        assert 0.0 <= diagnose(frame, ROBOT, threads=1).probability <= 1.0


def test_slips_of_two_deviations_are_a_fault_of_the_readings_and_no_drift() -> None:
    # Half of the time the head rests; the encoder slips by two deviations of its noise every 0.7 s.
    t = np.arange(800) * 0.005
    wave = np.where(t % 1.0 < 0.5, np.sin(4.0 * np.pi * t), 0.0)
    runs = [Run(str(k), t, (1.0 + 0.2 * k) * wave, {"x": np.zeros(t.size)}) for k in range(3)]
    x = replay_runs(ROBOT, runs)["x"].to_numpy()
    x = x + np.random.default_rng(3).normal(0.0, NOISE, x.size)
    frame = pl.DataFrame({
        "run": np.repeat(list("012"), t.size),
        "t": np.tile(t, 3),
        "drive": np.concatenate([run.drive for run in runs]),
        "x": x + 2.0 * NOISE * np.floor(np.tile(t, 3) / 0.7),
    })  # fmt: skip
    found = diagnose(frame, ROBOT)
    assert not found.effects, found
    kinds = [row["kind"] for row in found.report["readings"]]
    assert kinds.count("slip") == len(kinds) >= 10
    assert any("which the motion does not: slipped?" in said for said in found.warnings)
