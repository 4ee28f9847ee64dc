"""A run of any size takes the memory of a few chunks."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import locosweep as ls

CODE = """
import json, sys
from locosweep.cli import main
code = main(sys.argv[1:])
# Not ru_maxrss, which a process inherits from the one that started it.
peak = next(line for line in open("/proc/self/status") if line.startswith("VmHWM"))
print(json.dumps({"code": code, "peak": int(peak.split()[1]) * 1024}))
"""
GIB = 1 << 30
MOST = 512 * 10**6
"""What a sweep into a folder may take, whatever its size."""
# 40 million cells: 360 MB in six chunks, more than are held at a time.
LARGE = [
    "mean_velocity", "--axis", "mu_static=0.4:0.8:1000", "--axis", "slope_deg=0:5:1000", "--axis",
    "mass=0.1:1:40", "--set", "mu_coulomb=0.3", "--set", "segments=4",
]  # fmt: skip


def limited(arguments: list[str], space: int, place: Path) -> tuple[dict[str, Any], str]:
    """Run a command that may map so many bytes."""
    done = subprocess.run(
        ["prlimit", f"--as={space}", sys.executable, "-c", CODE, *arguments],
        cwd=place, capture_output=True, text=True, check=False, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    answer: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return answer, done.stderr


@pytest.mark.slow
def test_a_large_run_stays_within_its_limit(tmp_path: Path) -> None:
    answer, err = limited(["sweep", *LARGE, "--out", "run/"], GIB, tmp_path)
    assert answer["code"] == 0, err
    assert answer["peak"] < MOST
    run = ls.open_run(tmp_path / "run")
    assert run.complete
    assert run.manifest.plan.count >= 6


@pytest.mark.slow
def test_too_little_memory_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    answer, err = limited(["sweep", *LARGE, "--out", "run/"], 650 << 20, tmp_path)
    assert answer["code"] == 2
    assert re.fullmatch(
        r"locosweep: chunks of the run needs 2\d\d.\d MB, the limit is [\d.]+ [kM]B: give fewer "
        r"cells a chunk \(--chunk, chunk=\)\n", err
    )  # fmt: skip
    assert err.count("\n") == 1
    assert not (tmp_path / "run").exists()


@pytest.mark.slow
def test_an_export_stays_within_its_limit(tmp_path: Path) -> None:
    answer, err = limited(["sweep", *LARGE, "--out", "run/"], GIB, tmp_path)
    assert answer["code"] == 0, err
    answer, err = limited(["export", "run", "--out", "parts"], 2 * GIB, tmp_path)
    assert answer["code"] == 0, err
    assert answer["peak"] < 2 * MOST
    assert len(list((tmp_path / "parts").iterdir())) >= 40
