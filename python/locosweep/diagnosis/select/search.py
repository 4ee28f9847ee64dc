"""The search for the effects that a gap needs: singles, pairs, triples."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.effects.catalogue import parameters_of, starts_of
from locosweep.diagnosis.estimate.least_squares import (
    Fit,
    Model,
    Nuisances,
    chi2_of,
    evaluate,
    fit_all,
    jacobian_of,
    start_fits,
)
from locosweep.diagnosis.estimate.nominal import fit_nominal
from locosweep.diagnosis.select.screen import SCALED, apart, best_pairs, hopeful, promising, scaled
from locosweep.diagnosis.select.whiteness import lack_of

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.effects.scale import Scale
    from locosweep.diagnosis.estimate.problem import Problem

__all__ = ["Search"]

_STARTS = 3
"""Starts of a model that are followed."""
_PARTNERS = 8
"""Further effects that are fitted beside those found, after the scan of all."""
_BEAM = 4
_ROWS = 24
"""Starts of a further effect beside others."""
_ROUGH = 0.5
"""Gain of a step below which a fit is left, unless it may tie with the best one."""
_CONTEST = 60.0
"""Scores this far from the best one may tie with it once both have all digits."""
_MUCH = 1.5
"""Chi2 of a fit over its expectation, beyond which it is tried from further places."""
_NEAR = 30.0
"""Fits that leave this many times more than the best are not worth leaps."""
_RIPPLES = ("position_dependent_friction",)
_SMALL = 1e-3
_AT_ONCE = 32
"""Ripples that are looked at side by side; their residuals are kept meanwhile."""
_DENSE = 161
"""Values of a parameter that no derivative sees."""
_LEAPS = tuple(sign * 0.5 * 0.7**k for k in range(27) for sign in (-1.0, 1.0))
"""Changes of one parameter that are tried, in units of its size."""
_TELLING = 2
"""Runs that starts are compared on: those that hold most of what a fit leaves."""
_BUDGET = 3.0
"""Replays beyond which one set of effects a level is extended, in those of the singles."""
_CLOSE = 8
"""Fits that are followed to their end whatever the best one reaches."""
_FIRST = 3
"""Fits that are followed to their end before others are given limits."""
_SLACK = 200.0
"""Scores further behind the best one than this, by what derivatives promise, are out of
reach of it also along a valley that bends."""
_MANY = 8
"""Pairs that are replayed for each that is fitted."""
_BETTERED = 1.5
"""What a set of effects may promise to leave, of what the best one of its size leaves."""
_HINT = 5.0
"""What a start has to promise to gain where the model beside it leaves only noise."""
PENALTY = 8.0
"""What a free parameter has to gain in chi2 before it counts."""


@dataclass
class Search:
    """Fits of sets of effects to one problem; remembers what it has fitted."""

    problem: Problem
    nuisances: Nuisances
    scale: Scale
    names: tuple[str, ...]
    report: Callable[[str], None]
    judges: bool = True
    """Whether the runs that fits do not see take part in the choice."""

    leaps: bool = True
    """Whether fits that leave much are tried from further places."""

    hints: Mapping[frozenset[str], Fit] = field(default_factory=dict)
    """Fits of the same sets to other runs: more places to start from."""

    def __post_init__(self) -> None:
        self.unseen: dict[int, tuple[Fit, float]] = {}
        self.fits: dict[frozenset[str], Fit] = {}
        self.spent = 0
        self.none = fit_nominal(self.problem, self.nuisances)
        self.fits[frozenset()] = self.none

    def model(self, names: Iterable[str]) -> Model:
        """Return a set of effects with its free parameters."""
        names = tuple(names)
        free = tuple(f for name in names for f in parameters_of(name, self.scale, names))
        return Model(names, free)

    def score(self, fit: Fit) -> float:
        """Chi2 with a price on every parameter that the data can see."""
        return fit.chi2 + PENALTY * self.seen(fit)

    def seen(self, fit: Fit) -> int:
        """Parameters that a large change would show."""
        return len(fit.model.free)

    @property
    def _steps(self) -> int:
        return 30 if self.nuisances.shares else 15

    def leaves_much(self, fit: Fit) -> bool:
        """Whether a fit leaves so much more than noise that a better one may be near."""
        return fit.chi2 > _MUCH * self.problem.degrees()

    def singles(self) -> list[Fit]:
        """Fit every effect alone, from several starts; best first."""
        found = self.extend(None, self.names, keep=len(self.names))
        self.spent = self.problem.replayed
        return found

    def leaped(self) -> list[Fit]:
        """Fit the effects alone again, from further places; best first."""
        found = sorted((self.fits[frozenset({name})] for name in self.names), key=chi2_of)
        self._leap([f for f in found if f.chi2 < _NEAR * found[0].chi2][:_CLOSE])
        self.spent = self.problem.replayed
        return sorted(found, key=chi2_of)

    def extend(
        self,
        base: Fit | None,
        partners: Sequence[str],
        keep: int = _PARTNERS,
        *,
        beat: bool = False,
    ) -> list[Fit]:
        """Fit `base` with each of `partners` beside it; only the `keep` best after a scan.

        With `beat`, only those that promise to come near the best set of as many effects.
        """
        held = base.model.names if base else ()
        partners = [p for p in partners if p not in held]
        fits: list[Fit] = []
        for name in partners:
            rows = starts_of(name, self.scale)
            if base is not None or name in _RIPPLES:
                rows = rows[:: -(-len(rows) // _ROWS)]
            if name in _RIPPLES:
                rows = np.vstack([self._ripples(base), rows])
            if base is not None:
                rows = np.hstack([np.tile(base.parameters, (len(rows), 1)), rows])
            model = self.model((*held, name))
            rows = np.vstack([*self._hinted(model), rows])
            fits.extend(start_fits(self.nuisances, model, rows))
            known = base or self.none
            nuisance = known.theta[len(known.model.free) :]
            if base is None and self.nuisances.shares:
                # The nominal model's shares may be bent to hide the gap.
                fits.extend(start_fits(self.nuisances, model, rows))
            for fit in fits[-len(rows) :]:
                fit.theta[fit.theta.size - nuisance.size :] = nuisance
        known = base or self.none
        telling = self._telling(known)
        reach, scales, worst = self._scan(fits, telling, known)
        quiet = self._is_noise(known)
        if quiet:
            fits = hopeful(fits, reach, worst - _HINT, every=base is None)
        fits.sort(key=lambda fit: (reach[id(fit)], fit.chi2))
        groups = [[f for f in fits if f.model.names[-1] == name] for name in partners]
        limit = self._to_beat(len(held) + 1, telling) if beat else np.inf
        groups = [g for g in groups if g and reach[id(g[0])] <= limit]
        groups.sort(key=lambda group: reach[id(group[0])])
        count = _STARTS if base is None else 2
        starts = []
        for group in groups[:keep]:
            many = group[0].model.names[-1] in _RIPPLES
            picked = apart(group, 3 * count if many else count)
            # As it stands, the best start; what promises most, as strong as it promises it.
            starts += [] if quiet else [min(group, key=chi2_of)]
            starts += [scaled(fit, scales[id(fit)]) for fit in picked]
        leaps = 0 if base is None else _CLOSE // 2
        return self._followed(starts, telling, leaps, quiet=quiet)

    def together(self, count: int) -> list[Fit]:
        """Fit the pairs whose two changes of the nominal motion, added up, promise most.

        Neither of them need stand out alone.
        """
        known, runs = self.none, self._telling(self.none)
        alone: list[Fit] = []
        for name in self.names:
            rows = starts_of(name, self.scale)
            fitted = self.fits.get(frozenset({name}))
            model = self.model((name,))
            rows = rows[:: -(-len(rows) // _ROWS)]
            rows = np.vstack([fitted.parameters, rows]) if fitted else rows
            alone += start_fits(self.nuisances, model, rows)
        nuisance = known.theta[len(known.model.free) :]
        for fit in alone:
            fit.theta[fit.theta.size - nuisance.size :] = nuisance
        same = Fit(known.model, known.nuisances, known.theta)
        evaluate(self.problem, [same], runs)
        free = np.nan_to_num(jacobian_of(self.problem, same, runs))
        changes = []
        for fit in alone:
            evaluate(self.problem, [fit], runs)
            changes.append(fit.residual - same.residual)
            fit.residual = np.zeros(0)
        starts = []
        for i, j, sizes in best_pairs(alone, np.array(changes), same.residual, free, _MANY * count):
            model = self.model((alone[i].model.names[0], alone[j].model.names[0]))
            for a, b in (sizes, (1.0, 1.0)):
                row = np.concatenate(
                    [scaled(alone[i], a).parameters, scaled(alone[j], b).parameters]
                )
                starts += start_fits(self.nuisances, model, row[None, :])
                starts[-1].theta[starts[-1].theta.size - nuisance.size :] = nuisance
        # What they leave, not what sums of small changes promise, says which are followed.
        self._scan(starts, runs, None)
        starts = sorted(starts, key=chi2_of)[:count]
        return self._followed(starts, runs, _CLOSE // 2, quiet=False)

    def follow(self, others: Sequence[Fit]) -> list[Fit]:
        """Fit from the values that fits to other runs, or to windows of these, came to."""
        starts = []
        for other in others:
            names = other.model.names
            start = start_fits(self.nuisances, self.model(names), other.parameters[None, :])[0]
            first, count = len(other.model.free), len(self.nuisances.shares)
            start.theta[first : first + count] = other.theta[first : first + count]
            starts.append(start)
        return self._followed(starts, self._telling(self.none), _CLOSE // 2, quiet=False)

    def _followed(
        self, starts: list[Fit], telling: list[int], leaps: int, *, quiet: bool
    ) -> list[Fit]:
        """Fit from starts, those that may come near the best to their end; best first."""
        if not quiet:
            # The first steps from poor starts need not see all runs.
            evaluate(self.problem, starts, telling)
            fit_all(self.problem, starts, runs=telling, steps=3)
            starts = promising(starts)
        evaluate(self.problem, starts)
        self._limit(starts, quiet=quiet)
        fit_all(self.problem, starts, steps=3 if quiet else 1)
        best = promising(starts)
        least = min((f.chi2 for f in best), default=np.inf)
        order = sorted(best, key=chi2_of)
        # Those that are far behind stay as they are.
        close = [f for i, f in enumerate(order) if i < _CLOSE or f.chi2 < 10.0 * least]
        steps = self._steps
        fit_all(self.problem, close[:_FIRST], steps=steps)
        self._limit(close[_FIRST:], close[:_FIRST], quiet=quiet)
        fit_all(self.problem, close[_FIRST:], steps=steps, tolerance=_ROUGH)
        # Only those that may tie are worth all digits.
        least = min((self.score(f) for f in close), default=np.inf)
        ties = [f for f in close if self.score(f) < least + _CONTEST]
        fit_all(self.problem, ties, steps=steps)
        close.sort(key=chi2_of)
        self._leap([f for f in close if f.chi2 < _NEAR * close[0].chi2][:leaps])
        found: dict[frozenset[str], Fit] = {}
        for fit in best:
            key = frozenset(fit.model.names)
            if key not in found or fit.chi2 < found[key].chi2:
                found[key] = fit
            if key not in self.fits or fit.chi2 < self.fits[key].chi2:
                self.fits[key] = fit
        return sorted((self.fits[key] for key in found), key=chi2_of)

    def _hinted(self, model: Model) -> list[NDArray[np.float64]]:
        """Return the parameters of a set as other runs have them, if any."""
        hint = self.hints.get(frozenset(model.names))
        if hint is None:
            return []
        values = dict(
            zip(((f.effect, f.name) for f in hint.model.free), hint.parameters, strict=True)
        )
        return [np.array([values[f.effect, f.name] for f in model.free])]

    def _to_beat(self, count: int, runs: list[int]) -> float:
        """Chi2 on some runs that a further set of so many effects has to promise."""
        known = [fit for names, fit in self.fits.items() if len(names) == count]
        if count == 1 or not known:
            return np.inf
        best = min(known, key=chi2_of)
        same = Fit(best.model, best.nuisances, best.theta)
        evaluate(self.problem, [same], runs)
        return _BETTERED * same.chi2 + _SLACK

    def _limit(self, fits: Sequence[Fit], others: Sequence[Fit] = (), *, quiet: bool) -> None:
        """Set what fits have to come to, where some fit leaves hardly more than noise.

        Beside a fit that is `quiet` itself nothing ties: a further effect has to gain.
        """
        best = min([*self.fits.values(), *others], key=self.score)
        if not self._is_noise(best):
            return
        most = self.score(best) + (0.0 if quiet else _SLACK)
        for fit in fits:
            fit.limit = most - PENALTY * self.seen(fit)

    def _is_noise(self, fit: Fit) -> bool:
        """Whether a fit leaves nothing that noise would not."""
        if not fit.residual.size:
            evaluate(self.problem, [fit])
        return not lack_of(self.problem, fit.residual).is_there

    def _ripples(self, base: Fit | None) -> NDArray[np.float64]:
        """Periods, amplitudes and phases of friction along the track, best first.

        A small ripple acts in proportion: for every period two of them, a quarter
        apart, give the best amplitude and phase.
        """
        known = base or self.none
        name = _RIPPLES[0]
        periods = np.geomspace(0.03, 4.0, 48) * self.scale.travel
        rows = [[_SMALL, period, phase] for period in periods for phase in (0.0, np.pi / 2)]
        held = known.parameters
        model = self.model((*known.model.names, name))
        fits = start_fits(self.nuisances, model,
            np.hstack([np.tile(held, (len(rows), 1)), np.array(rows)]),
        )  # fmt: skip
        nuisance = known.theta[len(known.model.free) :]
        for fit in fits:
            fit.theta[fit.theta.size - nuisance.size :] = nuisance
        evaluate(self.problem, [known])
        found = []
        for i in range(0, len(fits), _AT_ONCE):
            some = fits[i : i + _AT_ONCE]
            evaluate(self.problem, some)
            columns = np.array([(f.residual - known.residual) / _SMALL for f in some])
            for j, period in enumerate(periods[i // 2 : (i + len(some)) // 2]):
                pair = columns[2 * j : 2 * j + 2]
                normal = pair @ pair.T + 1e-12 * np.eye(2)
                sine, cosine = -np.linalg.solve(normal, pair @ known.residual)
                left = known.residual + sine * pair[0] + cosine * pair[1]
                size = float(np.hypot(sine, cosine))
                row = [min(size, 0.5), period, float(np.arctan2(cosine, sine))]
                found.append((float(left @ left), row))
            for fit in some:
                fit.residual = np.zeros(0)
        found.sort(key=lambda pair: pair[0])
        return np.array([row for _, row in found[:6]])

    def _leap(self, fits: list[Fit]) -> None:
        """Try large changes of one parameter at a time, and fit again from better places.

        Thresholds act in jumps of whole samples and periods have many valleys:
        derivatives do not see beyond them.
        """
        for _ in range(2):
            todo = [f for f in fits if self.leaves_much(f) and f.model.free]
            if not todo or not self.leaps:
                return
            # The first of each is the fit itself, seen on the same runs.
            tried = [
                [Fit(fit.model, fit.nuisances, fit.theta), *self._leaps_of(fit)] for fit in todo
            ]
            runs = self._telling(todo[0])
            self._scan([trial for trials in tried for trial in trials], runs, None)
            follow = []
            for fit, (same, *trials) in zip(todo, tried, strict=True):
                best = sorted(trials, key=chi2_of)[: 1 if len(trials) < _DENSE else 6]
                follow += [(fit, t) for t in best if t.chi2 < 0.98 * same.chi2 or len(best) > 1]
            if not follow:
                return
            fit_all(self.problem, [trial for _, trial in follow], steps=self._steps)
            for fit, trial in follow:
                if trial.chi2 < fit.chi2:
                    fit.theta, fit.residual, fit.chi2 = trial.theta, trial.residual, trial.chi2
                    fit.covariance = trial.covariance

    def _leaps_of(self, fit: Fit) -> list[Fit]:
        trials = []
        for i, free in enumerate(fit.model.free):
            low, high = (np.log(v) if free.log else v for v in (free.low, free.high))
            unit = 1.0 if free.log else free.size
            known = fit.covariance.size and fit.covariance[i, i] < 1e4 * unit**2
            # What derivatives do not see at all is looked for on a dense grid.
            leaps = _LEAPS if known else np.linspace(-0.4, 0.4, _DENSE)
            for leap in leaps:
                theta = fit.theta.copy()
                theta[i] = np.clip(theta[i] + leap * unit, low, high)
                trials.append(Fit(fit.model, fit.nuisances, theta))
        for i in range(len(fit.model.free) + len(fit.nuisances.shares), fit.theta.size):
            # A run's start that another model's fit has bent may lie in a valley of its own.
            theta = fit.theta.copy()
            theta[i] = 0.0
            trials.append(Fit(fit.model, fit.nuisances, theta))
        return trials

    def _telling(self, fit: Fit) -> list[int]:
        """Return the fitted runs that hold most of what a fit leaves."""
        problem = self.problem
        if not fit.residual.size:
            evaluate(problem, [fit])
        chosen = problem.fitted
        left = [
            float(np.square(fit.residual[problem.of_run(r, chosen)]).sum() / problem.lengths[r])
            for r in chosen
        ]
        order = np.argsort(-np.array(left), kind="stable")
        return sorted(chosen[i] for i in order[:_TELLING])

    def _scan(
        self, fits: list[Fit], runs: list[int], beside: Fit | None
    ) -> tuple[dict[int, float], dict[int, float], float]:
        """Chi2 of many starts on some runs, without keeping their residuals.

        With `beside`, returns what chi2 each may come to if the change that it makes to
        the residuals of that fit is scaled and all else refitted, by how much that is,
        and that fit's own.
        """
        reach: dict[int, float] = {}
        scales: dict[int, float] = {}
        known = Fit(beside.model, beside.nuisances, beside.theta) if beside else None
        if known:
            evaluate(self.problem, [known], runs)
            free = np.nan_to_num(jacobian_of(self.problem, known, runs))
            basis = np.linalg.qr(free.T)[0]
        for i in range(0, len(fits), 200):
            evaluate(self.problem, fits[i : i + 200], runs)
            for fit in fits[i : i + 200]:
                if known:
                    change = fit.residual - known.residual
                    change -= basis @ (basis.T @ change)
                    size, along = float(change @ change), -float(change @ known.residual)
                    scale = np.clip(along / size, -SCALED, SCALED) if size > 0.0 else 0.0
                    best = known.chi2 - scale * (2.0 * along - scale * size)
                    reach[id(fit)] = min(fit.chi2, best) if np.isfinite(best) else fit.chi2
                    scales[id(fit)] = float(scale) if np.isfinite(best) else 1.0
                fit.residual = np.zeros(0)
        return reach, scales, known.chi2 if known else np.inf

    def deepen(self, fits: Sequence[Fit], beam: int = _BEAM) -> list[Fit]:
        """Add one effect to each of the best fits."""
        found: dict[frozenset[str], Fit] = {}
        for i, base in enumerate(list(fits)[:beam]):
            if i and self.problem.replayed > _BUDGET * self.spent:
                break
            for fit in self.extend(base, self.names, beat=True):
                found[frozenset(fit.model.names)] = fit
        return sorted(found.values(), key=chi2_of)
