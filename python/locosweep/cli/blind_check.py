"""``locosweep blind-check``: how the diagnosis fares on cases whose cause is withheld."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from locosweep.cli import options
from locosweep.cli.blind_check_asked import Asked
from locosweep.cli.blind_check_rig import RigCheck, check_rig, refuse_mixture, rig_options
from locosweep.cli.blind_check_strata import StratumCheck, check_stratum
from locosweep.cli.options import called
from locosweep.cli.run_options import SHARD, without_shard

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from locosweep.validation.judge import Judged


@click.command(name="blind-check")
@options.count_option(
    "--cases", 200, "Cases of the mixture: none, one or two effects, causes outside the list."
)
@options.count_option(
    "--gap-free", 0, "Further cases without a gap, with exactly the nominal values."
)
@click.option(
    "--only", metavar="STRATUM",
    help="Cases of one kind: outside, another-law, pairs, background or bad-readings.",
)  # fmt: skip
@click.option(
    "--families", metavar="NAME,...", default="",
    help="Disturbances of --only outside; default: all.",
)  # fmt: skip
@rig_options
@options.count_option("--seed", 0, "Case i of a seed is the same however many are drawn.")
@options.out_option("Folder for cases, truths, diagnoses and figures")
@options.count_option(
    "--experiments", 0,
    "Ambiguous verdicts whose proposed next run is carried out (half a minute each).",
)  # fmt: skip
@click.option("--draw-only", is_flag=True, help="Draw and seal the cases, diagnose nothing.")
@click.option(
    "--shard", type=SHARD,
    help="Take every N-th case first, from the I-th on, then what others have not done.",
)  # fmt: skip
@click.option(
    "--force", is_flag=True,
    help="Begin in a folder that is not empty. The same check goes on without it: what is there "
    "of the same code is kept.",
)  # fmt: skip
@click.option("--quiet", is_flag=True, help="Show no progress.")
@options.threads_option
@options.progress_option
@options.json_option
@click.pass_context
def blind_check(
    ctx: click.Context,
    cases: int,
    gap_free: int,
    only: str | None,
    families: str,
    rig: Path | None,
    nominal: Path | None,
    calibrate: bool,
    labels: str,
    sizes: str,
    seed: int,
    out: Path,
    experiments: int,
    draw_only: bool,
    shard: tuple[int, int] | None,
    force: bool,
    quiet: bool,
    threads: int | None,
    json_: bool,
) -> None:
    """Diagnose cases whose cause is withheld, and say how often that was right.

    A simulator of its own draws rigs, drives, noise and what is wrong; the truths are
    hashed before the first diagnosis and opened after the last.

    With --rig, cases are made from a measured rig and its calibrated model: each effect
    is planted into the log, so strongly that the model errs --sizes times as much.

    With --only, all cases are of one kind, as many as a bound on its errors needs.
    """
    from locosweep.errors import InputError
    from locosweep.validation.check import carry_out, judge_cases
    from locosweep.validation.draw import draw_cases
    from locosweep.validation.tables import as_json, as_text, wrong_cases

    refuse_mixture(ctx)
    command = without_shard(called(ctx))
    asked = Asked(seed, out, draw_only, force, quiet, threads, json_, command, shard)
    if rig is not None:
        check_rig(asked, RigCheck(rig, nominal, calibrate, labels, sizes))
        return
    if only is not None or families:
        chosen = [name.strip() for name in families.split(",") if name.strip()]
        check_stratum(asked, StratumCheck(only, chosen, cases, gap_free, experiments))
        return
    if cases + gap_free == 0:
        raise InputError("--cases and --gap-free are both 0: allowed is at least one case")
    asked.make_folder(only=None)
    names = draw_cases(
        out, cases, seed, gap_free=gap_free, processes=asked.processes,
        progress=asked.meter("drawing"), shard=asked.shard,
    )  # fmt: skip
    outcomes = asked.diagnosed(names)
    if outcomes is None:
        return
    judged = judge_cases(out, outcomes)
    if experiments:
        judged = carry_out(
            out, judged, seed, experiments, processes=asked.processes,
            progress=asked.meter("next runs"),
        )  # fmt: skip
    wrong = wrong_cases(judged)
    _write(out, wrong, judged, asked.command)
    count = f"{len(wrong)} of {len(judged)} verdicts are wrong: {out / 'wrong.txt'}"
    asked.write(as_json(judged, asked.about), as_text(judged), count)


def _write(out: Path, wrong: Sequence[str], judged: Sequence[Judged], command: str) -> None:
    """Write wrong verdicts and pictures."""
    from locosweep.files.atomic import write_text
    from locosweep.plot.save import save_figure
    from locosweep.validation.pictures import PICTURES

    write_text(out / "wrong.txt", "\n".join(wrong) + "\n")
    for name, draw in PICTURES.items():
        save_figure(draw(judged), out / name, command=command)
