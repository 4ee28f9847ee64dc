"""The paper's own gap: an actuator that gives less than the anchors would allow."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import polars as pl

from locosweep import _core
from locosweep.files.atomic import write_frame, write_text
from locosweep.files.folder import make_folder

if TYPE_CHECKING:
    import os
    from pathlib import Path

_NOMINAL = """\
# The head segment of the paper's robot, as its designer would describe it.
[robot]
segments = 4          # paper
mass = 0.271          # kg, paper
gravity = 9.81

[surface]
mu_static = 0.5       # of the anchors, paper
mu_coulomb = 0.2      # of the moving segment on a lubricated pipe, assumed
viscous = 0.0
slope_deg = 0.0

[drive]
gain = 1.0

[sensor]
position_noise = 5e-6       # m, assumed as large as the step
position_resolution = 5e-6  # m, paper
"""
_MASS, _MU, _GRAVITY = 0.271, 0.2, 9.81
_LIMIT = 0.85
"""Force of the actuator at 10 V in N, from the paper."""
_BUILDUP = 6.0
"""Lubricant that piles up before the segment, assumed, N/m."""
_ANCHORS = 3 * 0.5 * _MASS * _GRAVITY
"""Static friction of three anchors in N: the highest level that is commanded."""
_LEVELS = (
    (0.62, 0.70, 0.78, 0.84),
    (0.60, 0.80, 1.00, 0.75),
    (0.70, 1.50, 0.82, _ANCHORS),
    (0.82, 0.66, 2.50, 0.72),
    (0.75, 0.90, 0.68, 1.20),
)
_PUSH, _PAUSE, _RATE = 0.35, 0.25, 200.0
_STEP = 1e-5
_SEED = 2013


def paper_gap(folder: str | os.PathLike[str]) -> tuple[Path, Path]:
    """Write runs.csv and nominal.toml of the paper's robot, whose reality differs twice.

    The drive commands forces up to what the anchors would hold (3.99 N); the real
    actuator gives 0.85 N at most, and lubricant piles up before the segment. Reality
    is the blind check's own simulator. Values that the paper does not state are
    marked as assumed in the nominal file.

    Examples
    --------
    >>> import tempfile
    >>> from locosweep.paper.gap import paper_gap
    >>> [path.name for path in paper_gap(tempfile.mkdtemp())]
    ['runs.csv', 'nominal.toml']
    """
    out = make_folder(folder)
    rig = {
        "segments": 4.0, "mass": _MASS, "gravity": _GRAVITY, "mu_coulomb": _MU,
        "viscous": 0.0, "slope_deg": 0.0, "gain": 1.0, "limit": np.inf,
    }  # fmt: skip
    effects = [
        ("drive_saturation", "law", {"F_max": _LIMIT}),
        ("lubricant_buildup", "law", {"k_b": _BUILDUP}),
    ]
    cycle = _PUSH + _PAUSE
    t = np.arange(round(4 * cycle * _RATE)) / _RATE
    runs: list[Any] = []
    jobs: list[Any] = []
    for i, levels in enumerate(_LEVELS):
        step = np.minimum((t / cycle).astype(int), 3)
        pushes = (t - step * cycle) >= _PAUSE
        runs.append((t, np.where(pushes, np.array(levels)[step], 0.0), 0.0))
        jobs.append((i, rig, effects, (0.0, 0.0), _STEP, _SEED + i))
    generator = np.random.default_rng(_SEED)
    frames = []
    read = _core.reality_run(runs, jobs, 1)
    for i, ((_, drive, _), (x, *_)) in enumerate(zip(runs, read, strict=True)):
        noisy = np.asarray(x) + generator.normal(0.0, 5e-6, t.size)
        steps = np.round(noisy / 5e-6) * 5e-6
        frames.append(pl.DataFrame({"run": [i] * t.size, "t": t, "drive": drive, "x": steps}))
    write_frame(out / "runs.csv", pl.concat(frames))
    write_text(out / "nominal.toml", _NOMINAL)
    return out / "runs.csv", out / "nominal.toml"
