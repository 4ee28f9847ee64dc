"""The paper's simulated figures, drawn from the engine's results."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.colors import LogNorm, Normalize

from locosweep.engine import sweep
from locosweep.grid import Grid
from locosweep.paper.claims import FIGURE_2, FIGURE_5, VARIANTS, VISCOUS, crossing, figure_3_force
from locosweep.plot import style
from locosweep.result import Result

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    Drawn = tuple[Figure, list[Result]]


def _figure(title: str, panels: int, width: float = 13.0) -> tuple[Figure, list[Axes]]:
    figure = style.figure(width, 5.6)
    figure.suptitle(title, fontsize=12)
    return figure, list(figure.subplots(1, panels, squeeze=False)[0])


def _figure_2() -> Drawn:
    result = sweep(
        "mean_velocity",
        Grid(
            anchor_weight=list(VARIANTS),
            slope_deg=[0, 4, 8, 12, 16, 20],
            segments=range(2, 17),
            **FIGURE_2,
        ),
    )
    figure, panels = _figure("Figure 2: mean velocity, μ 0.5/0.3, stroke 20 mm", len(VARIANTS))
    for ax, (w, words) in zip(panels, VARIANTS.items(), strict=True):
        result.plot.curves("segments", by="slope_deg", ax=ax, anchor_weight=w)
        ax.set_title(words, fontsize=10)
        ax.axvline(4, color="0.4", linewidth=1, linestyle=":", zorder=0)
        ax.text(
            *(4.15, 0.03),
            "paper: four segments",
            color="0.3",
            fontsize=9,
            transform=ax.get_xaxis_transform(),
        )
    top = max(ax.get_ylim()[1] for ax in panels)
    for ax in panels:
        ax.set_ylim(0, top)
    return figure, [result]


def _figure_3() -> Drawn:
    result = figure_3_force()
    shared = Normalize(float(np.nanmin(result.values)), float(np.nanmax(result.values)))
    figure, panels = _figure("Figure 3: propulsive force, μ 0.5/0.3", len(VARIANTS))
    for ax, (w, words) in zip(panels, VARIANTS.items(), strict=True):
        result.plot.heatmap(ax=ax, norm=shared, anchor_weight=w)
        ax.set_title(words, fontsize=10)
    return figure, [result]


def _figure_4() -> Drawn:
    mu = np.arange(1, 101) / 100
    slopes = np.linspace(0, 70, 141)
    figure, panels = _figure("Figure 4: optimal segment count, equal coefficients", len(VARIANTS))
    equal_mu = Grid(mu_static=mu, mu_coulomb=mu)
    limits = sweep("slope_limit_deg", equal_mu, segments=10**9, anchor_weight=1)
    edge = np.diagonal(limits.values)
    remarks = {
        1: "pole, $\\tan\\alpha = \\mu$: $N_\\mathrm{opt}$ grows without limit",
        0: "$\\tan\\alpha = \\mu$: beyond it anchors slide, which w = 0 leaves out",
    }
    results = [limits]
    for ax, (w, words) in zip(panels, VARIANTS.items(), strict=True):
        full = sweep(
            "optimal_segments", mu_static=mu, mu_coulomb=mu, slope_deg=slopes, anchor_weight=w
        )
        equal = Result(
            full.outputs,
            {"mu_static": mu, "slope_deg": slopes},
            {name: value for name, value in full.fixed.items() if name != "mu_coulomb"},
            [np.einsum("iij->ij", full.values).copy()],
            statuses={full.name: np.einsum("iij->ij", full.status).copy()},
        )
        equal.plot.heatmap(
            ax=ax,
            norm=LogNorm(4, 500),
            levels=[5, 6, 8, 10, 20, 50, 100, 500],
            mark_optimum=False,
        )
        line = ax.plot(edge, mu, color="#d55e00", linewidth=1.8, label=remarks[w])
        old = ax.get_legend()
        ax.legend(
            handles=[*line, *(old.legend_handles if old else ())],
            loc="upper center",
            bbox_to_anchor=(0.5, 0.0),
            borderaxespad=4.6,
            fontsize=8,
            handlelength=2.6,
            frameon=False,
        )
        ax.set_xlim(slopes[0], slopes[-1])
        ax.set_ylabel("friction coefficient $\\mu_S = \\mu_C$")
        ax.set_title(words, fontsize=10)
        results.append(full)
    return figure, results


def _figure_5() -> Drawn:
    time = np.linspace(0, 1.5, 1501)
    dry = sweep("velocity", Grid(time=time, **FIGURE_5))
    wet = sweep("velocity", Grid(coulomb_term=[0, 1], time=time, viscous=VISCOUS, **FIGURE_5))
    ends = sweep("velocity_limit", Grid(coulomb_term=[0, 1], viscous=VISCOUS, **FIGURE_5))
    figure, (ax,) = _figure(
        "Figure 5: dry and viscous friction, N = 3, μ 0.3/0.15, $\\mu_V$ = 0.5 N s/m", 1, 8.5
    )
    wet.plot.curves("time", by="coulomb_term", ax=ax, mark_optimum=False)
    handles = ax.plot(time, dry.values, color="black", linewidth=1.8, label="dry (9)")
    for line, word, limit in zip(list(ax.lines), ("dropped", "kept"), ends.values, strict=False):
        line.set_label(f"viscous (10), Coulomb term {word}")
        level = style.with_unit(float(limit), ends.unit)
        bound = ax.axhline(limit, color=line.get_color(), linewidth=0.9, linestyle=":")
        bound.set_label(f"limit (11), Coulomb term {word}: {level}")
        handles += [line, bound]
    met = crossing(time, dry.values, wet.values[0])
    if met is not None:
        circle = ax.plot(*met, "o", ms=9, mfc="none", mec="black", mew=1.6, ls="none")[0]
        circle.set_label(f"crossing at {met[0]:.4g} s, {met[1]:.4g} m/s")
        handles.append(circle)
    ax.legend(handles=handles, loc="upper left", fontsize=9)
    ax.set_xlim(0, time[-1])
    ax.set_ylim(bottom=0)
    return figure, [dry, wet, ends]


FIGURES: dict[int, Callable[[], Drawn]] = {2: _figure_2, 3: _figure_3, 4: _figure_4, 5: _figure_5}
