"""Pictures: data and axes in, axes out; nothing is computed or shown here."""

from locosweep.plot.heatmap import Plotter as Plotter
from locosweep.plot.laws import behaviour as behaviour
from locosweep.plot.laws import characteristic as characteristic
from locosweep.plot.save import save_figure as save_figure
from locosweep.plot.trajectories import motion as motion
