"""The command that lists, explains and draws the friction laws."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from locosweep import registry
from locosweep.cli import options
from locosweep.cli.law_pages import markdown
from locosweep.cli.options import called, fixed, meter, show
from locosweep.cli.registry_lists import as_record, names_of, page, table
from locosweep.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from locosweep.simulation.law_data import Characteristic

_LAW = ("name", "kind", "formula", "parameters", "source", "limits", "meaning", "exact")


@click.command()
@click.argument("name", required=False, type=options.LAW)
@click.option(
    "--out",
    metavar="FOLDER",
    type=options.FOLDER,
    help="Draw every law, or the named one, into a folder, made if missing; without NAME also "
    "an overview (laws.png) and a table (laws.md).",
)
@options.robot_option
@options.set_option
@options.progress_option
@options.json_option
@click.pass_context
def laws(
    ctx: click.Context,
    name: str | None,
    out: Path | None,
    robot: Path | None,
    settings: tuple[tuple[str, float], ...],
    json_: bool,
) -> None:
    """List the friction laws, tell everything about one, or draw them.

    Pictures share one frame. They use values that show the traits of each law;
    --robot and --set give others.
    """
    some = registry.laws() if name is None else [registry.law(name)]
    if out is None and (robot is not None or settings):
        raise InputError("--robot and --set give values for pictures: allowed beside --out FOLDER")
    files = [] if out is None else _draw(ctx, out, some, name is None, robot, settings)
    records = [as_record(law, _LAW) for law in some] if name is None else _detail(some[0])
    if files:
        show(json_, {"files": files, "laws": records}, *files)
    elif name is None:
        rows = [(law.name, law.kind, law.meaning, names_of(law.parameters)) for law in some]
        more = "\nlocosweep laws NAME shows formula, source, limits, units and ranges of one."
        show(json_, records, table(rows, ("law", "kind", "meaning", "parameters")), more)
    else:
        show(json_, records, _page(some[0]))


def _detail(law: registry.Law) -> dict[str, object]:
    names = ("name", "symbol", "unit", "default", "range", "meaning")
    return as_record(law, _LAW) | {"parameters": [as_record(p, names) for p in law.parameters]}


def _page(law: registry.Law) -> str:
    known = "motion between events is known in closed form"
    exact = known if law.exact else "no: stepped by a numerical method"
    return page(law, as_record(law, ("kind", "formula", "source", "limits")) | {"exact": exact})


def _draw(
    ctx: click.Context,
    out: Path,
    some: Sequence[registry.Law],
    whole: bool,
    robot: Path | None,
    settings: tuple[tuple[str, float], ...],
) -> list[Path]:
    """Write the pictures, and for all laws the overview and the table."""
    from locosweep.cli import law_pictures
    from locosweep.files.atomic import write_text
    from locosweep.files.folder import make_folder
    from locosweep.plot.laws import frame_of
    from locosweep.plot.save import save_figure
    from locosweep.simulation.law_data import EXAMPLE, behaviour_of, characteristic_of

    values = EXAMPLE | dict(fixed(robot, settings, ()))
    # All laws, also where one is drawn: pictures of different calls then compare.
    seen: dict[str, Characteristic] = {
        law.name: characteristic_of(law.name, **values) for law in registry.laws()
    }
    for one in seen.values():
        if not one.level > 0.0:
            raise InputError(
                f"the friction level of {one.law} is 0 (mu_coulomb, mu_static, mass or gravity): "
                "pictures are relative to it"
            )
    frame = frame_of(*seen.values())
    pages = {law.name: behaviour_of(law.name, **values) for law in some}
    make_folder(out)
    progress = meter("laws", "pictures")
    command, files = called(ctx), []
    if whole:
        files.append(out / "laws.png")
        save_figure(
            law_pictures.overview(some, list(seen.values()), frame), files[-1], command=command
        )
        files.append(out / "laws.md")
        write_text(files[-1], markdown(some))
    for done, law in enumerate(some, 1):
        files.append(out / f"{law.name}.png")
        used = {p.name: values.get(p.name, p.default or 0.0) for p in law.parameters}
        figure = law_pictures.page(law, seen[law.name], pages[law.name], frame, used)
        save_figure(figure, files[-1], command=command)
        if progress is not None:
            progress(done, len(some))
    return files
