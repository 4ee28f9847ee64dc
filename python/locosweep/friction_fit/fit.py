"""Fit of friction laws to measured motion and force, with uncertainty."""

from __future__ import annotations

import os
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from locosweep import _core
from locosweep.engine import whole
from locosweep.errors import InputError
from locosweep.files.columns import checksum
from locosweep.files.csv_form import CsvForm
from locosweep.friction_fit.data import read_friction
from locosweep.friction_fit.prepare import Prepared, fitted_only, prepare
from locosweep.friction_fit.result import FittedLaw, FittedParameter, FrictionFit
from locosweep.friction_fit.verdict import (
    choose,
    explained_share,
    left_over,
    remarks_on,
    schwarz,
    summary_of,
)
from locosweep.progress import progress_of
from locosweep.registry import laws as all_laws
from locosweep.registry import unknown

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterable, Mapping, Sequence

    import polars as pl

    from locosweep._core import CancelToken, FrictionOutcome
    from locosweep.progress import Progress

_SCOUTS = ("coulomb", "coulomb_viscous", "stribeck")
"""Laws that decide how load and sensor enter, before the others are fitted."""

_SCOUTED_ROWS = 600
"""Samples that these laws are compared at."""

_CONFIDENCE = 0.95

_MOST_EXPONENT = 300.0
"""Exponent beyond which an interval of a logarithm is no number any more."""

_NOTHING_LEFT = 1.1
"""Residual over noise up to which laws without bristles suffice, so that none with are fitted."""


def fit_friction(
    data: str | os.PathLike[str] | pl.DataFrame | Mapping[str, object],
    *,
    mass: float | None = None,
    holdout: Collection[str] = (),
    laws: Iterable[str] | None = None,
    runs: Collection[str] | None = None,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    separator: str | None = None,
    decimal: str | None = None,
    seed: int = 0,
    threads: int | None = None,
    progress: bool | Progress | None = None,
    token: CancelToken | None = None,
) -> FrictionFit:
    """Fit friction laws to measured motion and friction force, and choose one.

    Parameters
    ----------
    data : path-like, polars.DataFrame or mapping of arrays
        One row a sample, columns ``t`` [s], ``x`` [m] or ``v`` [m/s], ``force``
        (friction force [N], with the sign of the motion) or ``drive`` [N], and
        optionally ``run`` and ``load`` [N].
    mass : float, optional
        Moving mass in kg. Friction is then ``drive`` less mass times acceleration
        where there is no ``force``, and levels are coefficients of the weight.
    holdout : collection of str
        Runs on which laws are compared and that nothing is fitted to. By default
        every run in turn; with one or two runs parts of them in turn.
    laws : iterable of str, optional
        Names of laws; all of the registry by default.
    runs : collection of str, optional
        Labels of the runs to use; all by default.
    columns, units : mapping of str to str, optional
        Their name of a column by ours; unit of a column (SI where not given).
    separator, decimal : str, optional
        Of a CSV file, where its text leaves them open: ``"semicolon"``, ``"comma"``.
    seed : int
        Of the samples that pictures show; no fit depends on it.
    threads : int, optional
        All processors by default. The result does not depend on it.
    progress : bool or callable, optional
        As in `sweep`; it counts fits, of simple laws first and then of all.
    token : CancelToken, optional
        Stops the fits from another thread.

    Returns
    -------
    FrictionFit

    Raises
    ------
    DataFileError
        The file is not what it should be.
    InputError
        An argument is not allowed, or the data cannot carry a fit.

    Notes
    -----
    Laws are those of the registry, fitted by least squares with bounds from several
    starts; bristle laws are integrated along the measured motion. Uncertainty is that
    of blocks several correlation lengths long (Liang and Zeger 1986), so noise with a
    memory and what a law cannot follow both widen the intervals. First a few simple
    laws decide whether levels follow the load and whether the sensor has an offset
    and a share of the load; then all laws are fitted with that, bristle laws (which take
    longest) only where the others leave more than noise or where they are named.

    Examples
    --------
    >>> import numpy as np, locosweep as ls
    >>> t = np.linspace(0, 10, 500)
    >>> v = 0.02 * np.sin(2 * t)
    >>> force = 0.8 * np.sign(v) + np.random.default_rng(0).normal(0, 0.01, 500)
    >>> fit = ls.fit_friction({"t": t, "v": v, "force": force}, laws=["coulomb", "quadratic"])
    >>> fit.chosen.law, [law.law for law in fit.no_better]
    ('coulomb', ['quadratic'])
    """
    known = [law.name for law in all_laws()]
    wanted = known if laws is None else list(dict.fromkeys(laws))
    for name in wanted:
        if name not in known:
            raise InputError(f"law: {unknown('friction law', name, known)}")
    if not wanted:
        raise InputError("laws is empty: allowed is at least one friction law")
    form = CsvForm(separator, decimal)
    measured, notices = read_friction(
        data, mass=mass, columns=columns, units=units, runs=runs, form=form
    )
    ready = prepare(measured, mass=mass, holdout=[str(label) for label in holdout])
    job = ready.core()
    workers = _core.threads_to_use(whole("threads", threads))
    meter = progress_of(progress, "friction", "fits")

    def run(
        job: _core.FrictionData, candidates: list[_core.FrictionCandidate]
    ) -> list[FrictionOutcome]:
        return job.fit(candidates, workers, meter, token)

    terms = _terms(ready, run)
    skipped: dict[str, str] = {}
    candidates = _candidates(job, wanted, terms, ready.loaded, skipped)
    if not candidates:
        reasons = "; ".join(f"{name}: {why}" for name, why in skipped.items())
        raise InputError(f"none of these laws can be fitted to the data: {reasons}")
    outcomes = []
    if laws is None:
        plain = [c for c in candidates if _kinds()[c.law] != "bristle"]
        outcomes = run(job, plain)
        if _ranked(ready, plain, outcomes)[0].held_out_rms <= _NOTHING_LEFT * ready.force_noise:
            gone = [c.law for c in candidates if c not in plain]
            skipped |= dict.fromkeys(gone, "laws without bristles leave nothing but noise")
            candidates = plain
        else:
            candidates = [*plain, *(c for c in candidates if c not in plain)]
    outcomes += run(job, candidates[len(outcomes) :])
    fitted = _ranked(ready, candidates, outcomes)
    chosen, equal, no_better = choose(ready, fitted)
    shrink, left = explained_share(ready, chosen), left_over(ready, chosen)
    source = data if isinstance(data, str | os.PathLike) else None
    return FrictionFit(
        chosen=chosen,
        laws=fitted,
        equal=equal,
        no_better=no_better,
        status="tie" if equal else "chosen",
        summary=summary_of(chosen, equal, shrink, ready.force_noise, left),
        noise=ready.force_noise,
        shrink=shrink,
        left=left,
        skipped=skipped,
        data=ready,
        notices=[*notices, *ready.notices],
        provenance={
            "locosweep": _core.version(),
            "data_sha256": None if source is None else checksum(source),
            "mass": mass,
            "holdout": ready.held_out,
            "seed": seed,
        },
    )


def _kinds() -> dict[str, str]:
    return {law.name: law.kind for law in all_laws()}


def _terms(
    data: Prepared,
    run: Callable[[_core.FrictionData, list[_core.FrictionCandidate]], list[FrictionOutcome]],
) -> tuple[str, bool, bool]:
    """Choose how load and sensor enter, by the Schwarz criterion over a few simple laws.

    Runs held out do not count: one load held out between the others cannot distinguish an
    offset from a share of the load. Pieces of data are those that are independent beside
    the law that leaves least.
    """
    seen = fitted_only(data, _SCOUTED_ROWS)
    loads = [name for name, _ in _core.pressings()] if data.loaded else ["constant"]
    gains = (False, True) if data.loaded else (False,)
    candidates = [
        _core.FrictionCandidate(law, load, offset=offset, gain=gain)
        for law in _SCOUTS
        for load in loads
        for offset in (False, True)
        for gain in gains
    ]
    outcomes = run(seen.core(), candidates)
    pieces = sum(seen.lengths) / max(min(outcomes, key=lambda o: o.rms).memory, 1.0)
    costs = [schwarz(o.rms, pieces, len(o.parameters)) for o in outcomes]
    best = candidates[int(np.argmin(costs))]
    return best.load, best.offset, best.gain


def _candidates(
    job: _core.FrictionData,
    wanted: Sequence[str],
    terms: tuple[str, bool, bool],
    loaded: bool,
    skipped: dict[str, str],
) -> list[_core.FrictionCandidate]:
    """Every law with the terms found, and without an offset.

    A law that differs with the direction stands in for an offset, none for a share of a
    load that differs.
    """
    load, offset, gain = terms
    # A law of the load itself follows it by its own formula.
    others = [name for name, _ in _core.pressings()] if loaded else ["constant"]
    kinds = _kinds()
    found = []
    for name in wanted:
        for own in dict.fromkeys([offset, False]):
            # Integrated laws take longest; what the sensor adds is no part of them.
            if kinds[name] == "bristle" and own != offset:
                continue
            for pressing in dict.fromkeys([load, *others]):
                candidate = _core.FrictionCandidate(name, pressing, offset=own, gain=gain)
                why = job.lacks(candidate)
                if why is None:
                    found.append(candidate)
                    break
                skipped[name] = why
        if any(c.law == name for c in found):
            skipped.pop(name, None)
    return found


def _ranked(
    data: Prepared,
    candidates: Sequence[_core.FrictionCandidate],
    outcomes: Sequence[FrictionOutcome],
) -> list[FittedLaw]:
    """Fits by what they leave on samples held out, the best first."""
    force = data.column("force")
    held = [outcome.held_out for outcome in outcomes]
    seen = np.any([np.isfinite(h) for h in held], axis=0)
    starts = np.cumsum([0, *data.lengths])
    lengths = [int(seen[a:b].sum()) for a, b in pairwise(starts)]
    residuals = [np.ascontiguousarray((force - h)[seen]) for h in held]
    ranks = _core.rank_fits(residuals, [n for n in lengths if n])
    speeds = np.abs(data.column("v"))
    speeds = speeds[speeds > data.rest_speed]
    ends = (float(speeds.min()), float(speeds.max())) if speeds.size else (0.0, 0.0)
    parameters = [
        {p.name: _parameter(p, outcome.freedom) for p in outcome.parameters} for outcome in outcomes
    ]
    fitted = [
        FittedLaw(
            law=candidate.law,
            load=candidate.load,
            offset=candidate.offset,
            gain=candidate.gain,
            parameters=own,
            rms=outcome.rms,
            held_out_rms=rms,
            sigmas=sigmas,
            tied=tied,
            memory=outcome.memory,
            freedom=outcome.freedom,
            settled=outcome.settled,
            remarks=remarks_on(own, ends, data.breakaways),
            normal=data.normal,
            predicted=outcome.predicted,
            held_out=outcome.held_out,
        )
        for candidate, outcome, own, (rms, sigmas, tied) in zip(
            candidates, outcomes, parameters, ranks, strict=True
        )
    ]
    return sorted(fitted, key=lambda law: (not np.isfinite(law.held_out_rms), law.held_out_rms))


def _parameter(found: _core.FrictionParameter, freedom: float) -> FittedParameter:
    from scipy.stats import t

    std = float(found.std) if np.isfinite(found.std) and not found.bounded else None
    interval = None
    if std is not None and freedom >= 1:
        reach = std * float(t.ppf(0.5 + 0.5 * _CONFIDENCE, freedom))
        interval = (found.value - reach, found.value + reach)
        if found.logarithmic:
            factor = float(np.exp(min(reach / found.value, _MOST_EXPONENT)))
            interval = (found.value / factor, found.value * factor)
    return FittedParameter(
        found.name, found.unit, found.meaning, found.value, std, interval, found.bounded
    )
