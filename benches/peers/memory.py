"""Peak memory of a fresh W1, measured in a process of its own."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
from pathlib import Path
from typing import Any

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


def _peak() -> int:
    # Not ru_maxrss where this is known: a child begins with that of its parent.
    try:
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    except OSError:
        pass
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit


def _main(scale: float) -> None:
    import locosweep as ls
    from peers.work import dense_axes

    axes: Any = vars(dense_axes(scale))
    grid = ls.Grid(**axes)
    before = _peak()
    values = ls.sweep("mean_velocity", grid).values
    extra = _peak() - before - values.nbytes
    print(json.dumps({"result_mb": values.nbytes / 1e6, "beside_mb": extra / 1e6}))


if __name__ == "__main__":
    _main(float(sys.argv[1]))
