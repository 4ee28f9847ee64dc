"""Ten million trajectories from the command line: time, progress, memory, and how fast it stops.

``--quick`` takes a thousandth of the trajectories and a few stops.
"""

from __future__ import annotations

import argparse
import os
import pty
import random
import re
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import locosweep as ls
from common.machine import describe
from common.record import json_option, write
from common.table import table

# What the console script does, which is not installed beside a source tree.
_COMMAND = "import sys; sys.argv[0] = 'locosweep'; from locosweep.cli import main; sys.exit(main())"
_FULL, _QUICK = (3162, 3163), (100, 100)
_STOPS, _QUICK_STOPS = 20, 2
# Stops of the quick run need something that lasts.
_QUICK_STOPPED = (800, 800)
# In steps of 1/100 s, so that a trajectory has a hundred of them.
_WORKS = {
    "coulomb_viscous, exact": "--law coulomb_viscous --drive pulse --set drive_period=0.5",
    "stribeck, runge_kutta": "--law stribeck --drive sine --set time_step=0.01",
}
_AXES = "--x drive_amplitude=1:3:{} --y mu_coulomb=0.1:0.5:{}"
_SET = "--set mu_static=0.6 --set viscous=0.2 --set duration=1"
LIMIT_MB, LIMIT_SECONDS = 64, 0.25
_INTERRUPTED = 130
_ENDED = (0, _INTERRUPTED, -signal.SIGINT)
"""Exit codes where the map was there as a whole: an interpreter that ends no longer catches."""
# The last chunk of every PNG file: no bytes, its name, its checksum.
_PNG_END = b"\0\0\0\0IEND\xaeB`\x82"


@dataclass(frozen=True)
class Whole:
    """One heat map from start to end."""

    seconds: float
    peak: int
    """Bytes."""
    shown: int
    """How often progress was shown."""


@dataclass(frozen=True)
class Stop:
    """One heat map that was interrupted."""

    after: float
    latency: float
    code: int
    left: list[str]
    """Files in its folder."""


def arguments(work: str, shape: tuple[int, int]) -> list[str]:
    """Return the command line of one heat map."""
    words = f"heatmap final_position {_AXES.format(*shape)} {_SET} {_WORKS[work]} --out map.png"
    return [sys.executable, "-c", _COMMAND, *words.split()]


def environment() -> dict[str, str]:
    """Let the command find the package that this script found."""
    package = Path(ls.__file__).parent.parent
    paths = [str(package), *filter(None, [os.environ.get("PYTHONPATH")])]
    return os.environ | {"PYTHONPATH": os.pathsep.join(paths)}


def whole(work: str, shape: tuple[int, int]) -> Whole:
    """Draw one heat map on a terminal of our own."""
    with tempfile.TemporaryDirectory() as folder:
        main, other = pty.openpty()
        start = time.perf_counter()
        process = subprocess.Popen(
            arguments(work, shape),
            cwd=folder,
            env=environment(),
            stdout=subprocess.DEVNULL,
            stderr=other,
        )
        os.close(other)
        text = _drain(main)
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        seconds = time.perf_counter() - start
        os.close(main)
        if process.returncode or not Path(folder, "map.png").exists():
            raise SystemExit(f"{work}: exit code {process.returncode}\n{text}")
    unit = 1 if sys.platform == "darwin" else 1024
    return Whole(seconds, used.ru_maxrss * unit, len(re.findall(r"\d+%", text)))


def _drain(terminal: int) -> str:
    """Read what a terminal shows until its other end is closed."""
    parts = []
    while True:
        try:
            part = os.read(terminal, 4096)
        # How Linux tells that nobody writes any more.
        except OSError:
            part = b""
        if not part:
            return b"".join(parts).decode()
        parts.append(part)


def stopped(work: str, shape: tuple[int, int], after: float) -> Stop | None:
    """Interrupt one heat map; None if it had ended before."""
    with tempfile.TemporaryDirectory() as folder:
        process = subprocess.Popen(
            arguments(work, shape),
            cwd=folder,
            env=environment(),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
        )
        time.sleep(after)
        if process.poll() is not None:
            return None
        start = time.perf_counter()
        process.send_signal(signal.SIGINT)
        process.communicate()
        latency = time.perf_counter() - start
        left = sorted(path.name for path in Path(folder).iterdir())
        # The map was there as a whole, and only the interpreter was still ending.
        ended = left == ["map.png"] and _is_whole(Path(folder, "map.png"))
    if ended and process.returncode in _ENDED and latency <= LIMIT_SECONDS:
        return None
    return Stop(after, latency, process.returncode, left)


def _is_whole(picture: Path) -> bool:
    """Tell whether a PNG file has its end: a half-written one is a fault, a whole one is not."""
    return picture.read_bytes().endswith(_PNG_END)


def stops(work: str, shape: tuple[int, int], count: int, lasts: float) -> list[Stop]:
    """Interrupt heat maps at random times, from when the command can be interrupted."""
    # The same times in every run of this script.
    chance = random.Random(20261121)  # noqa: S311
    found: list[Stop] = []
    tries = 0
    while len(found) < count and tries < 3 * count:
        tries += 1
        if stop := stopped(work, shape, chance.uniform(min(0.6, 0.3 * lasts), 0.9 * lasts)):
            found.append(stop)
    return found


def faults(work: str, found: list[Stop]) -> list[str]:
    """Say which stops were not as promised, latency aside."""
    return [
        f"{work}: interrupted after {stop.after:.2f} s: exit code {stop.code}, left {stop.left}"
        for stop in found
        if stop.code != _INTERRUPTED or stop.left
    ]


def main() -> None:
    """Parse the command line, measure, print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--quick", action="store_true", help="few trajectories, few stops")
    parser.add_argument("--stops", type=int, help=f"stops of each work (default {_STOPS})")
    parser.add_argument("--only", choices=["exact", "runge_kutta"], help="one work")
    json_option(parser)
    given = parser.parse_args()
    # Where a shell has this script ignore Ctrl-C, in the background, so would what it starts.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    shape, count = (_QUICK, _QUICK_STOPS) if given.quick else (_FULL, _STOPS)
    count = given.stops or count
    works = [work for work in _WORKS if given.only is None or work.endswith(given.only)]
    result = 8 * shape[0] * shape[1]
    lines = [["1 heat map of", "takes", "shown", "beside result", "stops", "median", "worst"]]
    wrong: list[str] = []
    rows = []
    for work in works:
        # What a picture takes anyway: interpreter, libraries, a few cells.
        base = whole(work, (3, 3)).peak
        drawn = whole(work, shape)
        lasting = _QUICK_STOPPED if given.quick else shape
        lasts = whole(work, lasting).seconds if given.quick else drawn.seconds
        found = stops(work, lasting, count, lasts)
        if len(found) < count:
            raise SystemExit(f"{work}: only {len(found)} of {count} stops came before the end")
        latencies = [stop.latency for stop in found]
        beside = (drawn.peak - base - result) / 1e6
        wrong += faults(work, found)
        if beside > LIMIT_MB:
            wrong.append(f"{work}: {beside:.0f} MB beside the result, allowed are {LIMIT_MB}")
        if not given.quick and max(latencies) > LIMIT_SECONDS:
            wrong.append(f"{work}: worst stop {1e3 * max(latencies):.0f} ms, allowed are 250")
        if not drawn.shown:
            wrong.append(f"{work}: no progress was shown")
        rows.append(
            {
                "work": work,
                "trajectories": shape[0] * shape[1],
                "seconds": drawn.seconds,
                "shown": drawn.shown,
                "beside_mb": beside,
                "stops": len(found),
                "median_stop": statistics.median(latencies),
                "worst_stop": max(latencies),
            }
        )
        lines.append(
            [
                f"{shape[0] * shape[1]:,}, {work}",
                f"{drawn.seconds:.2f} s",
                f"{drawn.shown} times",
                f"{beside:.0f} MB",
                str(len(found)),
                f"{1e3 * statistics.median(latencies):.0f} ms",
                f"{1e3 * max(latencies):.0f} ms",
            ]
        )
    print(", ".join(f"{name} {value}" for name, value in describe(["locosweep"]).items()))
    print(table(lines))
    write(given.json, {"rows": rows})
    if wrong:
        raise SystemExit("NOT MET: " + "\n".join(wrong))
    print(f"every stop: exit code {_INTERRUPTED}, no file left")


if __name__ == "__main__":
    main()
