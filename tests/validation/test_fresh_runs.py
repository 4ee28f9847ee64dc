"""Error reduction of a model on fresh runs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
import pytest

from locosweep.files.robot import load_robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import replay_runs
from locosweep.validation.fresh_runs import fresh_reduction

NOMINAL = """\
[robot]
segments = 4
mass = 0.3

[surface]
mu_static = 0.3
mu_coulomb = 0.2
"""
REAL = NOMINAL + "\n[effects.viscous_friction]\nc = 0.8\n"
HALF = NOMINAL + "\n[effects.viscous_friction]\nc = 0.4\n"
STARTS = [(0.02, 0.1), (-0.01, 0.0)]
TRUTH: dict[str, Any] = {"check_starts": STARTS}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Models, and runs of the real one that begin at the true starts."""
    out = tmp_path_factory.mktemp("fresh")
    for name, text in (("nominal", NOMINAL), ("real", REAL), ("half", HALF)):
        (out / f"{name}.toml").write_text(text)
    t = np.arange(0.0, 1.0, 0.01)
    runs = [
        Run(f"c{i}", t, 1.5 * np.sin((4 + i) * t),
            {"x": np.full(t.size, x), "v": np.full(t.size, v)})
        for i, (x, v) in enumerate(STARTS)
    ]  # fmt: skip
    read = replay_runs(load_robot(out / "real.toml"), runs)
    drive = pl.Series("drive", np.concatenate([run.drive for run in runs]))
    read.select("run", "t", drive, "x").write_csv(out / "check.csv")
    return out


def reduction(folder: Path, model: str, channel: str = "x") -> float | None:
    files = (folder / name for name in ("check.csv", "nominal.toml", f"{model}.toml"))
    return fresh_reduction(*files, channel, TRUTH)


def test_the_true_model_takes_all_of_the_gap(folder: Path) -> None:
    assert reduction(folder, "real") == pytest.approx(1.0, abs=1e-6)


def test_the_nominal_model_takes_nothing(folder: Path) -> None:
    assert reduction(folder, "nominal") == 0.0


def test_half_the_effect_takes_a_part(folder: Path) -> None:
    part = reduction(folder, "half")
    assert part is not None
    assert 0.2 < part < 0.8


@pytest.mark.parametrize("channel", ["force", "power"])
def test_a_channel_that_is_not_measured_or_not_replayed_has_none(
    folder: Path, channel: str
) -> None:
    assert reduction(folder, "real", channel) is None
