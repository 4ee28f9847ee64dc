"""Diagnose a folder of labelled cases and print verdicts beside truths, as a table.

    python benches/practice.py FOLDER [CASE ...] [--json FILE]

FOLDER holds `truth.json` and a folder per case with `runs.csv`, `nominal.toml` and
`check.csv`. Only the first two of these go into the diagnosis.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import locosweep as ls
from common.record import json_option, write
from locosweep.files.robot import load_robot
from locosweep.files.runs import load_runs
from locosweep.simulation.replay import replay_runs


def right(verdict: dict[str, Any], truth: dict[str, Any]) -> bool:
    """Whether a verdict is right, up to what the truth accepts as well."""
    if truth["status"] != "explained":
        return bool(verdict["status"] == truth["status"])
    classes = verdict["equivalent"]
    names = truth["effects"]
    if len(classes) == len(names) and all(any(n in c for c in classes) for n in names):
        return True
    return sorted(verdict["effects"]) in [sorted(a) for a in truth["accepted"]]


def rmse(model: Path, runs: Path, channel: str) -> float:
    """Error of a model on runs that the diagnosis has not seen."""
    records, _ = load_runs(runs)
    read = replay_runs(load_robot(model), records)[channel].to_numpy()
    kept = np.concatenate([run.channels[channel] for run in records])
    return float(np.sqrt(np.nanmean((kept - read) ** 2)))


def row(folder: Path, truth: dict[str, Any]) -> tuple[bool, list[str]]:
    """Diagnose one case; whether it is right, and its row of the table."""
    begin = time.process_time()
    found = ls.diagnose(folder / "runs.csv", folder / "nominal.toml", threads=1)
    seconds = time.process_time() - begin
    verdict, gap = found.report["verdict"], found.report["gap"]
    said = " + ".join(" / ".join(names) for names in verdict["equivalent"]) or verdict["status"]
    stated = fresh = "-"
    if found.effects and gap["shrink"] is not None:
        stated = f"{gap['shrink']:.3f}"
        with tempfile.TemporaryDirectory() as out:
            found.save(Path(out) / "report")
            after = rmse(Path(out) / "report" / "augmented.toml", folder / "check.csv",
                         gap["channel"])  # fmt: skip
        before = rmse(folder / "nominal.toml", folder / "check.csv", gap["channel"])
        fresh = f"{1.0 - after / before:.3f}"
    true = " + ".join(truth["effects"]) or truth["alien"] or "nothing"
    good = right(verdict, truth)
    cells = [folder.name[-3:], true, said + (" (other law)" if verdict["law_mismatch"] else ""),
             f"{verdict['probability']:.2f}", stated, fresh, f"{seconds:.1f}",
             "yes" if good else "**no**"]  # fmt: skip
    return good, cells


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("cases", nargs="*")
    json_option(parser)
    asked = parser.parse_args()
    truths = json.loads((asked.folder / "truth.json").read_text())["cases"]
    cases = asked.cases or sorted(truths)
    found = []
    count = 0
    for case in cases:
        good, cells = row(asked.folder / case, truths[case])
        count += good
        found.append(cells)
        print("  ".join(cells), flush=True)
    print(f"\n{count} of {len(cases)} right")
    write(asked.json, {"rows": found})


if __name__ == "__main__":
    main()
