"""Pictures of a run folder: of long axes some cells are read, and drawn as those of a result."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.plot.heatmap import Plotter, check_axis, cut, drawn, two

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from matplotlib.axes import Axes

    from locosweep.run_folder.run import Run


class RunPlotter:
    r"""Pictures of one run; ``Run.plot`` makes it.

    Its methods take what those of `locosweep.plot.Plotter` take, and return axes as they do.
    Chunks that hold nothing of a picture are not read.

    Examples
    --------
    >>> import locosweep as ls, tempfile, pathlib
    >>> folder = pathlib.Path(tempfile.mkdtemp()) / "run"
    >>> run = ls.sweep("mean_velocity", mu_static=[0.4, 0.5, 0.6], mu_coulomb=0.3,
    ...                slope_deg=[0, 10], segments=range(2, 9), out=folder)
    >>> ax = run.plot.heatmap("segments", "mu_static", slope_deg=10)
    >>> ax.get_xlabel()
    'number of segments of the robot $N$'
    >>> lines = run.plot.curves("segments", by="slope_deg", mu_static=0.5).get_lines()
    """

    def __init__(self, run: Run) -> None:
        self._run = run

    def heatmap(
        self,
        x: str | None = None,
        y: str | None = None,
        value: str | None = None,
        *,
        note: str = "",
        **options: Any,
    ) -> Axes:
        """Draw an output over two axes, as `Plotter.heatmap` does.

        Of an axis that is longer than a picture is wide in dots, evenly chosen cells are read;
        colours and the marked optimum are those of the cells that are drawn, and a line below
        what is fixed says so.

        Parameters
        ----------
        x, y : str, optional
            Axes; default the last and the one before it, of those that are not fixed.
        value : str, optional
            Output; default the first.
        note : str
            A line below what is fixed.
        **options
            The other arguments of `Plotter.heatmap`, and the value of every other axis.

        Raises
        ------
        InputError
            As `Plotter.heatmap`, and for cells that are not computed.
        """
        at, style = _parted(Plotter.heatmap, options)
        axes = self._run.axes
        x, y = two(axes, x, y, at)
        cut(axes, (y, x), at)
        kept = {
            name: np.sort(drawn(*np.unique(axes[name], return_index=True))[1]) for name in (x, y)
        }
        some = [f"{len(index)} of {len(axes[name])} values of {name}"
                for name, index in kept.items() if len(index) < len(axes[name])]  # fmt: skip
        at |= {name: axes[name][index] for name, index in kept.items()}
        part = self._run.sel(**_kept(at))
        words = [note] * bool(note) + ["drawn: " + ", ".join(some)] * bool(some)
        return part.plot.heatmap(x, y, value, note="; ".join(words), **style)

    def curves(
        self, x: str, *, value: str | None = None, by: str | None = None, **options: Any
    ) -> Axes:
        """Draw an output over one axis, as `Plotter.curves` does, from all its cells.

        Parameters
        ----------
        x : str
            Axis.
        value : str, optional
            Output; default the first.
        by : str, optional
            Axis with one line for each value; give some of them by its name.
        **options
            The other arguments of `Plotter.curves`, and the value of every other axis.

        Raises
        ------
        InputError
            As `Plotter.curves`, and for cells that are not computed.
        """
        at, style = _parted(Plotter.curves, options)
        axes, kept = self._run.axes, (x,) if by is None else (x, by)
        for name in kept:
            check_axis(axes, name)
        cut(axes, kept, {name: wanted for name, wanted in at.items() if name != by})
        return self._run.sel(**_kept(at)).plot.curves(x, value=value, by=by, **style)


def _kept(at: Mapping[str, Any]) -> dict[str, Any]:
    """Keep the axes that are cut at a value, so that pictures name it as those of a result do."""
    return {name: np.atleast_1d(value) for name, value in at.items()}


def _parted(
    method: Callable[..., Axes], options: dict[str, Any]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Part the values of axes from arguments of a method of `Plotter`."""
    known = inspect.signature(method).parameters
    at = {name: value for name, value in options.items() if name not in known}
    return at, {name: value for name, value in options.items() if name in known}
