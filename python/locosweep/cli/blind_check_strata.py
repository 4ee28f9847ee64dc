"""``locosweep blind-check --only``: cases of one kind."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from locosweep.cli.options import meter, show

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path


@dataclass(frozen=True)
class StratumCheck:
    """What is asked of a check of one stratum."""

    only: str | None
    families: Sequence[str]
    cases: int
    gap_free: int
    experiments: int
    seed: int
    out: Path
    draw_only: bool
    force: bool
    quiet: bool
    threads: int | None
    json_: bool


def check_stratum(asked: StratumCheck, command: str) -> None:
    """Draw cases of a stratum, diagnose them, and say how often that was right."""
    from locosweep import _core
    from locosweep.errors import InputError
    from locosweep.files.atomic import write_text
    from locosweep.files.folder import check_folder
    from locosweep.files.strict_json import as_json
    from locosweep.validation.case_files import SEAL, digest
    from locosweep.validation.check import diagnose_cases, judge_bad_readings, judge_cases
    from locosweep.validation.strata import STRATA, chosen_families, draw_stratum
    from locosweep.validation.strata_metrics import bad_figures, stratum_figures
    from locosweep.validation.strata_tables import bad_text, stratum_json, stratum_text

    if asked.only not in STRATA:
        given = "missing" if asked.only is None else asked.only
        raise InputError(f"--only is {given}: allowed are {', '.join(STRATA)}")
    for option, count in (("--gap-free", asked.gap_free), ("--experiments", asked.experiments)):
        if count:
            raise InputError(f"{option}: allowed not beside --only")
    if asked.cases == 0:
        raise InputError("--cases is 0: allowed is at least one case")
    stratum = STRATA[asked.only]
    chosen_families(stratum, asked.families)
    check_folder(asked.out, force=asked.force)
    asked.out.mkdir(parents=True, exist_ok=True)
    processes = _core.threads_to_use(asked.threads)
    names = draw_stratum(
        asked.out, stratum, asked.cases, asked.seed, families=asked.families,
        processes=processes, progress=meter("drawing", "cases", quiet=asked.quiet),
    )  # fmt: skip
    sealed = digest(asked.out / SEAL)
    if not asked.quiet:
        click.echo(f"truths sealed: {asked.out / SEAL}, sha256 {sealed}", err=True)
    if asked.draw_only:
        show(asked.json_, {"cases": len(names), "sealed": sealed}, asked.out)
        return
    outcomes = diagnose_cases(
        asked.out, names, seed=asked.seed, processes=processes,
        progress=meter("diagnosing", "cases", quiet=asked.quiet),
    )  # fmt: skip
    about = {
        "command": command,
        "locosweep": _core.version(),
        "seed": asked.seed,
        "sealed_sha256": sealed,
    }
    if stratum.wanted is None:
        spoilt = judge_bad_readings(asked.out, outcomes)
        found, text = stratum_json(asked.only, spoilt, bad_figures(spoilt), about), bad_text(spoilt)
    else:
        judged = judge_cases(asked.out, outcomes)
        figures = stratum_figures(asked.only, judged)
        found, text = (
            stratum_json(asked.only, judged, figures, about), stratum_text(asked.only, judged)
        )  # fmt: skip
    write_text(asked.out / "metrics.json", as_json(found) + "\n")
    write_text(asked.out / "table.txt", text)
    show(asked.json_, found, text)
