"""Forward steps of a search: single effects, one more beside those found, pairs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.effects.catalogue import starts_of
from locosweep.diagnosis.estimate.least_squares import (
    Fit,
    chi2_of,
    evaluate,
    jacobian_of,
    start_fits,
)
from locosweep.diagnosis.select.descent import CLOSE, FAR_BEHIND, SLACK, descend, jump
from locosweep.diagnosis.select.screen import (
    below_limit,
    cancelling_pairs,
    distinct,
    informative_runs,
    scaled,
    scan,
    scan_beside,
)
from locosweep.diagnosis.select.search import Collection, Found

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.estimate.least_squares import Model
    from locosweep.diagnosis.select.search import Search

    Floats = NDArray[np.float64]

_STARTS = 3
"""Starts of a single effect that are followed."""
_STARTS_BESIDE = 2
"""Starts of a further effect that are followed."""
_PARTNERS = 8
"""Further effects that are fitted beside those found, after the scan of all."""
_ROWS = 24
"""Starts of a further effect beside others."""
_BUDGET = 3.0
"""Replays beyond which one set of effects a level is extended, in those of the singles."""
_PAIRS_SCANNED = 8
"""Pairs that are replayed for each that is fitted."""
_BETTERED = 1.5
"""Chi2 that a set of effects may promise, over that of the best one of its size."""
_HINT = 5.0
"""Gain in chi2 that a start has to promise beside a model that leaves only noise."""
_RIPPLE = "position_dependent_friction"
"""The effect whose starts are found by a scan of periods."""
_SMALL = 1e-3
"""Amplitude at which a ripple acts in proportion."""
_RIPPLES_AT_ONCE = 32
"""Ripples that are looked at side by side; their residuals are kept meanwhile."""


def singles(search: Search) -> Collection:
    """Fit every effect alone, from several starts."""
    known = Collection({frozenset(): search.none})
    known = known.adding(extend(search, known, None, search.names, keep=len(search.names)))
    return Collection(known.fits, search.problem.meter.samples)


def retried_singles(search: Search, known: Collection) -> Collection:
    """Fit the effects alone again, from further values."""
    found = sorted((known.fits[frozenset({name})] for name in search.names), key=chi2_of)
    some = [f for f in found if f.chi2 < FAR_BEHIND * found[0].chi2][:CLOSE]
    better = {frozenset(fit.model.names): fit for fit in jump(search, some)}
    return Collection(known.adding(better).fits, search.problem.meter.samples)


def extend(
    search: Search,
    known: Collection,
    base: Fit | None,
    partners: Sequence[str],
    keep: int = _PARTNERS,
    *,
    beat: bool = False,
) -> Found:
    """Fit `base` with each of `partners` beside it; only the `keep` best after a scan.

    Without a base, effects are fitted alone. With `beat`, only those are fitted that promise to
    come near the best set of as many effects. Returns the best fit of each set.
    """
    problem = search.problem
    held = base.model.names if base else ()
    partners = [p for p in partners if p not in held]
    beside = base or search.none
    if _RIPPLE in partners or not beside.residual.size:
        (beside,) = evaluate(problem, [beside])
    starts: list[Fit] = []
    for name in partners:
        starts += _starts_beside(search, name, base, beside)
    runs = informative_runs(problem, beside)
    seen, leaves = scan_beside(problem, starts, runs, beside)
    at_noise = search.is_noise(beside)
    if at_noise:
        seen = below_limit(seen, leaves - _HINT, every=base is None)
    seen.sort(key=lambda start: (start.promised, start.fit.chi2))
    groups = [[s for s in seen if s.fit.model.names[-1] == name] for name in partners]
    limit = _to_beat(search, known, len(held) + 1, runs) if beat else np.inf
    groups = [g for g in groups if g and g[0].promised <= limit]
    groups.sort(key=lambda group: group[0].promised)
    followed = []
    for group in groups[:keep]:
        count = _STARTS if base is None else _STARTS_BESIDE
        # Periods have many valleys.
        count *= 3 if group[0].fit.model.names[-1] == _RIPPLE else 1
        # As it stands, the best start; what promises most, as strong as it promises it.
        followed += [] if at_noise else [min((s.fit for s in group), key=chi2_of)]
        followed += [scaled(s.fit, s.factor) for s in distinct(group, count)]
    jumps = 0 if base is None else CLOSE // 2
    return descend(search, known, followed, runs, jumps, at_noise=at_noise)


def _starts_beside(search: Search, name: str, base: Fit | None, beside: Fit) -> list[Fit]:
    """Return starts of an effect beside the values of a fit."""
    rows = starts_of(name, search.scale)
    if base is not None or name == _RIPPLE:
        rows = _thinned(rows)
    if name == _RIPPLE:
        rows = np.vstack([_ripples(search, beside), rows])
    if base is not None:
        rows = np.hstack([np.tile(base.parameters, (len(rows), 1)), rows])
    model = search.model((*beside.model.names, name))
    rows = np.vstack([*search.hinted(model), rows])
    starts = start_fits(search.nuisances, model, rows, beside.nuisance)
    if base is None and search.nuisances.uncertain:
        # The nominal model's uncertain values may be fitted to the gap.
        return [*start_fits(search.nuisances, model, rows), *starts]
    return starts


def _thinned(rows: Floats) -> Floats:
    return rows[:: -(-len(rows) // _ROWS)]


def _ripples(search: Search, beside: Fit) -> Floats:
    """Periods, amplitudes and phases of friction along the track, best first.

    Two small ripples of a period, a quarter apart, give the best amplitude and phase.
    """
    periods = np.geomspace(0.03, 4.0, 48) * search.scale.travel
    rows = [[_SMALL, period, phase] for period in periods for phase in (0.0, np.pi / 2)]
    model = search.model((*beside.model.names, _RIPPLE))
    values = np.hstack([np.tile(beside.parameters, (len(rows), 1)), np.array(rows)])
    fits = start_fits(search.nuisances, model, values, beside.nuisance)
    found = []
    for i in range(0, len(fits), _RIPPLES_AT_ONCE):
        some = evaluate(search.problem, fits[i : i + _RIPPLES_AT_ONCE])
        columns = np.array([(f.residual - beside.residual) / _SMALL for f in some])
        for j, period in enumerate(periods[i // 2 : (i + len(some)) // 2]):
            pair = columns[2 * j : 2 * j + 2]
            normal = pair @ pair.T + 1e-12 * np.eye(2)
            sine, cosine = -np.linalg.solve(normal, pair @ beside.residual)
            left = beside.residual + sine * pair[0] + cosine * pair[1]
            size = float(np.hypot(sine, cosine))
            row = [min(size, 0.5), period, float(np.arctan2(cosine, sine))]
            found.append((float(left @ left), row))
    found.sort(key=lambda pair: pair[0])
    return np.array([row for _, row in found[:6]])


def _to_beat(search: Search, known: Collection, count: int, runs: list[int]) -> float:
    """Chi2 on some runs that a further set of so many effects has to promise."""
    alike = [fit for names, fit in known.fits.items() if len(names) == count]
    if count == 1 or not alike:
        return np.inf
    (same,) = evaluate(search.problem, [min(alike, key=chi2_of).unfitted()], runs)
    return _BETTERED * same.chi2 + SLACK


def extend_each(search: Search, known: Collection, bases: Sequence[Fit]) -> Found:
    """Add one effect to each of some fits, while the replay budget lasts."""
    found: Found = {}
    for i, base in enumerate(bases):
        if i and not known.within(_BUDGET, search.problem):
            break
        found |= extend(search, known.adding(found), base, search.names, beat=True)
    return found


def pairs(search: Search, known: Collection, count: int) -> Found:
    """Fit the pairs whose two changes of the nominal motion, added up, promise most."""
    none, problem = search.none, search.problem
    runs = informative_runs(problem, none)
    alone: list[Fit] = []
    for name in search.names:
        rows = _thinned(starts_of(name, search.scale))
        fitted = known.single(name)
        rows = np.vstack([fitted.parameters, rows]) if fitted else rows
        alone += start_fits(search.nuisances, search.model((name,)), rows, none.nuisance)
    (same,) = evaluate(problem, [none.unfitted()], runs)
    free = np.nan_to_num(jacobian_of(problem, same, runs))
    changes = [evaluate(problem, [fit], runs)[0].residual - same.residual for fit in alone]
    best = cancelling_pairs(alone, np.array(changes), same.residual, free, _PAIRS_SCANNED * count)
    starts = []
    for i, j, sizes in best:
        model = search.model((alone[i].model.names[0], alone[j].model.names[0]))
        for a, b in (sizes, (1.0, 1.0)):
            row = np.concatenate([scaled(alone[i], a).parameters, scaled(alone[j], b).parameters])
            starts += start_fits(search.nuisances, model, row[None, :], none.nuisance)
    # Replays decide which are followed, not sums of small changes.
    starts = sorted((s.fit for s in scan(problem, starts, runs)), key=chi2_of)[:count]
    return descend(search, known, starts, runs, CLOSE // 2)


def refit_from(search: Search, known: Collection, others: Sequence[Fit]) -> Found:
    """Fit from the values that fits to other runs, or to windows of these, came to."""
    nuisances = search.nuisances
    starts = []
    for other in others:
        nuisance = np.zeros(search.none.nuisance.size)
        count = len(nuisances.uncertain)
        nuisance[:count] = other.nuisance[:count]
        model: Model = search.model(other.model.names)
        starts += start_fits(nuisances, model, other.parameters[None, :], nuisance)
    runs = informative_runs(search.problem, search.none)
    return descend(search, known, starts, runs, CLOSE // 2)
