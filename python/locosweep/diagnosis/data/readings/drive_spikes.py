"""Spikes in the drive column: commands that are far beyond all others for a sample or a few."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.readings.finding import Finding, stretches_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from locosweep.files.runs import Run

_TYPICAL = 0.98
"""Quantile of the commands that are not 0 that stands for the largest usual one."""
_TOO_LARGE = 20.0
"""Size over the usual one from which a command is none: no drive has such a reserve."""
_LONGEST = 3
"""Samples in a row that count as a spike; more are commands."""


def check_drives(runs: Sequence[Run]) -> tuple[list[Run], list[Finding]]:
    """Replace spikes of the drive by the command before; return the runs and what was found."""
    sizes = np.abs(np.concatenate([run.drive for run in runs])) if runs else np.zeros(0)
    pushes = sizes[sizes > 0.0]
    if pushes.size == 0:
        return list(runs), []
    most = _TOO_LARGE * float(np.quantile(pushes, _TYPICAL))
    kept, findings = [], []
    for run in runs:
        drive = run.drive.copy()
        for first, last in stretches_of(np.abs(run.drive) > most):
            if last - first >= _LONGEST:
                continue
            drive[first : last + 1] = drive[first - 1] if first else 0.0
            times = float(run.t[first]), float(run.t[last])
            findings.append(
                Finding(run.label, *times, "drive", "spike", last - first + 1, masked=True,
                        note="taken as the command before" if first else "taken as 0")
            )  # fmt: skip
        kept.append(run if np.array_equal(drive, run.drive) else replace(run, drive=drive))
    return kept, findings
