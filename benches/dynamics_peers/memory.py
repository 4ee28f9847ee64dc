"""Peak memory of ensembles that return one number per trajectory, each in its own process."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from common.peak import peak_bytes

LIMIT_MB = 64
# Trajectories and steps of each.
_FULL = ((1_000_000, 20), (20_000, 1_000), (2_000, 10_000))
_QUICK = ((20_000, 20), (200, 1_000))


@dataclass(frozen=True)
class Held:
    """What one ensemble took."""

    trajectories: int
    steps: int
    result_mb: float
    beside_mb: float


def measure(quick: bool) -> list[Held]:
    """Return the size of the results and the bytes needed at most beside them."""
    here = Path(__file__).parent.parent
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(here), *filter(None, sys.path)])}
    found = []
    for count, steps in _QUICK if quick else _FULL:
        command = [sys.executable, "-m", "dynamics_peers.memory", str(count), str(steps)]
        run = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        if run.returncode:
            raise SystemExit(f"{' '.join(command[1:])} failed:\n{run.stderr}")
        found.append(Held(count, steps, *json.loads(run.stdout)))
    return found


def _main(count: int, steps: int) -> None:
    import numpy as np

    import locosweep as ls

    across = 100
    grid = ls.Grid(
        mu_static=np.linspace(0.4, 0.8, across),
        drive_amplitude=np.linspace(1.0, 3.0, count // across),
        mu_coulomb=0.3,
        stribeck_speed=0.05,
        transition_speed=0.015,
        duration=1e-3 * steps,
        time_step=1e-3,
    )
    before = peak_bytes()
    how = {"law": "tanh", "drive": "sine", "method": "runge_kutta"}
    values = ls.sweep("final_position", grid, **how).values
    assert np.isfinite(values).all()
    extra = peak_bytes() - before - values.nbytes
    print(json.dumps([values.nbytes / 1e6, extra / 1e6]))


if __name__ == "__main__":
    _main(*(int(text) for text in sys.argv[1:]))
