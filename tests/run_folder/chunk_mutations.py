"""Alters chunk files of a run at random and tells what commands and reading make of it.

Runs as a program too, for counts that no test has time for:
``python tests/run_folder/chunk_mutations.py 10000``.
"""

from __future__ import annotations

import collections
import contextlib
import io
import random
import sys
import tempfile
from pathlib import Path

from run_cases import CLOSED, data_files

import locosweep as ls
from locosweep.cli import main

PAGE = 4096
LOT = 100
"""Alterations of one run."""
KINDS = ("flip", "truncate", "zero", "swap", "copy", "remove")


def alter(kind: str, path: Path, other: Path, chance: random.Random) -> None:
    """Alter a chunk file, by another one where the kind needs that."""
    content = bytearray(path.read_bytes())
    if kind == "flip":
        for _ in range(chance.randint(1, 4)):
            content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    elif kind == "truncate":
        del content[chance.randrange(len(content)) :]
    elif kind == "zero":
        start = chance.randrange(len(content))
        content[start : start + PAGE] = bytes(len(content[start : start + PAGE]))
    elif kind == "swap":
        theirs = other.read_bytes()
        other.write_bytes(content)
        content = bytearray(theirs)
    elif kind == "copy":
        content = bytearray(other.read_bytes())
    else:
        path.unlink()
        return
    path.write_bytes(content)


def command(*arguments: str) -> tuple[int, str, str]:
    """Run a command in this process; return its exit code and what it said."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = main(arguments)
    return code, out.getvalue(), err.getvalue()


def read_at(folder: Path) -> str:
    """Read all values; return the type of the error, empty if there was none."""
    try:
        ls.open_run(folder).to_result()
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return ""


def fault_of(folder: Path, wanted: dict[str, str]) -> str:
    """Say what went wrong with an altered folder, empty if nothing did; it is repaired."""
    there = data_files(folder)
    altered = {name for name, digest in wanted.items() if there.get(name) != digest}
    said = read_at(folder)
    if not said.startswith(("InputError: ", "DataFileError: ")) or "\n" in said:
        return f"read as {said!r}"
    code, out, err = command("verify", str(folder))
    named = {line.partition(": ")[0].removeprefix("data.zarr/") for line in out.splitlines()[:-1]}
    if (code, err) != (1, "") or named != altered:
        return f"verify: {code}, {out!r}, {err!r}"
    code, out, err = command("export", str(folder), "--out", str(folder.with_name("x.parquet")))
    if code != 2 or err.count("\n") != 1 or "Traceback" in err:
        return f"export: {code}, {out!r}, {err!r}"
    code, out, err = command("verify", str(folder), "--repair")
    if (code, err) != (0, "") or f"{len(altered)} repaired" not in out:
        return f"repair: {code}, {out!r}, {err!r}"
    return "" if data_files(folder) == wanted and not read_at(folder) else "not repaired"


def mutate(root: Path, count: int, seed: int) -> tuple[dict[str, int], list[str]]:
    """Alter a run so many times; return how often by kind, and all that went wrong."""
    chance = random.Random(seed)  # noqa: S311 - places, not secrets
    folder = root / "run"
    ls.sweep(**CLOSED, chunk=40, out=folder)
    wanted = data_files(folder)
    files = sorted((folder / "data.zarr").rglob("c.*.*.*"))
    (first,) = (folder / "log").iterdir()
    done: collections.Counter[str] = collections.Counter()
    wrong = []
    while sum(done.values()) < count:
        kind, path, other = chance.choice(KINDS), chance.choice(files), chance.choice(files)
        alter(kind, path, other, chance)
        if data_files(folder) == wanted:
            # Zeros where zeros were, or a file in place of its equal.
            continue
        done[kind] += 1
        if fault := fault_of(folder, wanted):
            wrong.append(f"{kind} {path.relative_to(folder)}: {fault}")
        # What repairs add would make each one slower than the last.
        for log in (folder / "log").iterdir():
            if log != first:
                log.unlink()
    return dict(done), wrong


def in_lots(count: int) -> None:
    """Alter runs, a hundred times each, and print how far it is."""
    done: collections.Counter[str] = collections.Counter()
    faults: list[str] = []
    for lot, first in enumerate(range(0, count, LOT), 1):
        with tempfile.TemporaryDirectory() as place:
            counts, wrong = mutate(Path(place), min(LOT, count - first), lot)
        done.update(counts)
        faults += wrong
        sys.stdout.write(f"{done.total()}: {dict(done)}, {len(faults)} wrong\n")
        sys.stdout.flush()
    sys.stdout.write("\n".join(faults[:20]))


if __name__ == "__main__":
    in_lots(int(sys.argv[1]))
