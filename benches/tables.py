"""Fill the tables of the documentation: from the registry, and from stored results of benches.

    python benches/tables.py                    write every table anew
    python benches/tables.py --check            name the files whose tables are not current
    python benches/tables.py --store NAME FILE  keep FILE as docs/results/NAME.json, then write

A table stands between `<!-- begin NAME -->` and `<!-- end NAME -->`. FILE is what a command wrote:
the `--json` of a bench, the `metrics.json` of a blind check, or the printed output of
`tests/test_precision.py`.
"""

from __future__ import annotations

import argparse
import datetime
import json
import re
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from common.machine import describe
from common.registry_pages import effects, parameters, quantities
from common.table import rows

ROOT = Path(__file__).parents[1]
_BLOCK = re.compile(r"<!-- begin (?P<name>\w+) -->\n.*?<!-- end (?P=name) -->\n", re.DOTALL)
_MARK = re.compile(r"<!-- (?:begin|end) \w+ -->")

# Kinds of cases that a blind check draws alone.
STRATA = ("outside", "another_law", "pairs", "background")
# How each result is made, for whoever makes it anew.
COMMANDS = {
    "accuracy": "python -m pytest tests/test_precision.py -s > accuracy.txt",
    "blind_check": "locosweep blind-check --cases 1000 --gap-free 500 --seed 17171 "
    "--experiments 144 --out DIR",
    **{
        f"blind_{kind}": f"locosweep blind-check --only {kind.replace('_', '-')} --cases 210 "
        "--seed S --out DIR"
        for kind in STRATA
    },
    "border": "python benches/border.py --json border.json",
    "diagnosis": "python benches/diagnosis.py --json diagnosis.json",
    **dict.fromkeys(
        ("dynamics", "dynamics_avx2"), "python benches/dynamics_peers.py --json dynamics.json"
    ),
    "heatmap": "python benches/heatmap.py --json heatmap.json",
    **dict.fromkeys(("peers", "peers_avx2"), "python benches/peers.py --json peers.json"),
    "practice": "python benches/practice.py FOLDER --json practice.json",
    "stored": "python benches/stored.py --json stored.json",
}
# Parts of a result that fill no table and are too long to keep.
_LONG = {"cases", "power", "calibration", "splits", "effects"}

Lines = list[list[str]]


def time_of(seconds: float) -> str:
    """Write a time in the unit that suits it."""
    for unit, factor in (("us", 1e6), ("ms", 1e3)):
        if seconds * factor < 1e3:
            return f"{seconds * factor:.3g} {unit}"
    return f"{seconds:.3g} s"


def accuracy(result: dict[str, Any]) -> Lines:
    """Return the worst errors against references of 50 digits."""
    head = ["quantity", "values", "relative error", "condition below 10", "conditioned"]
    return [head, *([f"`{r[0]}`", r[4], r[1], r[2], r[3]] for r in result["rows"])]


def blind_check(result: dict[str, Any]) -> Lines:
    """Return every figure of a blind check beside its target."""
    lines = [["figure", "value", "95 % interval", "cases", "target", "met"]]
    for f in result["figures"]:
        found = (f[key] for key in ("value", "low", "high"))
        value, low, high = ("-" if number is None else f"{number:.3f}" for number in found)
        met = {True: "yes", False: "**no**", None: "-"}[f["met"]]
        interval = f"{low} to {high}" if f["count"] else "-"
        lines.append([f["name"], value, interval, str(f["count"]), f["target"] or "-", met])
    return lines


def border(result: dict[str, Any]) -> Lines:
    """Return the times between a user and the kernels."""
    lines = [["what", "median", "fastest", "target"]]
    for line in result["lines"]:
        fastest, target = (line[key] and time_of(line[key]) for key in ("fastest", "target"))
        target = f"at most {target}" if target else "-"
        lines.append([line["what"], time_of(line["median"]), fastest or "-", target])
    return lines


def diagnosis(result: dict[str, Any]) -> Lines:
    """Return the times of whole diagnoses."""
    lines = [["what is wrong with the rig", "single effects fitted", "whole", "verdict"]]
    for row in result["rows"]:
        times = [time_of(row[key]) for key in ("singles", "whole")]
        lines.append([row["case"], *times, row["said"]])
    return lines


def dynamics(result: dict[str, Any]) -> Lines:
    """Return our simulations beside those of other libraries."""
    keys = ("work", "ours", "peer", "theirs", "ratio", "wanted", "limit", "met")
    head = ["work", "locosweep", "beside", "takes", "ratio", "target", "arithmetic limit", "met"]
    found = [[row[key].replace("NO", "**no**") for key in keys] for row in result["targets"]]
    return [head, *found]


def heatmap(result: dict[str, Any]) -> Lines:
    """Return what heat maps of ten million trajectories take."""
    head = ["heat map", "takes", "progress shown", "memory beside the result"]
    lines = [[*head, "stops", "median time to stop", "worst"]]
    for row in result["rows"]:
        stops = ("-" if row[k] is None else time_of(row[k]) for k in ("median_stop", "worst_stop"))
        shown = [time_of(row["seconds"]), f"{row['shown']} times", f"{row['beside_mb']:.0f} MB"]
        lines.append([row["work"], *shown, str(row["stops"]), *stops])
    return lines


def peers(result: dict[str, Any]) -> Lines:
    """Return nanoseconds per point, on one and two threads: ours, the limit, other libraries."""
    columns = {
        "locosweep": "ours",
        "limit: plain fill": "fill",
        "numba": "numba",
        "numba, formula rearranged by hand": "numba.folded numba.monotone",
        "JAX": "jax",
        "NumPy, whole arrays": "numpy",
        "NumPy, blocks in place": "numpy.blocked",
    }
    lines = [["work", *(f"{title}, ns per point" for title in columns)]]
    for work, ways in result["groups"].items():
        times = {(way["key"], way["threads"]): way["ns_per_point"] for way in ways}
        cells = []
        for keys in columns.values():
            of = [(key, n) for key in keys.split() for n in (1, 2)]
            known = [f"{times[one]:.3g}" for one in of if one in times]
            cells.append(" / ".join(known) or "-")
        lines.append([work, *cells])
    held = result["memory"]
    beside = f"peak memory beside a fresh result of {held['result_mb']:.0f} MB"
    return [*lines, [beside, f"{held['beside_mb']:.0f} MB", *["-"] * (len(columns) - 1)]]


def practice(result: dict[str, Any]) -> Lines:
    """Return verdicts beside truths."""
    heads = ["case", "true", "said", "probability", "claimed", "on other runs", "s", "right"]
    return [heads, *result["rows"]]


def stored(result: dict[str, Any]) -> Lines:
    """Return what run folders and virtual grids take."""
    keys = ["work", "found", "target", "met"]
    return [keys, *([row[key].replace("NO", "**no**") for key in keys] for row in result["rows"])]


RESULTS: dict[str, Callable[[dict[str, Any]], Lines]] = {
    "accuracy": accuracy,
    "blind_check": blind_check,
    **dict.fromkeys((f"blind_{kind}" for kind in STRATA), blind_check),
    "border": border,
    "diagnosis": diagnosis,
    **dict.fromkeys(("dynamics", "dynamics_avx2"), dynamics),
    "heatmap": heatmap,
    **dict.fromkeys(("peers", "peers_avx2"), peers),
    "practice": practice,
    "stored": stored,
}
REGISTRY: dict[str, Callable[[], str]] = {
    "effects": effects,
    "parameters": parameters,
    "quantities": quantities,
}


def text_of(name: str, results: Path) -> str:
    """Return what belongs between the markers of a table."""
    if name in REGISTRY:
        return f"\n{REGISTRY[name]()}\n"
    if name not in RESULTS:
        raise SystemExit(f"no table {name!r}; there are {', '.join([*REGISTRY, *RESULTS])}")
    file = results / f"{name}.json"
    if not file.exists():
        return f"\nNot measured yet: `{COMMANDS[name]}`.\n\n"
    result = json.loads(file.read_text(encoding="utf-8"))
    of = result["of"]
    note = f" {of['note']}" if of.get("note") else ""
    said = f"Commit {of['commit']}, {of['date']}, {of['machine']}: `{of['command']}`.{note}"
    return f"\n{rows(RESULTS[name](result))}\n{said}\n\n"


def filled(text: str, results: Path) -> str:
    """Return a page with all its tables current."""

    def block(match: re.Match[str]) -> str:
        name = match["name"]
        return f"<!-- begin {name} -->\n{text_of(name, results)}<!-- end {name} -->\n"

    marks = len(_MARK.findall(text))
    if 2 * len(_BLOCK.findall(text)) != marks:
        raise SystemExit("a marker has no partner: tables stand between begin NAME and end NAME")
    return _BLOCK.sub(block, text)


def precision_rows(text: str) -> list[list[str]]:
    """Read the table that tests/test_precision.py prints."""
    size = r"\d\.\de[+-]\d\d"
    found = re.findall(rf"^(\w+) +({size}) +({size}) +({size}) +(\d+) values$", text, re.MULTILINE)
    extra = r"^\.*(\w+): worst error (\d\.\de[+-]\d\d)"
    for name, worst in re.findall(extra, text, re.MULTILINE):
        found.append((name, "-", "-", worst, "-"))
    return [list(row) for row in found]


def without_paths(command: str) -> str:
    """Return a command that says nothing of the folders of a machine."""
    words = re.sub(r" --json[ =]\S+", "", command).split(" ")
    ours = ("benches/", "tests/")
    return " ".join("DIR" if "/" in w and not w.startswith(ours) else w for w in words)


def store(name: str, file: Path, docs: Path) -> None:
    """Keep a result with what it holds for."""
    if name not in RESULTS:
        raise SystemExit(f"no result {name!r}; there are {', '.join(RESULTS)}")
    text = file.read_text(encoding="utf-8")
    given = {"rows": precision_rows(text)} if name == "accuracy" else json.loads(text)
    machine = given.pop("machine", None) or describe([])
    commit = subprocess.run(
        ["git", "describe", "--always", "--dirty", "--exclude=*"],  # noqa: S607
        cwd=ROOT, capture_output=True, text=True, check=True,
    )  # fmt: skip
    of = {
        "command": without_paths(given.pop("command", COMMANDS[name])),
        "commit": commit.stdout.strip(),
        "date": datetime.datetime.now(tz=datetime.UTC).date().isoformat(),
        "machine": ", ".join(f"{key} {value}" for key, value in machine.items()),
    }
    kept = {key: value for key, value in given.items() if key not in _LONG}
    target = docs / "results" / f"{name}.json"
    target.parent.mkdir(exist_ok=True)
    target.write_text(json.dumps({"of": of, **kept}, indent=1) + "\n", encoding="utf-8")


def main(words: Sequence[str] | None = None) -> None:
    """Write or check all tables."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing, fail if not current")
    parser.add_argument("--store", nargs=2, metavar=("NAME", "FILE"), help="keep a result first")
    parser.add_argument("--docs", type=Path, default=ROOT / "docs", help="folder of the pages")
    given = parser.parse_args(words)
    if given.store:
        store(given.store[0], Path(given.store[1]), given.docs)
    old = []
    for page in sorted(given.docs.glob("*.md")):
        text = page.read_text(encoding="utf-8")
        new = filled(text, given.docs / "results")
        if new != text:
            old.append(page.name)
            if not given.check:
                page.write_text(new, encoding="utf-8", newline="\n")
    if given.check and old:
        sys.exit(f"tables not current in {', '.join(old)}: run python benches/tables.py")
    print("written: " + ", ".join(old) if old else "all tables are current")


if __name__ == "__main__":
    main()
