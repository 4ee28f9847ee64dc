"""How far a run is: chunks, statuses and writers, from manifest, logs and sizes of files."""

from __future__ import annotations

import dataclasses
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from locosweep.run_folder.run import Run

if TYPE_CHECKING:
    from pathlib import Path

    from locosweep.run_folder.log import Writer
    from locosweep.run_folder.plan import Plan


_LONGEST = 60
"""Characters of what a log says of its writer."""


@dataclass(frozen=True)
class Pace:
    """What one writer has done.

    Attributes
    ----------
    name : str
        Host, process id and time of its begin.
    chunks : int
        Chunks that it wrote.
    rate : float or None
        Cells per second from its begin to its last chunk, waiting included.
    last : str
        When it wrote last, UTC.
    dropped : int
        Lines of its log that were torn or altered.
    made_by : str
        Version of the package and SIMD level that it ran at, as its log says.
    """

    name: str
    chunks: int
    rate: float | None
    last: str
    dropped: int
    made_by: str


@dataclass(frozen=True)
class Overview:
    """How far a run is.

    Attributes
    ----------
    chunks, done, missing : int
        Chunks in all, finished, and not (damaged ones among these).
    damaged : dict of int to str
        Chunks that a log calls done, with what is wrong with which file.
    statuses : dict of str to dict of str to int
        Cells of each status in the finished chunks, by output.
    writers : tuple of Pace
        In order of their names.
    """

    chunks: int
    done: int
    missing: int
    damaged: dict[int, str]
    statuses: dict[str, dict[str, int]]
    writers: tuple[Pace, ...]

    def record(self) -> dict[str, Any]:
        """Return all of it for JSON."""
        return dataclasses.asdict(self)


def overview(folder: Path) -> Overview:
    """Tell how far a run is; DataFileError if it is none."""
    run = Run(folder)
    state, plan = run.state, run.manifest.plan
    statuses = {
        o.name: {status.name.lower(): n for status, n in run.status_counts(o.name).items()}
        for o in run.outputs
    }
    paces = tuple(_pace(writer, plan) for writer in state.writers)
    return Overview(
        plan.count, state.done_count, len(state.missing), state.damaged, statuses, paces
    )


def _pace(writer: Writer, plan: Plan) -> Pace:
    known = writer.done
    begin = writer.about.get("at", known[0].at if known else 0.0)
    last = max([begin, *(one.at for one in known)])
    # The log begins with its first chunk, whose computation came before.
    taken = last - begin + (known[0].seconds if known else 0.0)
    rate = plan.cells_in([one.chunk for one in known]) / taken if taken > 0 else None
    made_by = " on ".join(str(writer.about[k]) for k in ("locosweep", "simd") if k in writer.about)
    return Pace(writer.name, len(known), rate, _stamp(last), writer.dropped, made_by[:_LONGEST])


def _stamp(seconds: float) -> str:
    try:
        return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(seconds))
    except (ValueError, OverflowError, OSError):
        return "at no time"
