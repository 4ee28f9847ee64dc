"""Cases as files: what a user would hand in, and what stays sealed."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.errors import DataFileError
from locosweep.files import toml
from locosweep.files.atomic import replacing
from locosweep.files.channels import CHANNELS
from locosweep.kept_work.records import digest
from locosweep.validation.experiment import FINE, Experiment, World

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence
    from pathlib import Path

    import polars as pl

    from locosweep.validation.cases import Case

SEAL = "sealed.json"
"""Hashes of all truths, written before the first diagnosis."""


def case_name(index: int, *, gap_free: bool = False) -> str:
    """Return the folder of a case."""
    return f"{'free' if gap_free else 'case'}_{index:04d}"


def _frame(
    experiment: Experiment, case: Case, rng: np.random.Generator, prefix: str
) -> pl.DataFrame:
    """Measured runs in the contract's long form, noise and rounding included."""
    import polars as pl

    sensors = experiment.sensors
    read = experiment.read([case.world], FINE, 1)[0]
    parts = []
    for i, (drive, run) in enumerate(zip(experiment.drives, read, strict=True)):
        columns: dict[str, Any] = {
            "run": [f"{prefix}{i}"] * drive.t.size, "t": drive.t, "drive": drive.command
        }  # fmt: skip
        for channel in ("x", *sensors.channels):
            noise = sensors.noise(channel)
            noisy = run[channel] + rng.normal(0.0, noise, drive.t.size)
            if CHANNELS[channel].sensor == "position":
                step = sensors.position_resolution
                digits = max(0, 3 - math.floor(math.log10(step)))
                columns[channel] = np.round(np.round(noisy / step) * step, digits)
            else:
                columns[channel] = np.round(noisy, max(0, 3 - math.floor(math.log10(noise))))
        if drive.slope_given:
            columns["slope_deg"] = [drive.slope_deg] * drive.t.size
        parts.append(pl.DataFrame(columns))
    return pl.concat(parts)


def _reduction(experiment: Experiment, case: Case, readings: pl.DataFrame) -> dict[str, float]:
    """Return by how much the true effects, without the background, reduce each channel's error.

    Relative to the nominal model, root mean squares, as `fresh_runs.fresh_reduction`.
    """
    known = replace(case.world, effects=case.world.effects[: len(case.truth["effects"])])
    models = [
        {channel: np.concatenate([run[channel] for run in runs]) for channel in runs[0]}
        for runs in experiment.read([known, World()], FINE, 1)
    ]
    reached = {}
    for channel in ("x", *experiment.sensors.channels):
        measured = readings[channel].to_numpy()
        after, before = (np.sum((model[channel] - measured) ** 2) for model in models)
        reached[channel] = 1.0 - float(np.sqrt(after / before))
    return reached


_CELLS = 20
"""Parts of a run that the gap is located in."""


def _gap_cells(case: Case) -> tuple[str, list[list[Any]]]:
    """Channel where the gap is largest against its noise, and where it lies there."""
    experiment = case.experiment
    real, known = experiment.read([case.world, World()], FINE, 1)
    channels = ("x", *experiment.sensors.channels)
    squares = {
        c: [
            ((a[c] - b[c]) / experiment.sensors.deviation(c)) ** 2
            for a, b in zip(real, known, strict=True)
        ]
        for c in channels
    }
    channel = max(channels, key=lambda c: sum(float(s.sum()) for s in squares[c]))
    cells: list[list[Any]] = []
    for i, (drive, square) in enumerate(zip(experiment.drives, squares[channel], strict=True)):
        ends = np.linspace(0.0, drive.t[-1], _CELLS + 1)
        at = np.clip(np.searchsorted(ends, drive.t, side="right") - 1, 0, _CELLS - 1)
        sums = np.bincount(at, square, _CELLS)
        cells += [[f"r{i}", *pair] for pair in zip(ends[:-1], ends[1:], sums, strict=True)]
    return channel, cells


def _nominal(case: Case) -> str:
    """Return the text of a case's nominal file."""
    rig, sensors = case.experiment.rig, case.experiment.sensors
    n = rig.nominal
    mu = n.get("mu_coulomb")
    shown = {"position_noise", "position_resolution"}
    shown |= {f"{CHANNELS[c].sensor}_noise" for c in sensors.channels}
    kind = "rotary" if rig.rotary else "linear" if rig.linear_bench else None
    return toml.write({
        "robot": {"segments": int(n["segments"]), "mass": n["mass"], "gravity": n["gravity"]},
        "surface": {
            "coulomb_force": n.get("coulomb_force"),
            "mu_static": None if mu is None else round(1.3 * mu, 3),
            "mu_coulomb": mu,
            "viscous": n["viscous"],
            "slope_deg": n["slope_deg"],
        },
        "drive": {"gain": n["gain"], "limit": n["limit"] if math.isfinite(n["limit"]) else None},
        "bench": {"kind": kind, "gravity_torque": n.get("gravity_torque")},
        "sensor": {key: getattr(sensors, key) for key in sensors.stated if key in shown},
        "motor": rig.motor,
        "uncertainty": rig.uncertainty,
    })  # fmt: skip


def runs_file(folder: Path) -> Path:
    """Return the measured runs of a case, in whichever form."""
    for name in ("runs.csv", "runs.parquet"):
        if (folder / name).exists():
            return folder / name
    raise FileNotFoundError(folder / "runs.csv")


def files_of(out: Path, name: str) -> list[Path]:
    """Return the files of a case, the sealed ones among them."""
    sealed = out / "sealed" / name
    open_ = [runs_file(out / name), out / name / "nominal.toml"]
    return [*open_, sealed / "truth.json", sealed / "check.csv"]


def write_case(case: Case, name: str, out: Path, seed: list[int]) -> None:
    """Write one case: runs and nominal model to see, check runs and truth sealed."""
    rng = np.random.default_rng([*seed, 1])
    open_, sealed = out / name, out / "sealed" / name
    open_.mkdir(parents=True, exist_ok=True)
    sealed.mkdir(parents=True, exist_ok=True)
    runs, check = (_frame(e, case, rng, p) for e, p in ((case.experiment, "r"), (case.check, "c")))
    if rng.random() < 0.1:
        runs.write_parquet(open_ / "runs.parquet")
    else:
        runs.write_csv(open_ / "runs.csv")
    (open_ / "nominal.toml").write_text(_nominal(case))
    check.write_csv(sealed / "check.csv")
    effects = [{"name": n, "form": f, "parameters": p} for n, f, p in case.world.effects]
    channel, cells = _gap_cells(case)
    truth = {
        "case": name,
        **case.truth,
        "world": effects,
        "gap_channel": channel,
        "gap_cells": cells,
        "check_starts": [drive.start for drive in case.check.drives],
    }
    if "background" in truth:
        truth["reached"] = {
            "runs": _reduction(case.experiment, case, runs),
            "check": _reduction(case.check, case, check),
        }
    text = json.dumps(_plain(truth), indent=1, allow_nan=False)
    (sealed / "truth.json").write_text(text)


def _plain(value: Any) -> Any:
    """Numbers that JSON has, to six digits."""
    if isinstance(value, dict):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(v) for v in value]
    if isinstance(value, float | np.floating):
        return float(f"{float(value):.6g}") if math.isfinite(value) else None
    return value


def seal(
    out: Path, names: Iterable[str], files: Sequence[str] = ("truth.json", "check.csv")
) -> Path:
    """Write the hashes of all truths, of which each is some `files`."""
    hashes = {name: {f: digest(out / "sealed" / name / f) for f in files} for name in names}
    path = out / SEAL
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(hashes, indent=1, sort_keys=True))
    return path


def read_truth(out: Path, name: str) -> dict[str, Any]:
    """Open a sealed truth; DataFileError if it was altered since."""
    sealed = json.loads((out / SEAL).read_text())
    for file, known in sealed[name].items():
        path = out / "sealed" / name / file
        if digest(path) != known:
            raise DataFileError(f"{path}: altered since it was sealed (hash differs)")
    truth: dict[str, Any] = json.loads((out / "sealed" / name / "truth.json").read_text())
    return truth
