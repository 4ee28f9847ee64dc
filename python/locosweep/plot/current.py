"""Where a picture is drawn: into axes that were given, else into the current figure of pyplot."""

from __future__ import annotations

from typing import TYPE_CHECKING

from locosweep.errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def current_axes(ax: Axes | None, width: float, height: float) -> Axes:
    """Return `ax`, else the current axes of pyplot while they are empty, else axes of a new figure.

    What stands in a picture already is never drawn over: a second call gets a second figure.

    Parameters
    ----------
    ax : Axes or None
        Where to draw; given, pyplot is not loaded.
    width, height : float
        Size of a new figure in inches.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> from locosweep.plot.current import current_axes
    >>> figure, (left, right) = plt.subplots(1, 2)
    >>> current_axes(None, 6, 4) is right, current_axes(left, 6, 4) is left
    (True, True)
    >>> line = right.plot([1, 2])
    >>> current_axes(None, 6, 4) in figure.axes
    False
    >>> plt.close("all")
    """
    if ax is not None:
        if not hasattr(ax, "pcolormesh"):
            kind = type(ax).__name__
            raise InputError(f"ax is of type {kind}: allowed is one Axes, as plt.subplots() gives")
        return ax
    import matplotlib.pyplot as plt

    if plt.get_fignums() and plt.gcf().axes and not plt.gca().has_data():
        return plt.gca()
    return current_figure(width, height).subplots()


def current_figure(width: float, height: float) -> Figure:
    """Return the current figure of pyplot while nothing is in it, else a new one.

    Parameters
    ----------
    width, height : float
        Size of a new figure in inches.
    """
    # Loading it takes long and chooses a backend: not for who draws into axes of their own.
    import matplotlib.pyplot as plt

    if plt.get_fignums():
        figure = plt.gcf()
        if not (figure.axes or figure.subfigs):
            if figure.get_layout_engine() is None:
                # Legends and captions stand outside the axes, and would be cut off.
                figure.set_layout_engine("constrained")
            return figure
    return plt.figure(figsize=(width, height), layout="constrained")
