"""Flexible terms: whether what a law leaves can be carried by the law's own variable.

A force (or a shift of the reading) that is any smooth function of one variable is
added to the fitted motion, to first order: it moves the head only while it slides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import chi2

from locosweep.diagnosis.fit import jacobian_of, point_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.fit import Fit
    from locosweep.diagnosis.problem import Problem

__all__ = ["VARIABLES", "Flexible", "Motion", "motion_of"]

_KNOTS = 9


@dataclass(frozen=True)
class Motion:
    """A fitted motion at the samples of the fitted runs."""

    t: NDArray[np.float64]
    x: NDArray[np.float64]
    v: NDArray[np.float64]
    force: NDArray[np.float64]
    drive: NDArray[np.float64]
    run: NDArray[np.intp]
    swept: NDArray[np.float64]
    turned: NDArray[np.float64]
    mass: float
    damping: float


VARIABLES = {
    "viscous_friction": "speed",
    "quadratic_drag": "speed",
    "stribeck_friction": "speed",
    "back_emf": "speed",
    "direction_dependent_friction": "speed",
    "presliding_compliance": "turned",
    "position_dependent_friction": "place",
    "load_dependent_friction": "load",
    "friction_drift": "time",
    "lubricant_buildup": "swept",
    "drive_saturation": "drive",
    "drive_deadzone": "drive",
    "drive_gain_error": "drive",
    "drive_lag": "history",
    "drive_delay": "history",
    "supply_sag": "sag",
    "transmission_backlash": "history",
    "transmission_compliance": "history",
    "sensor_scale": "reading",
    "sensor_drift": "clock",
    "sensor_delay": "late",
}
"""The variable that an effect acts through, where another law of it is possible.

A mass, a slope and a friction coefficient are numbers: they have no other law.
"""

_ALL = (*dict.fromkeys(VARIABLES.values()), "terrain", "acceleration")
_SURE = 1e-4
"""Probability under noise alone below which a flexible term has found something."""


def motion_of(problem: Problem, fit: Fit) -> Motion:
    """Replay a fit over the fitted runs."""
    point = point_of(problem, fit)
    found = problem.replay([point], problem.fitted)
    runs = [problem.runs[r] for r in problem.fitted]
    number = np.repeat(np.arange(len(runs)), [run.t.size for run in runs])
    x, v = found["x"][0], found["v"][0]
    swept, turned = np.zeros_like(x), np.zeros_like(x)
    for i in range(1, x.size):
        if number[i] != number[i - 1]:
            continue
        step = x[i] - x[i - 1]
        swept[i] = swept[i - 1] + step if v[i] > 0.0 else 0.0
        turned[i] = turned[i - 1] + step if v[i] * v[i - 1] > 0.0 else 0.0
    dm = point.values[problem.place("payload_mass", "dm")]
    dm = dm if "payload_mass" in point.names else 0.0
    c = problem.nominal["viscous"]
    for name, key in (("viscous_friction", "c"), ("back_emf", "k_e")):
        if name in point.names:
            c += point.values[problem.place(name, key)]
    return Motion(
        t=np.concatenate([run.since_start for run in runs]),
        x=x,
        v=v,
        force=found["force"][0],
        drive=np.concatenate([run.drive for run in runs]) * problem.nominal["gain"],
        run=number,
        swept=swept,
        turned=turned,
        mass=problem.nominal["mass"] * point.shares[0] + dm,
        damping=max(c, 0.0),
    )


def _hats(
    values: NDArray[np.float64], where: NDArray[np.bool_], knots: int = _KNOTS
) -> NDArray[np.float64]:
    """Piecewise linear functions on knots at quantiles of where the values count."""
    if where.sum() < 3 * knots:
        return np.zeros((0, values.size))
    edges = np.unique(np.quantile(values[where], np.linspace(0.0, 1.0, knots)))
    if edges.size < 3:
        return np.zeros((0, values.size))
    return np.array([np.interp(values, edges, row) for row in np.eye(edges.size)])


def _terms(variable: str, m: Motion) -> tuple[NDArray[np.float64], bool]:
    """Basis functions along a motion, and whether they are forces (or readings)."""
    moving = m.v != 0.0
    sign = np.sign(m.v)
    every = np.ones(m.v.size, dtype=bool)
    if variable == "speed":
        forward = _hats(m.v, m.v > 0.0) * (m.v > 0.0)
        backward = _hats(m.v, m.v < 0.0) * (m.v < 0.0)
        return np.vstack([forward, backward]), True
    if variable == "place":
        return _hats(m.x, moving, 25) * sign, True
    if variable == "terrain":
        return _hats(m.x, moving), True
    if variable == "load":
        return _hats(np.abs(m.force), moving) * sign, True
    if variable == "time":
        return _hats(m.t, moving) * sign, True
    if variable == "swept":
        return _hats(m.swept, m.v > 0.0) * (m.v > 0.0), True
    if variable == "turned":
        return np.vstack(
            [
                _hats(m.turned, m.v > 0.0) * (m.v > 0.0),
                _hats(m.turned, m.v < 0.0) * (m.v < 0.0),
            ]
        ), True
    if variable == "drive":
        return _hats(m.drive, moving, 13), True
    if variable == "sag":
        return _hats(m.t, moving) * m.drive, True
    if variable == "acceleration":
        rate = np.gradient(m.v, m.t + m.run * (m.t.max() + 1.0))
        return np.vstack([_hats(rate, moving), sign[None, :]]), True
    if variable == "history":
        rows = []
        span = float(m.t.max())
        for share in (2e-3, 5e-3, 0.01, 0.02, 0.04, 0.08):
            late = np.zeros_like(m.drive)
            for r in np.unique(m.run):
                own = m.run == r
                late[own] = np.interp(m.t[own] - share * span, m.t[own], m.drive[own])
            rows.append(late - m.drive)
        return np.array(rows), True
    if variable == "reading":
        return _hats(m.x, every), False
    if variable == "clock":
        return _hats(m.t, every), False
    if variable == "late":
        return _hats(m.v, every), False
    return np.zeros((0, m.v.size)), True


def _response(forces: NDArray[np.float64], m: Motion) -> tuple[NDArray[np.float64], ...]:
    """First-order change of position and speed under small forces, a row a force."""
    dx, dv = np.zeros_like(forces), np.zeros_like(forces)
    slides = m.v != 0.0
    step = np.diff(m.t, append=m.t[-1:])
    last = np.diff(m.run, append=m.run[-1:] + 1) != 0
    decay = np.exp(-m.damping * step / m.mass)
    push = step / m.mass
    x = np.zeros(len(forces))
    v = np.zeros(len(forces))
    columns = np.ascontiguousarray(forces.T)
    out_x, out_v = np.zeros_like(columns), np.zeros_like(columns)
    for i in range(m.t.size - 1):
        out_x[i], out_v[i] = x, v
        if last[i]:
            x = np.zeros(len(forces))
            v = np.zeros(len(forces))
            continue
        if slides[i] or slides[i + 1]:
            after = v * decay[i] + columns[i] * push[i]
            x = x + 0.5 * (v + after) * step[i]
            v = after if slides[i + 1] else np.zeros(len(forces))
        else:
            v = np.zeros(len(forces))
    out_x[-1], out_v[-1] = x, v
    dx, dv = out_x.T, out_v.T
    return dx, dv


class Flexible:
    """Flexible terms of every variable beside one fit, to first order.

    The fit's own parameters are refitted beside them.
    """

    def __init__(self, problem: Problem, fit: Fit) -> None:
        motion = motion_of(problem, fit)
        self.residual = fit.residual
        self._places = [problem.of_run(r, problem.fitted) for r in problem.fitted]
        forces: list[tuple[str, NDArray[np.float64]]] = []
        readings: list[tuple[str, NDArray[np.float64]]] = []
        for variable in _ALL:
            terms, is_force = _terms(variable, motion)
            if len(terms):
                (forces if is_force else readings).append((variable, terms))
        rows: list[NDArray[np.float64]] = []
        names: list[str] = []
        if forces:
            dx, dv = _response(np.vstack([t for _, t in forces]), motion)
            rows.append(problem.whitened(dx, dv, fit.residual.size))
            names += [v for v, t in forces for _ in range(len(t))]
        if readings:
            dx = np.vstack([t for _, t in readings])
            rows.append(problem.whitened(dx, np.zeros_like(dx), fit.residual.size))
            names += [v for v, t in readings for _ in range(len(t))]
        if fit.theta.size:
            rows.append(jacobian_of(problem, fit))
            names += ["fit"] * fit.theta.size
        basis = np.vstack(rows) if rows else np.zeros((0, fit.residual.size))
        norm = np.sqrt((basis * basis).sum(axis=1))
        seen = norm > 1e-9
        self.basis = basis[seen] / norm[seen, None]
        self.names = np.array(names, dtype=object)[seen]
        self.gram = self.basis @ self.basis.T
        self.moments = self.basis @ fit.residual

    @property
    def variables(self) -> list[str]:
        """Variables that have terms along this motion."""
        return [v for v in _ALL if (self.names == v).any()]

    def solve(self, variables: Sequence[str]) -> tuple[float, int, NDArray[np.float64]]:
        """Fall of chi2 under terms of some variables, their number, and their sizes."""
        rows = np.flatnonzero(np.isin(self.names, ["fit", *variables]))
        if not rows.size:
            return 0.0, 0, np.zeros(0)
        values, vectors = np.linalg.eigh(self.gram[np.ix_(rows, rows)])
        keep = values > 1e-8 * values[-1]
        parts = (vectors[:, keep].T @ self.moments[rows]) / np.sqrt(values[keep])
        sizes = np.zeros(self.names.size)
        sizes[rows] = vectors[:, keep] @ (parts / np.sqrt(values[keep]))
        return float(parts @ parts), int(keep.sum()), sizes

    def worth(self, variables: Sequence[str], noise: float) -> float:
        """Fall of chi2 under terms of some variables, less twice their number."""
        fall, terms, _ = self.solve(variables)
        base, few, _ = self.solve([])
        return (fall - base) / noise - 2.0 * (terms - few)

    def left(self, variables: Sequence[str]) -> NDArray[np.float64]:
        """Return the residual beside terms of some variables."""
        sizes = self.solve(variables)[2]
        return self.residual - sizes @ self.basis if sizes.size else self.residual

    def foreseen(self, variables: Sequence[str], noise: float) -> float:
        """Share of what is left that terms of some variables also leave in each run unseen.

        Their sizes come from all other runs; 1 where there is but one run. What a term
        makes worse counts no more than twice.
        """
        rows = np.flatnonzero(np.isin(self.names, ["fit", *variables]))
        if len(self._places) < 2 or not rows.size:
            return 1.0
        before = after = 0.0
        for place in self._places:
            others = np.ones(self.residual.size, dtype=bool)
            others[place] = False
            basis = self.basis[rows]
            rest = basis[:, others]
            values, vectors = np.linalg.eigh(rest @ rest.T)
            keep = values > 1e-6 * values[-1]
            along = vectors[:, keep].T @ (rest @ self.residual[others])
            e = self.residual[place]
            e = e - (vectors[:, keep] @ (along / values[keep])) @ basis[:, place]
            old = float(self.residual[place] @ self.residual[place])
            before += old - noise * place.size
            after += min(float(e @ e), 2.0 * old) - noise * place.size
        return after / before if before > 0.0 else 1.0

    def found(self, beside: Sequence[str] = (), noise: float = 1.0) -> list[tuple[str, float]]:
        """Return the variables in which something is left, and the share of chi2 they carry.

        `noise` is the variance of the residuals that noise alone would have.
        """
        base, terms, _ = self.solve(beside)
        total = max(float(self.residual @ self.residual) - base, 1e-300)
        rows = []
        for variable in self.variables:
            if variable in beside:
                continue
            fall, more, _ = self.solve([*beside, variable])
            if more > terms:
                chance = chi2.sf((fall - base) / noise, more - terms) * len(self.variables)
                if chance < _SURE:
                    rows.append((variable, (fall - base) / total))
        return sorted(rows, key=lambda row: -row[1])
