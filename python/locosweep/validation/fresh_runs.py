"""Shrink of the gap on fresh runs of the same reality, which no diagnosis has seen."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.files.channels import REPLAYED
from locosweep.files.robot import load_robot
from locosweep.files.runs import Run, load_runs
from locosweep.simulation.replay import replay_runs

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray


def _started(run: Run, start: tuple[float, float]) -> Run:
    """Return a run that is replayed from where its head really started."""
    x, v = (np.full(run.t.size, value) for value in start)
    return Run(run.label, run.t, run.drive, {"x": x, "v": v}, run.slope_deg)


def _rmse(model: Path, runs: list[Run], starts: list[tuple[float, float]], channel: str) -> float:
    replayed = replay_runs(
        load_robot(model), [_started(*pair) for pair in zip(runs, starts, strict=True)]
    )
    rest: NDArray[np.float64] = replayed[channel].to_numpy() - np.concatenate(
        [run.channels[channel] for run in runs]
    )
    return float(np.sqrt(np.nanmean(rest**2)))


def fresh_shrink(
    check: Path, nominal: Path, augmented: Path, channel: str, truth: dict[str, Any]
) -> float | None:
    """Replay fresh runs through both models; 1 - rmse after / rmse before.

    Both models start where the head really started. `None` where the channel is not
    one that a model can be replayed to.
    """
    runs, _ = load_runs(check)
    if channel not in REPLAYED or channel not in runs[0].channels:
        return None
    starts = [(float(x), float(v)) for x, v in truth["check_starts"]]
    before = _rmse(nominal, runs, starts, channel)
    return 1.0 - _rmse(augmented, runs, starts, channel) / before if before > 0.0 else None
