"""All pictures of a diagnosis, by the name of their file."""

from __future__ import annotations

from typing import TYPE_CHECKING

from locosweep.diagnosis.report.figures_cause import candidates, contributions, horizons, parameters
from locosweep.diagnosis.report.figures_law import law
from locosweep.diagnosis.report.figures_localization import force_view, shares, where_in_time
from locosweep.diagnosis.report.figures_motion import runs_large, runs_small

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.figure import Figure

    from locosweep.diagnosis.report.result import Diagnosis

FILES: dict[str, Callable[[Diagnosis], Figure | None]] = {
    "runs_large.png": runs_large,
    "runs_small.png": runs_small,
    "where_in_time.png": where_in_time,
    "shares.png": shares,
    "force_view.png": force_view,
    "contributions.png": contributions,
    "law.png": law,
    "candidates.png": candidates,
    "parameters.png": parameters,
    "horizons.png": horizons,
}
"""Files and what draws them; a picture without data is left out."""


def pictures(diagnosis: Diagnosis) -> dict[str, Figure]:
    """Draw all pictures that there is data for, by the name of their file."""
    drawn = {name: draw(diagnosis) for name, draw in FILES.items()}
    return {name: figure for name, figure in drawn.items() if figure is not None}
