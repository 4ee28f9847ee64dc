"""Pictures: data and axes in, axes out; nothing is computed or shown here."""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from locosweep.plot.heatmap import Plotter as Plotter
    from locosweep.plot.laws import behaviour as behaviour
    from locosweep.plot.laws import characteristic as characteristic
    from locosweep.plot.save import save_figure as save_figure
    from locosweep.plot.trajectories import motion as motion

# Imported when first used: matplotlib takes longer to import than most commands run.
_HOMES = {
    "Plotter": "heatmap",
    "behaviour": "laws",
    "characteristic": "laws",
    "motion": "trajectories",
    "save_figure": "save",
}


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'locosweep.plot' has no attribute '{name}'")
    value: object = getattr(import_module(f"locosweep.plot.{_HOMES[name]}"), name)
    globals()[name] = value
    return value
