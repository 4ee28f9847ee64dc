"""What a picture of a result holds fixed, and whether its highest value is its best one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from locosweep.plot import style
from locosweep.registry import Status, drive, law, parameter, quantity, words_of_name
from locosweep.result import OF_AXIS

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping

    from locosweep.result import Output, Result

_BOUNDS = ("time_step", "tolerance", "segments_min", "segments_max")
"""Parameters of how something is found: their defaults tell nothing of a robot."""
_WIDTH = 74
"""Letters of a line that is as wide as a heat map, formulas counted as they are drawn."""


class Holding(Protocol):
    """What holds parameters fixed: a sweep, or points drawn from what is unknown."""

    @property
    def fixed(self) -> Mapping[str, float]:
        """Value of every parameter that is known."""

    @property
    def how(self) -> Mapping[str, str]:
        """Law, drive, method and gait of what was simulated."""


def better_when_larger(output: Output) -> bool:
    """Return whether the highest value of an output is worth a mark.

    Examples
    --------
    >>> import locosweep as ls
    >>> from locosweep.plot.caption import better_when_larger
    >>> r = ls.sweep(["mean_velocity", "cycle_time"], mu_static=0.5, mu_coulomb=0.3, segments=[3])
    >>> [better_when_larger(output) for output in r.outputs]
    [True, False]
    """
    if output.integer or output.reduce in OF_AXIS:
        # Where along an axis something is best says nothing about how good it is.
        return False
    return quantity(output.quantity).larger_is_better


def fixed_settings(result: Result, output: Output, shown: Collection[str]) -> list[str]:
    """Return symbol, value and unit of what a result holds fixed and an output hangs on."""
    words = [style.setting(*one) for one in fixed_values(result, output, shown)]
    if result.over is not None and result.rivals is not None and result.rivals.size:
        record = parameter(result.over)
        low, high = float(result.rivals.min()), float(result.rivals.max())
        words.append(f"${record.symbol}$ from {low:g} to {style.with_unit(high, record.unit)}")
    if output.reduce == "quantile" and result.q is not None:
        words.append(f"$q$ = {result.q:g}")
    return words


def how_of(result: Holding, output: Output) -> Mapping[str, str]:
    """Return law, drive, method and gait where the output was simulated with them."""
    return result.how if quantity(output.quantity).simulated else {}


def fixed_values(
    result: Holding, output: Output, shown: Collection[str]
) -> list[tuple[str, float]]:
    """Return name and value of what a result holds fixed and an output hangs on.

    Parameters at a default that leaves something out (0, infinity, a factor of 1) are not
    named, nor those in `shown`.
    """
    records = list(quantity(output.quantity).parameters)
    how = how_of(result, output)
    if "law" in how:
        records += law(how["law"]).parameters
    if "drive" in how:
        records += drive(how["drive"]).parameters
    found = []
    for name in dict.fromkeys(record.name for record in records):
        value = result.fixed.get(name)
        if value is None or name in shown:
            continue
        default, unit = parameter(name).default, parameter(name).unit
        idle = default in (0.0, float("inf")) or (default == 1.0 and unit == "1")
        idle = idle or name in _BOUNDS
        if value != default or not idle:
            found.append((name, value))
    return found


def reason(result: Result, status: Status) -> str:
    """Say why there is no value; of a reduction, with the name and range of its axis."""
    over, rivals = result.over, result.rivals
    if status is not Status.NONE_FEASIBLE or over is None or rivals is None or not rivals.size:
        return status.sentence
    low, high = float(rivals.min()), style.with_unit(float(rivals.max()), parameter(over).unit)
    return f"no value of {words_of_name(over)} from {low:g} to {high} works"


def title(cut: Iterable[str], fixed: Iterable[str], note: str = "") -> str:
    """Return what is drawn at, what is fixed and a note, in lines of a picture's width."""
    lines = []
    for head, words in (("", cut), ("fixed: ", fixed), ("", [note])):
        line = head
        for word in filter(None, words):
            if len(_plain(line)) + len(_plain(word)) > _WIDTH and line != head:
                lines.append(line.rstrip())
                line = ""
            line += f"{word}, "
        if line != head:
            lines.append(line.removesuffix(", "))
    return "\n".join(lines)


def _plain(text: str) -> str:
    """Return about as many letters as a text with formulas takes."""
    return "".join(c for c in text if c not in "$\\{}_^").replace("alpha", "a").replace("mu", "m")
