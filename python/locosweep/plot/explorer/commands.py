"""A view of a sweep in the words of the shell and of Python."""

from __future__ import annotations

import math
import shlex
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.registry import parameter, quantity

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.result import Output, Result

    Floats = NDArray[np.float64]

IMPORTS = "import numpy as np, locosweep as ls"
_CHOICES = ("law", "drive", "gait", "method")


def shell_axis(name: str, axis: Floats) -> str:
    """Return an axis as ``--axis`` takes it.

    Examples
    --------
    >>> import numpy as np
    >>> from locosweep.plot.explorer.commands import python_axis, shell_axis
    >>> shell_axis("slope_deg", np.linspace(0, 20, 41)), python_axis("slope_deg", np.r_[0, 5, 7])
    ('slope_deg=0.0:20.0:41', '[0.0, 5.0, 7.0]')
    >>> shell_axis("segments", np.arange(2.0, 9.0)), python_axis("segments", np.arange(2.0, 9.0))
    ('segments=2:8', 'range(2, 9)')
    """
    if _whole(name, axis):
        return f"{name}={axis[0]:.0f}:{axis[-1]:.0f}"
    if _even(axis):
        return f"{name}={_number(axis[0])}:{_number(axis[-1])}:{len(axis)}"
    return f"{name}={','.join(_number(one) for one in axis)}"


def python_axis(name: str, axis: Floats) -> str:
    """Return an axis as `sweep` takes it."""
    if _whole(name, axis):
        return f"range({axis[0]:.0f}, {axis[-1] + 1:.0f})"
    if _even(axis):
        return f"np.linspace({float(axis[0])!r}, {float(axis[-1])!r}, {len(axis)})"
    return f"[{', '.join(_literal(float(one)) for one in axis)}]"


def _whole(name: str, axis: Floats) -> bool:
    """Return whether an axis is every whole number from its first value to its last."""
    return parameter(name).integer and len(axis) > 1 and bool((np.diff(axis) == 1).all())


def _even(axis: Floats) -> bool:
    if len(axis) < 3 or not np.isfinite(axis).all():
        return False
    return bool((axis == np.linspace(axis[0], axis[-1], len(axis))).all())


def _number(value: float) -> str:
    return repr(float(value))


def _literal(value: float) -> str:
    return repr(value) if math.isfinite(value) else f'float("{value}")'


def calls(result: Result, output: Output, axes: int) -> dict[str, Any]:
    """Return the beginnings and ends of the commands that compute a map of an output.

    Parameters
    ----------
    result : Result
        What fixes the parameters, and says how something is simulated.
    output : Output
        What is drawn.
    axes : int
        How many axes are drawn, 1 or 2.

    Returns
    -------
    dict
        ``shell``, ``flags`` of the axis upward and the one to the right, ``tail``; ``python``
        and ``more``, arguments behind those of the axes.
    """
    name = output.quantity
    given = {key: value for key, value in result.fixed.items() if value != parameter(key).default}
    how = result.how if quantity(name).simulated else {}
    choice = {key: how[key] for key in _CHOICES if key in how}
    shell = [
        f"--set {key}={value:.0f}" if parameter(key).integer else f"--set {key}={value!r}"
        for key, value in given.items()
    ]
    shell += [f"--{key} {shlex.quote(value)}" for key, value in choice.items()]
    python = [f"{key}={_literal(value)}" for key, value in given.items()]
    python += [f'{key}="{value}"' for key, value in choice.items()]
    if "table_sha256" in how:
        # The samples are not in a result: whoever has them puts their file in.
        shell.append("--drive-file DRIVE.csv")
        python.append("table=(times, values)")
    simple = axes == 2 and output.reduce is None
    if output.reduce is not None and result.over is not None and result.rivals is not None:
        q = None if output.reduce != "quantile" else result.q
        shell.append(f"--axis {shell_axis(result.over, result.rivals)} --over {result.over}")
        shell.append(f"--reduce {output.reduce}" + ("" if q is None else f" --q {q!r}"))
        python.append(f"{result.over}={python_axis(result.over, result.rivals)}")
        python.append(f'over="{result.over}", reduce="{output.reduce}"')
        python += [] if q is None else [f"q={q!r}"]
    end = "--out map.png" if simple else (
        "--out map.parquet && locosweep plot map.parquet --out map.png"
    )  # fmt: skip
    return {
        "shell": f"locosweep {'heatmap' if simple else 'sweep'} {name}",
        "flags": ["--y", "--x"] if simple else ["--axis", "--axis"],
        "tail": " ".join([*shell, end]),
        "python": f'ls.sweep("{name}", ',
        "more": python,
    }
