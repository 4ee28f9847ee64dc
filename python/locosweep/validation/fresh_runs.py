"""Error reduction on fresh runs of the same reality, which no diagnosis has seen."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.files.channels import REPLAYED
from locosweep.files.robot import load_robot
from locosweep.files.runs import load_runs
from locosweep.simulation.replay import replay_runs

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from locosweep.files.runs import Run


def _rmse(model: Path, runs: list[Run], starts: list[tuple[float, float]], channel: str) -> float:
    started = [
        replace(run, channels={"x": np.full(run.t.size, x), "v": np.full(run.t.size, v)})
        for run, (x, v) in zip(runs, starts, strict=True)
    ]
    replayed = replay_runs(load_robot(model), started)
    rest: NDArray[np.float64] = replayed[channel].to_numpy() - np.concatenate(
        [run.channels[channel] for run in runs]
    )
    return float(np.sqrt(np.nanmean(rest**2)))


def fresh_reduction(
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
