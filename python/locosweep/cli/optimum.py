"""The command that finds the best number of segments and says why others lose."""

from __future__ import annotations

import math
import textwrap
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from locosweep import registry
from locosweep.cli import options
from locosweep.cli.options import fixed, show
from locosweep.cli.registry_lists import table
from locosweep.errors import InputError

if TYPE_CHECKING:
    from locosweep.specs.span import Span

_TIE = 1e-12
_WIDTH = 100
_AXIS = "segments"
_SPEED = "mean_velocity"
_AT_BEST = ("anchor_reserve", "anchor_safety", "slope_limit_deg")
_CONTINUOUS = "optimal_segments"
_NOTE = (
    "These are closed forms: each moving segment has one actuator, and phases follow at once. "
    "locosweep gait simulates the whole robot, in which an inner segment is pushed by one joint "
    "and pulled by the next, each up to drive_limit, and may rest after each phase: its speed "
    "differs."
)


@dataclass(frozen=True)
class _Rival:
    segments: int
    status: str
    why: str
    velocity: float = math.nan
    ratio: float = math.nan
    phases: float = math.nan
    phase_time: float = math.nan


@click.command(cls=options.SweepCommand)
@click.option(
    "span",
    "--segments",
    metavar="LO:HI",
    default="2:64",
    show_default=True,
    help="Segment counts to compare, both ends included.",
)
@options.robot_option
@options.set_option
@options.json_option
def optimum(
    span: str, robot: Path | None, settings: tuple[tuple[str, float], ...], json_: bool
) -> None:
    """Find the best number of segments, and why the others lose.

    Counts whose mean velocity differs by less than 1e-12 of it are ties; the
    lowest of them is the best. The slope limit and safety factors are those of
    the best count.
    """
    values = dict(fixed(robot, settings, [_AXIS]))
    if _AXIS in values:
        raise InputError(f"--set {_AXIS}: it is what is compared here, give --segments LO:HI")
    rivals = _rivals(_segments(span), values)
    best = next((rival for rival in rivals if rival.ratio == 1.0), None)
    ties = [r.segments for r in rivals if best and r is not best and r.ratio >= 1.0 - _TIE]
    facts = _facts(best, values)
    report = {
        "best": None if best is None else best.segments,
        "ties": ties,
        "velocity": None if best is None else best.velocity,
        "facts": facts,
        "rivals": [asdict(rival) for rival in rivals],
        "note": _NOTE,
        "fixed": values,
    }
    show(json_, report, _text(best, ties, facts, rivals))


def _segments(text: str) -> Span:
    from locosweep.specs.span import Span

    try:
        span = options.AXIS.convert(f"{_AXIS}={text}", None, None)[1]
    except click.BadParameter as error:
        raise InputError(f"--segments: {error.message}") from None
    if not isinstance(span, Span):
        raise InputError(f"--segments is '{text}': allowed is LO:HI")
    return span


def _rivals(span: Span, values: dict[str, float]) -> list[_Rival]:
    import numpy as np

    from locosweep.specs.sweep import Spec

    fixed_ = tuple(values.items())
    names = (_SPEED, "cycle_time", "phase_time")
    result = Spec(names, ((_AXIS, span),), fixed_).run()
    speed, time = result[_SPEED], result["phase_time"]
    phases = result["cycle_time"] / time
    counts = result.axes[_AXIS].astype(int)
    best = -1
    if np.isfinite(speed).any():
        # The engine's own reduction decides, so that ties fall as everywhere else.
        chosen = Spec((_SPEED,), ((_AXIS, span),), fixed_, over=_AXIS, reduce=("argmax",)).run()
        best = int(np.flatnonzero(counts == int(chosen.values))[0])
    rivals = []
    for i, code in enumerate(result.status_of(_SPEED)):
        status = registry.Status(code)
        name, count = status.name.lower(), int(counts[i])
        if status or best < 0:
            rivals.append(_Rival(count, name, status.sentence))
            continue
        why, ratio = "best", 1.0
        if i != best:
            why = (
                f"{phases[i] / phases[best]:.3g} x the phases, "
                f"each {time[i] / time[best]:.3g} x as long"
            )
            # A tie may be the faster one by rounding; only the best has 1.
            ratio = float(min(speed[i] / speed[best], np.nextafter(1.0, 0.0)))
        numbers = (float(speed[i]), ratio, float(phases[i]), float(time[i]))
        rivals.append(_Rival(count, name, why, *numbers))
    return rivals


def _facts(best: _Rival | None, values: dict[str, Any]) -> dict[str, dict[str, object]]:
    """Return the continuous optimum, and what holds at the best count."""
    from locosweep.engine import sweep

    results = {_CONTINUOUS: sweep(_CONTINUOUS, **values)}
    if best is not None:
        at_best = sweep(_AT_BEST, **values, segments=best.segments)
        results |= dict.fromkeys(_AT_BEST, at_best)
    facts: dict[str, dict[str, object]] = {}
    for name, result in results.items():
        status = registry.Status(int(result.status_of(name)))
        facts[name] = {
            "value": float(result[name]),
            "unit": result.output(name).unit,
            "status": status.name.lower(),
            "meaning": status.sentence if status else registry.quantity(name).meaning,
        }
    return facts


def _text(
    best: _Rival | None,
    ties: list[int],
    facts: dict[str, dict[str, object]],
    rivals: list[_Rival],
) -> str:
    rows = []
    if best is None:
        rows.append(("best segments", "none", "no count of these moves, see below"))
    else:
        rows.append(("best segments", str(best.segments), "highest mean velocity"))
        rows.append(("mean velocity", f"{best.velocity:.6g} m/s", "with that count"))
        also = ", ".join(map(str, ties)) or "none"
        rows.append(("ties", also, f"within {_TIE:g} of the same mean velocity"))
    for name, fact in facts.items():
        number = "none" if fact["status"] != "ok" else f"{fact['value']:.6g}"
        unit = "" if fact["unit"] == "1" or number == "none" else f" {fact['unit']}"
        rows.append((registry.words_of_name(name), number + unit, str(fact["meaning"])))
        if name == _CONTINUOUS and number != "none":
            # Beside the whole number that stands above it.
            rows[-1] = (*rows[-1][:2], f"{fact['meaning']}, which may lie below all whole ones")
    losers = []
    for r in rivals:
        numbers = [f"{r.velocity:.6g}", f"{r.ratio:.4f}", f"{r.phases:g}", f"{r.phase_time:.4g}"]
        losers.append((str(r.segments), *(numbers if r.status == "ok" else "----"), r.why))
    heads = ("segments", "speed [m/s]", "of best", "phases", "phase time [s]", "why")
    tables = f"{table(rows, ('', '', ''), ' r').lstrip()}\n\n{table(losers, heads, 'rrrrr')}"
    return f"{tables}\n\n{textwrap.fill(_NOTE, _WIDTH)}"
