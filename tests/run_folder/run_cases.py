"""Sweeps that tests store, and what is told of a run folder from outside."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Any

import numpy as np

import locosweep as ls

if TYPE_CHECKING:
    from pathlib import Path

CLOSED: dict[str, Any] = {
    "quantity": ["mean_velocity", "peak_power"],
    "mu_static": np.linspace(0.2, 0.8, 7),
    "slope_deg": [0.0, 10.0, 30.0],
    "segments": range(2, 9),
    "mu_coulomb": 0.3,
}
SIMULATED: dict[str, Any] = {
    "quantity": "final_position",
    "mu_static": np.linspace(0.3, 0.6, 5),
    "drive_amplitude": [0.5, 1.0, 2.0],
    "mu_coulomb": 0.3,
    "law": "lugre",
    "drive": "sine",
}
GAIT: dict[str, Any] = {
    "quantity": ["gait_advance", "mean_velocity"],
    "mu_static": np.linspace(0.3, 0.6, 4),
    "segments": range(3, 6),
    "mu_coulomb": 0.25,
}
REDUCED: dict[str, Any] = {
    "quantity": "mean_velocity",
    "mu_static": np.linspace(0.2, 0.8, 9),
    "slope_deg": [0.0, 10.0, 30.0],
    "segments": range(2, 40),
    "mu_coulomb": 0.3,
    "over": "segments",
    "reduce": ["argmax", "max", "quantile"],
    "q": 0.25,
    "dtype": "float32",
}
TABLE: dict[str, Any] = {
    "quantity": "final_speed",
    "mu_static": [0.3, 0.5],
    "mass": [0.2, 0.4, 0.7],
    "mu_coulomb": 0.3,
    "drive": "table",
    "table": ([0.0, 0.1, 1.0], [2.0, 1.5, -1.0]),
}
ALL = {"closed": CLOSED, "simulated": SIMULATED, "gait": GAIT, "reduced": REDUCED, "table": TABLE}


def forget_last_chunk(folder: Path) -> None:
    """Take the last chunk of the plan out of a run's log, wherever in the log it finished."""
    (log,) = (folder / "log").iterdir()
    lines = log.read_bytes().splitlines(keepends=True)
    chunks = [json.loads(line.rpartition(b"\t")[0]).get("chunk", -1) for line in lines]
    del lines[chunks.index(max(chunks))]
    log.write_bytes(b"".join(lines))


def data_files(folder: Path) -> dict[str, str]:
    """Hash of every file of the store under its final name."""
    root = folder / "data.zarr"
    return {
        str(path.relative_to(root)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(root.rglob("*"))
        if path.is_file() and not path.name.endswith(".partial")
    }


def partials(folder: Path) -> list[str]:
    """Names of half-written files."""
    return [path.name for path in folder.rglob("*.partial")]


def same(run: ls.Run, result: ls.Result) -> bool:
    """Whether a run holds the bits of a result, NaN as NaN."""
    found = run.to_result()
    return all(
        found[o.name].dtype == result[o.name].dtype
        and found[o.name].shape == result[o.name].shape
        and np.array_equal(found[o.name], result[o.name], equal_nan=True)
        and np.array_equal(np.signbit(found[o.name]), np.signbit(result[o.name]))
        and np.array_equal(found.status_of(o.name), result.status_of(o.name))
        for o in result.outputs
    )
