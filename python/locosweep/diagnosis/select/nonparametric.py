"""Nonparametric correction: a Gaussian process in one regressor, beside a fitted law.

A force (or a shift of the reading) that is any smooth function of one variable is added to
the fitted motion, to first order: it moves the head only while it slides. Log Bayes factors
are given on the scale of chi2: twice the natural logarithm.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import block_diag
from scipy.special import chdtrc

from locosweep.diagnosis.effects.catalogue import own_variables
from locosweep.diagnosis.estimate.least_squares import jacobian_of
from locosweep.diagnosis.estimate.motion import ALL, motion_of, terms_of
from locosweep.diagnosis.estimate.slides import corrected, corrections
from locosweep.diagnosis.select.prediction import over_deviations
from locosweep.diagnosis.select.thresholds import SIGNIFICANCE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Fit
    from locosweep.diagnosis.estimate.problem import Problem

    Floats = NDArray[np.float64]

_SMOOTH = 2.0
"""Length scale of the process in knots: laws bend, they do not jump."""
_FREE = 1e-8
"""Prior precision of a fitted parameter's size: as good as none."""


class NonparametricCorrection:
    """Corrections of one fit in every variable; its parameters are refitted beside them."""

    def __init__(self, problem: Problem, fit: Fit) -> None:
        motion = motion_of(problem, fit)
        self.residual = fit.residual
        self._samples = [problem.of_run(r, problem.fitted) for r in problem.fitted]
        forces: list[tuple[str, Floats]] = []
        readings: list[tuple[str, Floats]] = []
        for variable in dict.fromkeys((*ALL, *own_variables(fit.model.names))):
            groups, is_force = terms_of(variable, motion)
            kind = forces if is_force else readings
            kind += [(variable, terms) for terms in groups if len(terms)]
        laws = [*forces, *readings]
        names = [v for v, t in laws for _ in range(len(t))]
        knots = [(i, float(k)) for i, (_, t) in enumerate(laws) for k in range(len(t))]
        # At its bound, a parameter cannot make room for a correction.
        inside = fit.inside
        names += ["fit"] * int(inside.sum())
        knots += [(len(laws), 0.0)] * int(inside.sum())
        basis = np.zeros((len(names), fit.residual.size))
        at = 0
        for kind, slides in ((forces, motion.slides), (readings, None)):
            terms = [own for _, own in kind]
            end = at + sum(map(len, terms))
            corrections(problem, terms, slides, basis[at:end])
            at = end
        if inside.any():
            basis[at:] = jacobian_of(problem, fit)[inside]
        gram, moments = _products(basis, at, fit.residual, corrected(problem))
        norm = np.sqrt(np.diag(gram))
        seen = np.flatnonzero(norm > 1e-9)
        self._basis, self._places, self._norm = basis, seen, norm[seen]
        owners = [f.effect for f in fit.model.free]
        owners += [""] * (fit.theta.size - len(owners))
        owned = ["" for name in names if name != "fit"]
        owned += [owner for owner, free in zip(owners, inside, strict=True) if free]
        self._owners = np.array(owned, dtype=object)[seen]
        law, knot = np.array(knots).reshape(-1, 2)[seen].T
        sizes = np.outer(self._norm, self._norm)
        correlation = np.exp(-0.5 * np.square((knot[:, None] - knot) / _SMOOTH))
        self.covariance = sizes * correlation * (law[:, None] == law)
        self.names = np.array(names, dtype=object)[seen]
        self.gram = gram[np.ix_(seen, seen)] / sizes
        self.moments = moments[seen] / self._norm

    def sizes_beside(self, variable: str, noise: float, effect: str) -> tuple[Floats, Floats]:
        """Return the likeliest sizes of a correction's terms, and their deviations.

        All parameters of the fit are refitted beside it but those of `effect`.
        """
        terms, root = self._covariance_root([variable], noise)
        if not root.any():
            return np.zeros(terms.size), np.zeros(terms.size)
        beside = np.flatnonzero((self.names == "fit") & (self._owners != effect))
        rows = np.concatenate([terms, beside])
        price = np.full(rows.size, _FREE)
        price[: terms.size] = 0.0
        known = self.gram[np.ix_(rows, rows)] / noise + np.diag(price)
        known[: terms.size, : terms.size] += np.linalg.inv(root @ root.T)
        covariance = np.linalg.inv(known)[: terms.size]
        sizes = covariance @ self.moments[rows] / noise
        deviations = np.sqrt(np.diag(covariance))
        return sizes / self._norm[terms], deviations / self._norm[terms]

    def unit_rows(self, terms: NDArray[np.intp], samples: NDArray[np.intp] | None = None) -> Floats:
        """Return the rows of some terms as unit vectors, at some samples."""
        places = self._places[terms]
        rows = self._basis[places] if samples is None else self._basis[np.ix_(places, samples)]
        found: Floats = rows / self._norm[terms, None]
        return found

    @property
    def variables(self) -> list[str]:
        """Variables that have terms along this motion."""
        return [v for v in dict.fromkeys(self.names.tolist()) if v != "fit"]

    def solve(self, variables: Sequence[str]) -> tuple[float, int, Floats]:
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

    def log_bayes_factor(self, variables: Sequence[str], noise: float) -> float:
        """Return the log Bayes factor of a correction in some variables, on the scale of chi2.

        The correction is a Gaussian process around 0 with its likeliest deviation; `noise` is the
        variance of the residuals under noise alone.
        """
        return self._likeliest_deviation(*self._covariance_root(variables, noise), noise)[1]

    def _covariance_root(
        self, variables: Sequence[str], noise: float
    ) -> tuple[NDArray[np.intp], Floats]:
        """Return the rows of some variables' terms and a root of their sizes' covariance."""
        rows = np.flatnonzero(np.isin(self.names, list(variables)))
        root = np.zeros((rows.size, rows.size))
        for variable in dict.fromkeys(variables):
            own = np.flatnonzero(self.names[rows] == variable)
            if own.size:
                alike = self.covariance[np.ix_(rows[own], rows[own])]
                part = np.linalg.cholesky(alike + 1e-9 * np.diag(np.diag(alike)))
                factor = self._likeliest_deviation(rows[own], part, noise)[0]
                root[np.ix_(own, own)] = factor * part
        return rows, root

    def _likeliest_deviation(
        self, rows: NDArray[np.intp], root: Floats, noise: float
    ) -> tuple[float, float]:
        """Return the factor on deviations that is likeliest, and its log Bayes factor."""
        if not rows.size:
            return 0.0, 0.0
        beside = np.flatnonzero(self.names == "fit")
        gram, moments = self.gram[np.ix_(rows, rows)], self.moments[rows]
        if beside.size:
            values, vectors = np.linalg.eigh(self.gram[np.ix_(beside, beside)])
            keep = values > 1e-8 * values[-1]
            along = (vectors[:, keep] / np.sqrt(values[keep])).T
            shared = along @ self.gram[np.ix_(beside, rows)]
            gram = gram - shared.T @ shared
            moments = moments - shared.T @ (along @ self.moments[beside])
        return likeliest(root.T @ gram @ root / noise, root.T @ moments / noise)

    def log_bayes_factor_by_run(self, variables: Sequence[str], noise: float) -> float:
        """Return the log Bayes factor of a correction of its own in every run, all as smooth.

        A law that all runs share has a larger factor: it pays once for what every run says again.
        """
        rows, root = self._covariance_root(variables, noise)
        if not rows.size:
            return 0.0
        fitted = np.linalg.qr(self.unit_rows(np.flatnonzero(self.names == "fit")).T)[0]
        grams, shared, moments = [], [], []
        for samples in self._samples:
            terms = root.T @ self.unit_rows(rows, samples)
            grams.append(terms @ terms.T)
            shared.append(terms @ fitted[samples])
            moments.append(terms @ self.residual[samples])
        beside = np.vstack(shared)
        gram = block_diag(*grams) - beside @ beside.T
        moment = np.concatenate(moments) - beside @ (fitted.T @ self.residual)
        return likeliest(gram / noise, moment / noise)[1]

    def corrected_residual(self, variables: Sequence[str]) -> Floats:
        """Return the residual less the fitted correction in some variables."""
        sizes = self.solve(variables)[2]
        if not sizes.size:
            return self.residual
        every = np.zeros(len(self._basis))
        every[self._places] = sizes / self._norm
        return self.residual - every @ self._basis

    def predictive_gain(self, variables: Sequence[str], noise: float) -> float:
        """Return the leave-one-run-out predictive gain of a correction, on the scale of chi2.

        Twice the difference in the log density of a run's residual, given all others, with the
        correction and without, summed over the runs; 0 where there is but one.
        """
        every, price, count = self._with_terms(variables, noise)
        if len(self._samples) < 2 or not every[count:].any():
            return 0.0
        gram, moments = every @ every.T, every @ self.residual
        found = 0.0
        for samples in self._samples:
            here, e = every[:, samples], self.residual[samples]
            own = here @ here.T
            for k, sign in ((count, 1.0), (len(every), -1.0)):
                others = gram[:k, :k] - own[:k, :k], moments[:k] - here[:k] @ e
                found += sign * _negative_log_density(
                    e, here[:k], own[:k, :k], others, price[:k], noise
                )
        return found

    def _with_terms(self, variables: Sequence[str], noise: float) -> tuple[Floats, Floats, int]:
        """Return the fit's rows above those of terms, their prior precisions, and their number."""
        terms, root = self._covariance_root(variables, noise)
        beside = self.unit_rows(np.flatnonzero(self.names == "fit"))
        price = np.concatenate([np.full(len(beside), _FREE), np.ones(terms.size)])
        return np.vstack([beside, root.T @ self.unit_rows(terms)]), price, len(beside)

    def prediction_errors(self, variables: Sequence[str], noise: float) -> list[Floats]:
        """Return the leave-one-run-out standardised prediction error of each run.

        It is divided by its uncertainty: a law that only this run shows is no surprise.
        """
        basis, price, _ = self._with_terms(variables, noise)
        whole = basis @ basis.T / noise + np.diag(price)
        moments = basis @ self.residual / noise
        left = []
        for samples in self._samples:
            here, e = basis[:, samples], self.residual[samples]
            known = whole - here @ here.T / noise
            sizes = np.linalg.solve(known, moments - here @ e / noise)
            e = e - sizes @ here
            unsure = np.linalg.solve(np.linalg.cholesky(known), here) / np.sqrt(noise)
            left.append(over_deviations(e, unsure))
        return left

    def significant(
        self, beside: Sequence[str] = (), noise: float = 1.0
    ) -> list[tuple[str, float]]:
        """Return the variables of significant corrections, with their shares of chi2."""
        base, terms, _ = self.solve(beside)
        total = max(float(self.residual @ self.residual) - base, 1e-300)
        rows = []
        for variable in self.variables:
            if variable in beside:
                continue
            fall, more, _ = self.solve([*beside, variable])
            if more > terms:
                chance = float(chdtrc(more - terms, (fall - base) / noise)) * len(self.variables)
                if chance < SIGNIFICANCE:
                    rows.append((variable, (fall - base) / total))
        return sorted(rows, key=lambda row: -row[1])


def _products(
    basis: Floats, count: int, residual: Floats, corrected: Sequence[slice]
) -> tuple[Floats, Floats]:
    """Return products of rows with each other, and with a residual.

    The first `count` rows are 0 but where they are `corrected`.
    """
    terms, beside = basis[:count], basis[count:]
    gram, moments = np.zeros((len(basis), len(basis))), np.zeros(len(basis))
    for own in corrected:
        gram[:count, :count] += terms[:, own] @ terms[:, own].T
        gram[count:, :count] += beside[:, own] @ terms[:, own].T
        moments[:count] += terms[:, own] @ residual[own]
    gram[:count, count:] = gram[count:, :count].T
    gram[count:, count:] = beside @ beside.T
    moments[count:] = beside @ residual
    return gram, moments


def _negative_log_density(
    e: Floats,
    here: Floats,
    own: Floats,
    others: tuple[Floats, Floats],
    price: Floats,
    noise: float,
) -> float:
    """Return minus twice the log density of one run's residual `e`, given the others.

    `here` are the terms in this run, `own` their products; `others` the products of the terms,
    and their moments, in all other runs.
    """
    if not len(here):
        return float(e @ e) / noise
    known = others[0] / noise + np.diag(price)
    both = known + own / noise
    e = e - np.linalg.solve(known, others[1] / noise) @ here
    along = here @ e / noise
    square = float(e @ e) / noise - float(along @ np.linalg.solve(both, along))
    return square + float(np.linalg.slogdet(both)[1] - np.linalg.slogdet(known)[1])


def likeliest(gram: Floats, moments: Floats) -> tuple[float, float]:
    """Return the likeliest factor on terms' deviations and its log Bayes factor, as a chi2."""
    values, vectors = np.linalg.eigh(gram)
    keep = values > 1e-8 * max(values[-1], 1e-300)
    values, vectors = values[keep], vectors[:, keep]
    if not values.size:
        return 0.0, 0.0
    squares = (vectors.T @ moments) ** 2 / values
    factors = np.geomspace(1e-2, 1e6, 121) / np.sqrt(values[-1])
    signal = np.square(factors)[:, None] * values
    log_factors = (squares * signal / (1.0 + signal) - np.log1p(signal)).sum(axis=1)
    best = int(np.argmax(log_factors))
    return float(factors[best]), float(log_factors[best])
