"""Pictures of a fit: the characteristic, what is left, the laws, force over time."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep.friction_fit.levels import load_levels
from locosweep.plot import style
from locosweep.plot.numbers import plain_axis
from locosweep.plot.style import LINES

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from locosweep.friction_fit.result import FittedLaw, FrictionFit

_SHOWN = 4000
"""Samples of a cloud."""
_BINS = 12
_LEVELS = 4
"""Loads at which a law is drawn, at most."""
_LAWS = 12
_CLOUD = "0.62"
_MM = 1e3


def pictures(fit: FrictionFit) -> dict[str, Figure]:
    """Draw all pictures of a fit, by file name."""
    return {
        "characteristic.png": characteristic_figure(fit),
        "residuals.png": residual_figure(fit),
        "laws.png": law_figure(fit),
        "force.png": force_figure(fit),
    }


def characteristic_figure(fit: FrictionFit) -> Figure:
    """Draw friction force over velocity: samples, medians with intervals, laws.

    What the sensor adds is taken off. Where levels follow a load, the samples
    at up to four levels of the load are apart, each with the chosen law; else the chosen law stands
    beside those that tie with it.
    """
    figure = style.figure(7.2, 4.8)
    ax = figure.subplots()
    data, law = fit.data, fit.chosen
    v, load = data.column("v"), data.column("load")
    force = data.column("force") - _sensor(law, load)
    shown = _some(v.size, int(fit.provenance["seed"]))  # type: ignore[call-overload]
    moving = np.abs(v) > data.rest_speed
    ax.plot(_MM * v[shown], force[shown], ".", color=_CLOUD, markersize=2, label="samples",
            zorder=1, rasterized=True)  # fmt: skip
    follows = law.load != "constant"
    levels = load_levels(load[moving], _LEVELS) if follows else [(-np.inf, np.inf)]
    for (low, high), (colour, dash, marker) in zip(levels, LINES, strict=False):
        part = moving & (load >= low) & (load <= high)
        if not part.any():
            continue
        at = float(np.median(load[part]))
        label = f"medians at {at:.3g} N" if follows else "medians"
        _medians(ax, _MM * v[part], force[part], law.memory, colour if follows else "black",
                 marker, label)  # fmt: skip
        if follows:
            # To and fro the load may differ a little, and with it the force.
            ways = [part & (v > 0), part & (v < 0)]
            loads = [float(np.median(load[way])) if way.any() else at for way in ways]
            _line(ax, law, v, loads, colour, dash, f"{law.law} at {at:.3g} N")
    if not follows:
        for one, (colour, dash, _) in zip([law, *fit.equal][:4], LINES, strict=False):
            _line(ax, one, v, [None, None], colour, dash, one.name)
    style.zero_line(ax)
    ax.axvline(0, color="0.75", linewidth=0.8, zorder=0)
    # Lone fast samples must not press the rest together.
    edge = _MM * float(np.quantile(np.abs(v), 0.998)) * 1.15
    ax.set_xlim(-edge if (v < -data.rest_speed).any() else -0.04 * edge,
                edge if (v > data.rest_speed).any() else 0.04 * edge)  # fmt: skip
    _finish(ax, "velocity [mm/s]", "friction force [N]")
    ax.set_title(f"Friction characteristic: {law.name}", fontsize=10)
    return figure


def residual_figure(fit: FrictionFit) -> Figure:
    """Draw what the chosen law leaves on samples held out, against each variable."""
    data, law = fit.data, fit.chosen
    left = data.column("force") - law.held_out
    since = np.concatenate([run.t[run.rows] - run.t[0] for run in data.runs])
    axes = [
        ("v", _MM * data.column("v"), "velocity [mm/s]"),
        ("x", _MM * data.column("x"), "position [mm]"),
        ("t", since, "time since the run's start [s]"),
    ]
    if data.loaded:
        axes.append(("load", data.column("load"), "load [N]"))
    figure = style.figure(8.4, 6.0)
    seen = np.isfinite(left)
    shown = np.intersect1d(np.flatnonzero(seen), _some(left.size, 0))
    for ax, (name, values, label) in zip(figure.subplots(2, 2).ravel(), axes, strict=False):
        ax.axhspan(-fit.noise, fit.noise, color="0.9", zorder=0)
        ax.axhline(0, color="0.5", linewidth=0.8, zorder=1)
        ax.plot(values[shown], left[shown], ".", color=_CLOUD, markersize=2, zorder=1,
                rasterized=True)  # fmt: skip
        back = data.column("v") < 0
        for part, (colour, _, marker), direction in (
            (seen & ~back, LINES[0], "forward"), (seen & back, LINES[1], "backward")
        ):  # fmt: skip
            if part.any():
                _medians(ax, values[part], left[part], law.memory, colour, marker, direction)
        _finish(ax, label, "measured less law [N]")
        share = fit.left.get(name)
        if share is not None:
            ax.set_title(f"{100 * share:.0f} % of what is left", fontsize=9)
    for ax in figure.axes[len(axes) :]:
        ax.remove()
    figure.suptitle(f"Left by {law.name} on samples held out; grey band: sensor noise", fontsize=10)
    return figure


def law_figure(fit: FrictionFit) -> Figure:
    """Draw what each law leaves on samples held out, beside the sensor's noise."""
    laws = fit.laws[:_LAWS]
    if fit.chosen not in laws:
        laws[-1] = fit.chosen
    figure = style.figure(7.6, 1.4 + 0.3 * len(laws))
    ax = figure.subplots()
    heights = np.arange(len(laws))[::-1]
    for at, law in zip(heights, laws, strict=True):
        colour, hatch = ("#0072b2", "") if law.tied else ("0.75", "")
        if law is fit.chosen:
            colour, hatch = "#d55e00", "//"
        ax.barh(at, law.held_out_rms, height=0.7, color=colour, hatch=hatch, edgecolor="white")
        behind = "tie" if law.tied else f"{law.sigmas:.1f} s.d. behind"
        text = "chosen" if law is fit.chosen else behind
        count = len(law.parameters)
        # White behind the words, which the line of the noise may cross.
        ax.text(law.held_out_rms * 1.01, at, f"{text}, {count} parameter{'s' * (count != 1)}",
                va="center", fontsize=7.5, zorder=5,
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0})  # fmt: skip
    ax.axvline(fit.noise, color="black", linestyle="--", linewidth=1.2, label="sensor noise")
    ax.set_yticks(heights, [law.name for law in laws], fontsize=8)
    widest = max(law.held_out_rms for law in laws)
    # Long names of laws leave a narrow frame: room for the words behind the widest bar.
    ax.set_xlim(0, 1.9 * widest)
    ax.set_xlabel("root mean square left on samples held out [N]")
    ax.legend(fontsize=8, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)
    plain_axis(ax.xaxis)
    ax.spines[["top", "right"]].set_visible(False)
    return figure


def force_figure(fit: FrictionFit) -> Figure:
    """Draw measured force and the chosen law over time, in up to three runs."""
    data, law = fit.data, fit.chosen
    held = [run for run in data.runs if run.label in data.held_out]
    runs = (held or data.runs)[:3]
    figure = style.figure(8.4, 1.1 + 2.0 * len(runs))
    starts = dict(
        zip([r.label for r in data.runs], np.cumsum([0, *data.lengths])[:-1], strict=True)
    )
    grid = figure.subplots(len(runs), 1, squeeze=False)[:, 0]
    for ax, run in zip(grid, runs, strict=True):
        own = slice(starts[run.label], starts[run.label] + run.rows.size)
        # As much as the eye can resolve.
        t = run.t - run.t[0]
        part = t <= min(t[-1], _stretch(t, run.v))
        ax.plot(t[part], run.force[part], color=_CLOUD, linewidth=1.0, label="measured")
        rows = run.rows[part[run.rows]]
        law_force = law.held_out[own][part[run.rows]]
        # A line would bridge what does not count.
        ax.plot(t[rows], law_force, ".", color="#d55e00", markersize=2.5, label=law.name)
        _finish(ax, "time since the run's start [s]", "force [N]", legend=ax is grid[0])
        role = "held out" if run.label in data.held_out else data.by.replace(" in", " held out in")
        ax.set_title(f"run {run.label} ({role})", fontsize=9)
    return figure


def _stretch(t: NDArray[np.float64], v: NDArray[np.float64]) -> float:
    """Time of about six reversals; all where there are fewer."""
    turns = np.flatnonzero(np.diff(np.sign(v)) != 0)
    # Noise about a turn is one turn.
    slow = turns[np.diff(turns, prepend=-t.size) > max(3, t.size // 200)]
    return float(t[slow[6]] - t[0]) if slow.size > 6 else float(np.ptp(t))


def _finish(ax: Axes, x: str, y: str, *, legend: bool = True) -> None:
    ax.set(xlabel=x, ylabel=y)
    style.grid(ax)
    if legend:
        ax.legend(fontsize=7.5, frameon=True, framealpha=0.85, edgecolor="none", loc="best")


def _sensor(law: FittedLaw, load: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return what the force sensor shows without friction."""
    offset = law.parameters["force_offset"].value if law.offset else 0.0
    gain = law.parameters["load_gain"].value if law.gain else 0.0
    return offset + gain * load


def _some(count: int, seed: int) -> NDArray[np.int64]:
    """Numbers of some samples, rising."""
    every = np.arange(count)
    if count <= _SHOWN:
        return every
    return np.sort(np.random.default_rng(seed).choice(every, _SHOWN, replace=False))


def _line(
    ax: Axes, law: FittedLaw, v: NDArray[np.float64], loads: Sequence[float | None],
    colour: str, dash: Any, label: str,
) -> None:  # fmt: skip
    """Draw a law forward and backward, under the load of each."""
    for sign, name, load in zip((1.0, -1.0), (label, None), loads, strict=True):
        reach = float(np.quantile(sign * v, 0.999))
        if reach <= 0:
            continue
        speeds = sign * np.geomspace(reach * 1e-3, reach * 1.1, 300)
        ax.plot(_MM * speeds, law.force(speeds, load), color=colour, linestyle=dash,
                linewidth=1.6, label=name, zorder=3)  # fmt: skip


def _medians(
    ax: Axes, x: NDArray[np.float64], y: NDArray[np.float64], memory: float, colour: str,
    marker: str, label: str,
) -> None:  # fmt: skip
    """Medians over bins with as many samples, with 95 % intervals from ranks."""
    from scipy.stats import binom

    middles, medians, low, high = [], [], [], []
    for side in (x < 0, x >= 0):
        if side.sum() < _BINS:
            continue
        order = np.argsort(x[side])
        for part in np.array_split(order, min(_BINS, max(1, int(side.sum() / 20)))):
            values = np.sort(y[side][part])
            # Neighbours in time say the same: fewer count.
            count = max(int(values.size / memory), 1)
            reach = binom.ppf([0.025, 0.975], count, 0.5) / count
            middles.append(np.median(x[side][part]))
            medians.append(np.median(values))
            low.append(np.quantile(values, reach[0]))
            high.append(np.quantile(values, reach[1]))
    middle = np.array(medians)
    reach_down, reach_up = middle - np.array(low), np.array(high) - middle
    ax.errorbar(middles, middle, yerr=np.array([reach_down, reach_up]).clip(0), fmt=marker,
                color=colour, markersize=4.5, capsize=2, linewidth=1.0, markeredgecolor="white",
                markeredgewidth=0.5, label=label, zorder=4)  # fmt: skip
