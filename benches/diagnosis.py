"""How long a diagnosis takes: 6 runs of 2000 samples, by what is wrong with the rig.

    python benches/diagnosis.py [--rounds 3] [--threads 2] [--quick] [--profile] [--json FILE]

`singles` is the time until every single effect is fitted and ranked; `whole` adds pairs,
rivals, intervals and the written report with its pictures. The physical limit beside them
is that of the replays alone, at the speed of an exact one (`dynamics_peers.py --only replay`).
`--profile` adds how much of the whole the core's replays and fits take, in one round on one
thread.
"""

from __future__ import annotations

import argparse
import cProfile
import statistics
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import polars as pl

import locosweep as ls
from common.machine import describe
from common.record import json_option, write
from common.table import table
from locosweep.files.robot import Robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import replay_runs

NOISE = 2e-5
ROBOT = Robot(
    {"mass": 0.25, "gravity": 9.81, "mu_coulomb": 0.3, "segments": 4.0},
    {"sensor.position_noise": NOISE},
)
CASES: dict[str, dict[str, dict[str, float]]] = {
    "nothing": {},
    "viscous friction": {"viscous_friction": {"c": 0.15}},
    "drive lag": {"drive_lag": {"T": 0.02}},
    "Stribeck friction": {"stribeck_friction": {"F_s": 0.9, "v_s": 0.03, "delta": 1.5}},
    "bristles": {"presliding_compliance": {"sigma0": 3e3, "sigma1": 10.0}},
    "viscous friction and lag": {"viscous_friction": {"c": 0.15}, "drive_lag": {"T": 0.02}},
    "a push of 0.05 N every 0.3 s": {},
}
PUSHED = "a push of 0.05 N every 0.3 s"


def drives(samples: int) -> list[Run]:
    """Six runs of 10 s: sines and pulses of several sizes."""
    t = np.linspace(0.0, 10.0, samples)
    runs = []
    for k in range(6):
        wave = np.sin(2.0 * np.pi * (0.4 + 0.13 * k) * t)
        drive = (0.9 + 0.12 * k) * (wave if k % 2 else np.sign(wave) * (np.abs(wave) > 0.4))
        drive[t < 0.1] = 0.0
        runs.append(Run(str(k), t, drive, {"x": np.zeros(samples)}))
    return runs


def measured(name: str, runs: list[Run]) -> pl.DataFrame:
    """Return what a sensor would read."""
    real = runs
    if name == PUSHED:
        real = [replace(r, drive=r.drive + 0.05 * (r.t % 0.3 < 0.05)) for r in runs]
    frame = replay_runs(replace(ROBOT, effects=CASES[name]), real)
    noise = np.random.default_rng(1).normal(0.0, NOISE, frame.height)
    drive = pl.Series("drive", np.concatenate([run.drive for run in runs]))
    return frame.select("run", "t", pl.col("x") + pl.Series(noise)).with_columns(drive)


class Marks(dict[str, float]):
    """When each step of a diagnosis began."""

    def __call__(self, done: int, total: int, rate: float, /) -> None:
        """Take how far the steps are."""

    def say(self, text: str) -> None:
        """Take the name of a step that begins."""
        self.setdefault(text, time.perf_counter())


def timed(frame: pl.DataFrame, threads: int) -> tuple[float, float, str]:
    """Seconds for the singles and for all, and the verdict."""
    marks = Marks()
    begin = time.perf_counter()
    found = ls.diagnose(
        frame,
        ROBOT,
        threads=threads,
        progress=marks,
    )
    after = [at for text, at in marks.items() if at > marks["single effects"]]
    with tempfile.TemporaryDirectory() as out:
        found.save(Path(out) / "report")
    whole = time.perf_counter() - begin
    names = " + ".join("/".join(c) for c in found.report["verdict"]["equivalent"])
    said = f"{names} (partial)" if found.status == "partial" else names or found.status
    return min(after) - marks["single effects"], whole, said


def replayed(frame: pl.DataFrame) -> tuple[float, float, int]:
    """Seconds in the core's replays and fits, seconds of a whole diagnosis, and calls of these."""
    profiler = cProfile.Profile()
    begin = time.perf_counter()
    profiler.runcall(ls.diagnose, frame, ROBOT, threads=1)
    whole = time.perf_counter() - begin
    names = [f"of 'locosweep._core.{owner}'" for owner in ("Replay", "Experiment", "Misfit")]
    replays = [one for one in profiler.getstats() if any(n in str(one.code) for n in names)]
    return sum(one.totaltime for one in replays), whole, sum(one.callcount for one in replays)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--quick", action="store_true", help="short runs, one round")
    parser.add_argument("--profile", action="store_true", help="how much the replays take")
    json_option(parser)
    asked = parser.parse_args()
    runs = drives(200 if asked.quick else 2000)
    cases = list(CASES)[:3] if asked.quick else list(CASES)
    frames = {name: measured(name, runs) for name in cases}
    timed(frames[cases[0]], asked.threads)
    lines = [["what is wrong", "singles, s", "whole, s", "said"]]
    found = []
    for name in cases:
        rounds = 1 if asked.quick else asked.rounds
        took = [timed(frames[name], asked.threads) for _ in range(rounds)]
        singles, whole = (statistics.median(row[i] for row in took) for i in range(2))
        lines.append([name, f"{singles:.2f}", f"{whole:.2f}", took[0][2]])
        found.append({"case": name, "singles": singles, "whole": whole, "said": took[0][2]})
    print(table(lines))
    if asked.profile:
        rows = [["what is wrong", "in the core, s", "of, s", "calls"]]
        for name in cases:
            inside, whole, calls = replayed(frames[name])
            rows.append([name, f"{inside:.1f}", f"{whole:.1f}", str(calls)])
        print(table(rows))
    print(describe(["numpy", "polars"]), f"threads {asked.threads}")
    write(asked.json, {"threads": asked.threads, "rows": found})


if __name__ == "__main__":
    main()
