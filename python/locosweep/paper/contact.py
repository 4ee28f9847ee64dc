"""Figures 7 to 9: friction over velocity on the three surfaces, as an illustration.

The paper measured friction and prints no numbers. Here the sensors of a friction rig are
simulated with the contact of the other figures, and `fit_friction` has to find it again.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, partial
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import polars as pl
from matplotlib.lines import Line2D

from locosweep import _core
from locosweep.friction_fit import fit_friction
from locosweep.paper.surfaces import GROUND, SURFACES
from locosweep.plot import style
from locosweep.registry import law, parameter

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from locosweep.friction_fit import FittedLaw, FrictionFit
    from locosweep.result import Result

    Floats = NDArray[np.float64]

_LAWS = {"dry": "coulomb", "oil": "coulomb_viscous", "lubricant": "buildup"}
"""Law that is planted on each surface."""
_RIVALS = ("coulomb", "coulomb_viscous", "stribeck", "quadratic", "buildup")
"""Laws that the fit chooses from."""

_PEAKS = (0.05, 0.10, 0.15, 0.20, 0.25)
"""Largest speed of each run in m/s, up to that of the head in Figure 10."""
_STROKE = 0.02
_MIDDLE = 0.025
"""Middle of the sensor's range of 50 mm."""
_RATE, _DURATION = 500.0, 2.0
_STEP = 5e-6
"""Step of the paper's position sensor in m; its noise is assumed as large."""
_SPEED_NOISE, _FORCE_NOISE = 1e-3, 0.01
"""Assumed standard deviations in m/s and N."""
_SEED = 2013
_NORMAL_95 = 1.96
"""Standard deviations within which 95 % of normal noise lie."""
_SURE = 5.0
"""Standard deviations of the velocity from which its sign is certain."""
_MM = 1e3
_FULL = 3
"""Look of the law behind a full heap, beside those of the three surfaces."""
_FRESH = 1e-9
"""Way in m after which there is no heap yet."""
_NEAR = (0.35, 0.7)
"""Forces in N that are enlarged, the same in all three figures."""


@dataclass(frozen=True)
class Contact:
    """Planted values of a surface and the fit to what the rig's sensors read of it."""

    planted: dict[str, float]
    fit: FrictionFit


def _mass() -> float:
    return parameter("mass").default or 0.0


def _weight() -> float:
    return _mass() * (parameter("gravity").default or 0.0)


def _rig(name: str, planted: dict[str, float], seed: int) -> pl.DataFrame:
    """Sensor data of a rig that moves one segment to and fro by 20 mm, one run for each speed."""
    generator = np.random.default_rng(seed)
    t = np.arange(round(_RATE * _DURATION)) / _RATE
    half = _STROKE / 2
    frames = []
    for run, peak in enumerate(_PEAKS):
        x = _MIDDLE - half * np.cos(peak / half * t)
        v = peak * np.sin(peak / half * t)
        weight = np.full(t.size, _weight())
        force = _core.imposed_force(name, list(planted.items()), t, x, v, weight, np.zeros(t.size))
        read = {
            "x": _STEP * np.round((x + generator.normal(0.0, _STEP, t.size)) / _STEP),
            "v": v + generator.normal(0.0, _SPEED_NOISE, t.size),
            "force": force + generator.normal(0.0, _FORCE_NOISE, t.size),
        }
        frames.append(pl.DataFrame({"run": [str(run)] * t.size, "t": t, **read}))
    return pl.concat(frames)


def _seed(surface: str) -> int:
    return _SEED + list(SURFACES).index(surface)


@cache
def contact(surface: str) -> Contact:
    """Simulate the rig on a surface and fit friction laws to what its sensors read."""
    name = _LAWS[surface]
    known = {p.name for p in law(name).parameters}
    values = {"mu_coulomb": GROUND["mu_coulomb"], **SURFACES[surface]}
    planted = {key: value for key, value in values.items() if key in known}
    data = _rig(name, planted, _seed(surface))
    return Contact(planted, fit_friction(data, mass=_mass(), laws=_RIVALS))


def _curve(name: str, values: dict[str, float], speeds: Floats, swept: float) -> Floats:
    """Friction force at each speed after sliding that far at it."""
    given = list(values.items())
    weight, nothing = np.full(2, _weight()), np.zeros(2)
    forces = []
    for v in speeds:
        t, x = np.array([0.0, swept / abs(v)]), np.array([0.0, np.copysign(swept, v)])
        force = _core.imposed_force(name, given, t, x, np.array([v, v]), weight, nothing)
        forces.append(float(force[-1]))
    return np.array(forces)


def _ends(fitted: FittedLaw) -> list[dict[str, float]]:
    """Return every choice of interval ends of the parameters, within what each allows."""
    choices = []
    for name, found in fitted.parameters.items():
        low, high = parameter(name).range
        ends = found.interval or (found.value, found.value)
        choices.append([(name, min(max(end, low), high)) for end in ends])
    return [dict(chosen) for chosen in product(*choices)]


def _law_line(ax: Axes, fit: FrictionFit, swept: float, rank: int, words: str) -> None:
    """Draw the fitted law forward and backward, with its two bands."""
    fitted = fit.chosen
    colour, dash, _ = style.LINES[rank]
    values = {name: found.value for name, found in fitted.parameters.items()}
    noise = _NORMAL_95 * fit.noise
    for sign in (1.0, -1.0):
        speeds = sign * np.linspace(0.002, _PEAKS[-1], 9)
        all_ends = [_curve(fitted.law, ends, speeds, swept) for ends in _ends(fitted)]
        low, high = np.min(all_ends, axis=0), np.max(all_ends, axis=0)
        bands = ((noise, 0.15, "of samples: sensor noise added"), (0.0, 0.55, "of the law"))
        for reach, alpha, of in bands:
            ax.fill_between(
                _MM * speeds, low - reach, high + reach, color=colour, alpha=alpha, linewidth=0,
                zorder=2, label=f"95 % band {of}" if sign > 0 and rank != _FULL else None,
            )  # fmt: skip
        ax.plot(_MM * speeds, _curve(fitted.law, values, speeds, swept), color=colour,
                linestyle=dash, linewidth=1.0, zorder=3, label=words if sign > 0 else None,
                )  # fmt: skip


def _along_runs(ax: Axes, fit: FrictionFit) -> None:
    """Draw the fitted law along the strokes forward, during which the heap grows."""
    begin = 0
    for run in fit.data.runs:
        rows = slice(begin, begin + run.rows.size)
        begin = rows.stop
        v, force = run.v[run.rows], fit.chosen.predicted[rows]
        # Further strokes of the run would lie on the first one; near rest the noise of the
        # velocity has turns of its own.
        first = np.flatnonzero(v[: np.flatnonzero(v < 0)[0]] > _SURE * _SPEED_NOISE)
        ax.plot(_MM * v[first], force[first], color="black", linewidth=0.8, zorder=4,
                label="fitted, along the first stroke of each run" if run is fit.data.runs[0]
                else None)  # fmt: skip


def _parameter_text(name: str, of: Contact) -> str:
    """Return the fitted value beside the planted one, and its interval below."""
    found = of.fit.chosen.parameters[name]
    text = f"{style.setting(name, found.value)}, planted {of.planted.get(name, 0.0):g}"
    if found.interval is None:
        return text + "\n  at the end of its range"
    low, high = (f"{end:.4g}".replace("-", "−") for end in found.interval)
    return f"{text}\n  95 %: {low} to {high}"


def _figure(number: int, surface: str, words: str) -> tuple[Figure, list[Result]]:
    of = contact(surface)
    data = of.fit.data
    figure = style.figure(12.0, 5.8)
    whole, near = figure.subplots(1, 2)
    rank = list(SURFACES).index(surface)
    fitted = f"fitted: {of.fit.chosen.name}"
    for ax in (whole, near):
        ax.plot(_MM * data.column("v"), data.column("force"), ".", color="0.6", markersize=2,
                zorder=1, rasterized=True, label="measured: simulated sensors")  # fmt: skip
        if of.planted.get("buildup"):
            _law_line(ax, of.fit, _FRESH, rank, f"{fitted}, before the stroke, no heap")
            _law_line(ax, of.fit, _STROKE, _FULL, "the same after 20 mm forward, full heap")
            _along_runs(ax, of.fit)
        else:
            _law_line(ax, of.fit, _FRESH, rank, fitted)
        ax.set(xlabel="velocity $v$ [mm/s]", ylabel="friction force $F_T$ [N]")
        style.grid(ax)
    style.zero_line(whole)
    whole.set_ylim(-_NEAR[1], _NEAR[1])
    whole.set_title("both directions", fontsize=10)
    near.set_title("forward, enlarged", fontsize=10)
    near.set(xlim=(0, 1.02 * _MM * _PEAKS[-1]), ylim=_NEAR)
    near.legend(loc="upper left", fontsize=8.5, markerscale=4)
    found = [Line2D([], [], linestyle="none", label=_parameter_text(name, of))
             for name in of.fit.chosen.parameters]  # fmt: skip
    whole.legend(handles=found, loc="lower right", fontsize=8.5, handlelength=0, handletextpad=0,
                 title="fitted and planted", title_fontsize=9)  # fmt: skip
    assumed = ", ".join(style.setting(name, value) for name, value in of.planted.items())
    figure.suptitle(
        f"Figure {number}: {words} over velocity. Illustration: the paper prints no numbers\n"
        f"planted (assumed): {assumed}; noise {_FORCE_NOISE:g} N and {_MM * _SPEED_NOISE:g} mm/s; "
        f"seed {_seed(surface)}",
        fontsize=11,
    )
    return figure, []


CONTACT_FIGURES: dict[int, Callable[[], tuple[Figure, list[Result]]]] = {
    7: partial(_figure, 7, "dry", "dry friction"),
    8: partial(_figure, 8, "oil", "friction with oil"),
    9: partial(_figure, 9, "lubricant", "friction with lubricant"),
}
"""By figure, as ``figures.FIGURES``."""
