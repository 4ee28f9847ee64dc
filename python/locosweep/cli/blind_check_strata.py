"""``locosweep blind-check --only``: cases of one kind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from locosweep.cli.blind_check_asked import Asked


@dataclass(frozen=True)
class StratumCheck:
    """What is asked of a check of one stratum."""

    only: str | None
    families: Sequence[str]
    cases: int
    gap_free: int
    experiments: int


def check_stratum(asked: Asked, wanted: StratumCheck) -> None:
    """Draw cases of a stratum, diagnose them, and say how often that was right."""
    from locosweep.errors import InputError
    from locosweep.validation.check import judge_bad_readings, judge_cases
    from locosweep.validation.strata import STRATA, chosen_families, draw_stratum
    from locosweep.validation.strata_metrics import bad_figures, stratum_figures
    from locosweep.validation.strata_tables import bad_text, stratum_json, stratum_text

    name = wanted.only
    if name not in STRATA:
        given = "missing" if name is None else name
        raise InputError(f"--only is {given}: allowed are {', '.join(STRATA)}")
    for option, count in (("--gap-free", wanted.gap_free), ("--experiments", wanted.experiments)):
        if count:
            raise InputError(f"{option}: allowed not beside --only")
    if wanted.cases == 0:
        raise InputError("--cases is 0: allowed is at least one case")
    chosen_families(STRATA[name], wanted.families)
    asked.make_folder(only=name, families=sorted(wanted.families))
    names = draw_stratum(
        asked.out, STRATA[name], wanted.cases, asked.seed, families=wanted.families,
        processes=asked.processes, progress=asked.meter("drawing"),
        shard=asked.shard,
    )  # fmt: skip
    outcomes = asked.diagnosed(names)
    if outcomes is None:
        return
    if STRATA[name].wanted is None:
        spoilt = judge_bad_readings(asked.out, outcomes)
        found = stratum_json(name, spoilt, bad_figures(spoilt), asked.about)
        asked.write(found, bad_text(spoilt))
        return
    judged = judge_cases(asked.out, outcomes)
    found = stratum_json(name, judged, stratum_figures(name, judged), asked.about)
    asked.write(found, stratum_text(name, judged))
