"""``locosweep explore``: a sweep as a page that answers to pointer and keys."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from locosweep.cli import options
from locosweep.cli.options import called, meter, show
from locosweep.cli.run_options import SHOWN, is_result, is_run
from locosweep.cli.sweep_options import refuse_options, sweep_options
from locosweep.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from locosweep.plot.explorer.page import Explorer
    from locosweep.specs.sweep import Spec

_OWN = frozenset({"out", "json_", "allow_missing"})
"""Options that go with a saved result and a run folder."""


@click.command(cls=options.SweepCommand)
@click.argument("shown", nargs=-1, type=SHOWN, metavar="QUANTITY...|SPEC.toml|RESULT.parquet|RUN/")
@sweep_options
@click.option("--out", required=True, type=options.PAGE, help="The page.")
@click.option(
    "--allow-missing", is_flag=True, help="Of a run folder, hatch the cells not computed yet."
)
@options.threads_option
@options.progress_option
@options.json_option
@click.pass_context
def explore(
    ctx: click.Context,
    shown: tuple[str, ...],
    out: Path,
    allow_missing: bool,
    threads: int | None,
    json_: bool,
    asked: Callable[[tuple[str, ...]], Spec],
) -> None:
    """Write a page on which a sweep is looked at: two axes as a map, sliders for the others.

    The page opens by a double click, needs no network and has at most 8 MB: of larger sweeps it
    holds evenly chosen values of the longest axes, and says so.
    """
    from locosweep.plot.explorer.page import explorer

    stored = [one for one in shown if is_result(one) or is_run(one)]
    if stored and len(shown) > 1:
        raise InputError(f"{stored[0]} is given beside {' '.join(shown[:2])}: allowed is one")
    command = called(ctx)
    if stored:
        refuse_options(ctx, stored[0], _OWN)
        if is_run(stored[0]):
            from locosweep.run_folder.run import open_run

            page = explorer(open_run(stored[0], allow_missing=allow_missing), command=command)
        else:
            from locosweep.files.results import load

            page = explorer(load(stored[0]), command=command)
    else:
        page = _computed(asked(shown), threads, command)
    if allow_missing and not (stored and is_run(stored[0])):
        raise InputError("--allow-missing is given: allowed with a run folder only")
    page.save(out)
    show(json_, {"out": out, "bytes": out.stat().st_size}, out)


def _computed(spec: Spec, threads: int | None, command: str) -> Explorer:
    """Compute the cells that a page can hold, whatever the size of the sweep."""
    from dataclasses import replace

    from locosweep.plot.explorer.page import explorer, shown_of

    full = {name: axis for name, axis in spec.grid().axes.items() if name != spec.over}
    some = shown_of(full, len(spec.quantities) * max(1, len(spec.reduce)))
    axes = tuple((name, tuple(some[name].tolist()) if name in some else values)
                 for name, values in spec.axes)  # fmt: skip
    result = replace(spec, axes=axes).run(threads=threads, progress=meter("explore", "points"))
    return explorer(result, command=command, full=full)
