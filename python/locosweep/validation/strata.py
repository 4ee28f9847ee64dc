"""Strata of the blind check: cases of one kind alone, as many as a bound on errors needs.

Of the mixture 15 in 100 cases lie outside the list: too few to see an error of one in twenty.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from locosweep.errors import InputError
from locosweep.kept_work.processes import over_processes
from locosweep.kept_work.records import keep, kept
from locosweep.kept_work.staged import staged
from locosweep.validation.bad_readings import write_bad
from locosweep.validation.case_files import files_of, seal, write_case
from locosweep.validation.cases import Wanted, draw_wanted
from locosweep.validation.draw import drawing_code
from locosweep.validation.laws import KEPT_OUT, OUTSIDE

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path


@dataclass(frozen=True)
class Stratum:
    """Cases of one kind.

    Attributes
    ----------
    name : str
        As the command line takes it.
    number : int
        Part of the seed of its cases, which no other stratum nor the mixture draws. Faults of the
        readings are put into cases of the mixture (`bad_readings.draw_base`).
    about : str
        What its cases are.
    wanted : Wanted or None
        What is drawn; None for cases with bad readings.
    """

    name: str
    number: int
    about: str
    wanted: Wanted | None


STRATA = {
    stratum.name: stratum
    for stratum in (
        Stratum(
            "outside", 11, "a cause that no effect of the list stands for",
            Wanted("outside", families=(*OUTSIDE, *KEPT_OUT)),
        ),
        Stratum(
            "another-law", 12, "one effect by another functional form",
            Wanted("one", mismatch=True),
        ),
        Stratum("pairs", 13, "two effects", Wanted("two")),
        Stratum(
            "background", 14, "one effect over a weak disturbance", Wanted("background")
        ),
        Stratum("bad-readings", 15, "one fault of the readings", None),
    )
}  # fmt: skip


def chosen_families(stratum: Stratum, names: Sequence[str]) -> tuple[str, ...]:
    """Check the names of disturbances that are asked for; all of a stratum without any."""
    known = stratum.wanted.families if stratum.name == "outside" and stratum.wanted else ()
    for name in names:
        if name not in known:
            allowed = ", ".join(known) if known else "none: only with --only outside"
            raise InputError(f"--families: {name} is no disturbance; allowed are {allowed}")
    return tuple(names) or known


def draw_stratum(
    out: Path,
    stratum: Stratum,
    cases: int,
    seed: int,
    *,
    families: Sequence[str] = (),
    processes: int = 1,
    progress: Callable[[int, int], object] | None = None,
    shard: tuple[int, int] | None = None,
) -> list[str]:
    """Draw cases of a stratum into a folder and seal their truths; those there are kept.

    Parameters
    ----------
    out : Path
        Folder.
    stratum : Stratum
        Of `STRATA`.
    cases, seed : int
        Case `i` of a seed and of `families` is the same however many are drawn.
    families : sequence of str
        Disturbances of the stratum ``outside``; all if empty.
    processes : int
        Processes that draw.
    progress : callable, optional
        Called with the cases that are done, and all.
    shard : (int, int), optional
        Which cases come first, as in `over_processes`.

    Returns
    -------
    list of str
        The folders of the cases.
    """
    code = drawing_code()
    chosen = chosen_families(stratum, families)
    calls = [(stratum.name, seed, index, chosen, out, code) for index in range(cases)]
    names = over_processes(_draw, calls, processes, progress, shard)
    seal(out, names)
    return names


def _draw(name: str, seed: int, index: int, families: tuple[str, ...], out: Path, code: str) -> str:
    stratum = STRATA[name]
    folder = f"{name.replace('-', '_')}_{index:04d}"
    if stratum.wanted is None:
        folder = f"bad_{index:04d}"
    record = out / "sealed" / folder / "drawn.json"
    key = {"stratum": name, "seed": seed, "index": index, "families": [*families], "code": code}
    if kept(record, key) is not None:
        return folder
    with staged(out, folder, f"sealed/{folder}") as place:
        if stratum.wanted is None:
            write_bad(place, seed, index)
        else:
            wanted = replace(stratum.wanted, families=families)
            numbers = [seed, stratum.number, index]
            case = draw_wanted(np.random.default_rng(numbers), wanted, f"{name} {index} of {seed}")
            write_case(case, folder, place, numbers)
    keep(record, key, files_of(out, folder))
    return folder
