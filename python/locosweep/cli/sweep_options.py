"""Arguments that say what is swept: quantities, axes and what is folded, or a sweep file."""

from __future__ import annotations

import functools
import inspect
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import click

from locosweep.cli import options
from locosweep.cli.simulation_options import refuse_beside, refuse_idle, simulation_options
from locosweep.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

    from locosweep.specs.simulation import Simulation
    from locosweep.specs.span import Span
    from locosweep.specs.sweep import Spec

    Axes = tuple[tuple[str, Span | tuple[float, ...]], ...]

_Command = TypeVar("_Command", bound="Callable[..., Any]")


def sweep_options(command: _Command) -> _Command:
    """Add what says a sweep; the command gets `asked`, which makes its `Spec` of the quantities."""

    @functools.wraps(command)
    def with_sweep(*arguments: Any, **given: Any) -> Any:
        own = {name: given.pop(name) for name in _SAYS_A_SWEEP}
        return command(*arguments, asked=functools.partial(_asked, **own), **given)

    for option in reversed(_OPTIONS):
        with_sweep = option(with_sweep)
    return cast("_Command", with_sweep)


_OPTIONS: tuple[Callable[[Any], Any], ...] = (
    click.option(
        "axes", "--axis", multiple=True, type=options.AXIS,
        help="Axis NAME=LO:HI:COUNT, NAME=A,B,C or, for whole numbers, NAME=LO:HI; repeat in "
        "order.",
    ),
    options.robot_option,
    options.set_option,
    simulation_options(gait=True),
    click.option("--over", type=options.PARAMETER, metavar="NAME", help="Axis to fold away."),
    click.option(
        "--reduce", multiple=True, type=options.REDUCTION, metavar="HOW", help="How; repeatable."
    ),
    click.option("--q", type=float, metavar="Q", help="Which quantile, from 0 to 1."),
    click.option("--dtype", metavar="TYPE", help="float64 (default) or float32."),
    click.option(
        "spec_file", "--spec", metavar="FILE.toml", type=options.FILE,
        help="Sweep file instead of quantities, --axis, --over, --reduce and --q.",
    ),
)  # fmt: skip


def _asked(
    quantities: tuple[str, ...],
    *,
    axes: Axes,
    robot: Path | None,
    settings: tuple[tuple[str, float], ...],
    simulation: Simulation,
    over: str | None,
    reduce: tuple[str, ...],
    q: float | None,
    dtype: str | None,
    spec_file: Path | None,
) -> Spec:
    """Return the sweep that quantities and options, or a sweep file, ask for."""
    from locosweep.specs.sweep import Spec

    files = [name for name in quantities if name.endswith(".toml")]
    if files:
        if len(quantities) > 1 or spec_file is not None:
            raise InputError(f"{files[0]} is given beside QUANTITY or --spec: allowed is either")
        quantities, spec_file = (), Path(files[0])
    if spec_file is not None:
        given: dict[str, object] = {"QUANTITY": quantities, "--axis": axes, "--over": over}
        given |= {"--reduce": reduce, "--q": q, "--dtype": dtype}
        refuse_beside("--spec", given, simulation)
        read = Spec.load(spec_file)
        return replace(read, fixed=options.fixed(robot, settings, dict(read.axes), read.fixed))
    if not quantities:
        raise InputError("QUANTITY is missing: name at least one, or give --spec FILE.toml")
    refuse_idle(dict(axes), quantities, simulation)
    values = options.fixed(robot, settings, dict(axes))
    return Spec(quantities, axes, values, over, reduce, q, dtype or "float64", simulation)


_SAYS_A_SWEEP = tuple(inspect.signature(_asked).parameters)[1:]
"""What options give, behind the quantities."""


def refuse_options(ctx: click.Context, form: str, taken: frozenset[str]) -> None:
    """Refuse options of the command line that do not go with a form of the argument."""
    for param in ctx.command.params:
        name = param.name or ""
        source = ctx.get_parameter_source(name)
        given = source is not None and source.name not in ("DEFAULT", "DEFAULT_MAP")
        if isinstance(param, click.Option) and given and name not in taken:
            raise InputError(f"{param.opts[-1]} is given beside {form}: allowed is one of them")
