"""Verdict of a fit: the law chosen, its ties, and the structure of its residual."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep import _core

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from locosweep.friction_fit.prepare import Prepared
    from locosweep.friction_fit.result import FittedLaw, FittedParameter

_REFUTED = 10.0
"""Difference of the Schwarz criterion that is very strong evidence (Kass and Raftery 1995)."""

_BINS = 12
_MUCH_LEFT = 0.1
"""Share of what is left from which a variable is named."""
_NEAR_NOISE = 1.5
"""Residual over noise up to which nothing more is to be found."""


def schwarz(rms: float, pieces: float, parameters: int) -> float:
    """Return the Schwarz criterion of a fit with this residual [N] on independent pieces."""
    least = float(np.finfo(float).tiny)
    return float(2.0 * pieces * np.log(max(rms, least)) + parameters * np.log(max(pieces, 2.0)))


def choose(
    data: Prepared, laws: list[FittedLaw]
) -> tuple[FittedLaw, list[FittedLaw], list[FittedLaw]]:
    """Take the simplest of the laws that tie with the best one, without remarks if any is.

    Samples held out may be few: a law that they cannot tell from the best one, but that
    the samples fitted to refute, does not tie. `laws` have the best one on held-out samples
    first. Returns the law, and those that tie with it with as many parameters and with more.
    """
    tied = _not_refuted(data, [law for law in laws if law.tied])
    sound = [law for law in tied if not law.remarks] or tied
    fewest = min(len(law.parameters) for law in sound)
    simplest = [law for law in sound if len(law.parameters) == fewest]
    chosen = simplest[0]
    return chosen, simplest[1:], [law for law in tied if law not in simplest]


def remarks_on(
    parameters: dict[str, FittedParameter], speeds: tuple[float, float], breakaways: int
) -> list[str]:
    """Return what a fitted law says that the data do not show, a line each.

    The level at rest is dominant below the speed of the fall, the other one above; so one of
    them is not seen where no speed measured [m/s, slowest and fastest] lies on its side. A
    break-away shows the level at rest.
    """
    found = [
        f"{p.name} lies at the end of its range, {p.value:.4g} {p.unit}".removesuffix(" 1")
        for p in parameters.values()
        if p.bounded
    ]
    falls = [(parameters[name], inverse) for name, inverse in _core.falls() if name in parameters]
    static = parameters.get("mu_static")
    if not falls or static is None or static.bounded:
        return found
    fall, inverse = falls[0]
    at = 1.0 / fall.value if inverse else fall.value
    slowest, fastest = speeds
    measured = f"the speeds measured ({slowest:.3g} to {fastest:.3g} m/s; the fall is at {at:.3g})"
    if at > fastest:
        level = "mu_coulomb" if "mu_coulomb" in parameters else "viscous"
        found.append(f"{level} lies beyond {measured}")
    if at < slowest and not breakaways:
        found.append(f"mu_static lies below {measured}")
    return found


def _not_refuted(data: Prepared, laws: list[FittedLaw]) -> list[FittedLaw]:
    """Return the laws that the samples fitted to do not speak very strongly against."""
    away = [np.full(run.rows.size, run.label in data.held_out) for run in data.runs]
    fitted = ~np.concatenate(away)
    force = data.column("force")[fitted]
    # A bristle law may have been fitted to fewer samples: all count here.
    left = [float(np.sqrt(np.mean((force - law.predicted[fitted]) ** 2))) for law in laws]
    memory = laws[int(np.argmin(left))].memory
    pieces = force.size / max(memory, 1.0)
    costs = [schwarz(rms, pieces, len(law.parameters)) for rms, law in zip(left, laws, strict=True)]
    best = int(np.argmin(costs))
    most = len(laws[best].parameters)
    # More parameters than needed are no evidence against a law.
    return [
        law
        for law, cost in zip(laws, costs, strict=True)
        if len(law.parameters) > most or not cost > costs[best] + _REFUTED
    ]


def explained_share(data: Prepared, law: FittedLaw) -> float:
    """Return the share of the force's spread on held-out samples that a law explains."""
    seen = np.isfinite(law.held_out)
    force = data.column("force")[seen]
    spread = float(np.sqrt(np.mean((force - np.mean(force)) ** 2)))
    return 1.0 - law.held_out_rms / spread if spread > 0 else 0.0


def left_over(data: Prepared, law: FittedLaw) -> dict[str, float]:
    """Return the share of the held-out residual's variance that follows each variable.

    The residual is averaged over bins of the variable, apart for either direction;
    what bins of pure chance with the residual's memory would take is subtracted.
    """
    seen = np.isfinite(law.held_out)
    residual = (data.column("force") - law.held_out)[seen]
    backward = data.column("v")[seen] < 0
    since = np.concatenate([run.t[run.rows] - run.t[0] for run in data.runs])
    variables = {"v": data.column("v"), "x": data.column("x"), "t": since}
    if data.loaded:
        variables["load"] = data.column("load")
    cells = {name: _cells(values[seen]) + _BINS * backward for name, values in variables.items()}
    return {name: _explained(residual, cell, law.memory) for name, cell in cells.items()}


def _cells(values: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the bin of each value; bins hold as many samples each."""
    edges = np.quantile(values, np.linspace(0, 1, _BINS + 1)[1:-1])
    return np.searchsorted(edges, values).astype(np.int64)


def _explained(residual: NDArray[np.float64], cell: NDArray[np.int64], memory: float) -> float:
    """Return the adjusted share of the variance between cells (adjusted R squared)."""
    _, bins = np.unique(cell, return_inverse=True)
    count = np.bincount(bins)
    mean = np.bincount(bins, residual) / count
    middle = residual - residual.mean()
    whole = float(middle @ middle)
    if whole == 0.0:
        return 0.0
    inside = residual - mean[bins]
    share = float(inside @ inside) / whole
    independent = max(residual.size / memory, 2.0)
    if independent <= count.size + 1:
        return 0.0
    adjusted = 1.0 - share * (independent - 1) / (independent - count.size)
    return float(np.clip(adjusted, 0.0, 1.0))


def summary_of(
    chosen: FittedLaw,
    equal: list[FittedLaw],
    shrink: float,
    noise: float,
    left: dict[str, float],
) -> str:
    """Return the verdict as one sentence."""
    head = f"{chosen.name} leaves {chosen.held_out_rms:.3g} N of the friction force"
    head += f" on samples held out ({100 * shrink:.0f} % of its spread explained)"
    if equal:
        names = ", ".join(law.name for law in equal)
        head += f"; it cannot be told from {names}"
    if noise > 0 and chosen.held_out_rms <= _NEAR_NOISE * noise:
        return f"{head}; what is left is noise."
    most = max(left, key=lambda name: left[name], default=None)
    if most is not None and left[most] >= _MUCH_LEFT:
        words = {"v": "velocity", "x": "position", "t": "time", "load": "load"}
        return f"{head}; {100 * left[most]:.0f} % of what is left follows the {words[most]}."
    return f"{head}; what is left follows none of velocity, position, time and load."
