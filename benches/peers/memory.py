"""Peak memory of a fresh W1, measured in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

from common.peak import peak_bytes

LIMIT_MB = 64


def measure(scale: float) -> dict[str, float]:
    """Return the bytes of the result and those needed at most beside it."""
    here = Path(__file__).parent.parent
    paths = [str(here), *filter(None, sys.path)]
    command = [sys.executable, "-m", "peers.memory", str(scale)]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(paths)}
    run = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    found: dict[str, float] = json.loads(run.stdout)
    return found


def _main(scale: float) -> None:
    import locosweep as ls
    from peers.work import dense_axes

    axes: Any = vars(dense_axes(scale))
    grid = ls.Grid(**axes)
    before = peak_bytes()
    values = ls.sweep("mean_velocity", grid).values
    extra = peak_bytes() - before - values.nbytes
    print(json.dumps({"result_mb": values.nbytes / 1e6, "beside_mb": extra / 1e6}))


if __name__ == "__main__":
    _main(float(sys.argv[1]))
