"""Preparation of measured runs: velocity, friction force, samples that count."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core
from locosweep.errors import InputError
from locosweep.registry import parameter, unknown

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from numpy.typing import NDArray

    from locosweep.friction_fit.data import FrictionRun

    Floats = NDArray[np.float64]

_MOST_SAMPLES = 12_000
"""Samples of all runs that motion is kept at: bristle laws are integrated along it."""
_MOST_ROWS = 3_000
"""Samples that laws are compared at."""
_LEAST_ROWS = 20
_FOLDS = 5
_PIECES = 10
"""Pieces of a run whose parts are held out in turn."""
_LARGEST_FORCE = 1e12
"""N from which squares of forces leave what fits can reckon with: no rig has them."""
_FITTED = 255
_SPIKE = 15.0
"""Spreads from which a lone sample is a fault of the sensor."""
_REST = 3.0
"""Standard deviations of the velocity that count as rest."""
_MOST_REST = 0.25
"""Largest rest speed, as a share of the usual speed."""
_LONG_REST = 5
"""Samples from which on a rest counts, whose end shows the break-away force."""
_SPREAD = 0.1
"""Relative range from which the load differs between samples."""


@dataclass(frozen=True)
class Motion:
    """Time [s], position [m], velocity [m/s], drive, load and friction force [N] of one run.

    Arrays have the shape (n,); drive and load are 0 where there is none. `force_noise` [N]
    and `speed_error` [m/s] are standard deviations of the noise.
    """

    label: str
    t: Floats
    x: Floats
    v: Floats
    drive: Floats
    load: Floats
    force: Floats
    force_noise: float
    speed_error: float

    def at(self, pick: NDArray[np.int64]) -> dict[str, Any]:
        """Return the fields, arrays only at some samples."""
        fields = vars(self).items()
        return {name: v[pick] if isinstance(v, np.ndarray) else v for name, v in fields}


@dataclass(frozen=True)
class PreparedRun(Motion):
    """One run, ready to fit.

    `rows` are the samples that count, sliding or the end of a long rest, shape (m,);
    `folds` the parts that they are held out with, 255 where they are only fitted to.
    """

    rows: NDArray[np.int64]
    folds: NDArray[np.uint8]


@dataclass(frozen=True)
class Prepared:
    """Runs with samples that count, and their common properties."""

    runs: list[PreparedRun]
    normal: float
    """Normal force [N] where no load gives it: the weight, or 1 N without a mass, so that
    coefficients read as newtons."""
    rest_speed: float
    """Speed [m/s] up to which a sample is at rest."""
    force_noise: float
    speed_error: float
    loaded: bool
    """The load differs between samples."""
    held_out: list[str]
    """Runs that are held out, or none where every part is in turn."""
    by: str
    """Held-out data: "runs given", "runs in turn" or "blocks in turn"."""
    breakaways: int
    """Rests whose end shows the break-away force."""
    notices: list[str]

    def column(self, name: str) -> Floats:
        """Return one column at the samples that count, all runs one after another."""
        return np.concatenate([getattr(run, name)[run.rows] for run in self.runs])

    @property
    def lengths(self) -> list[int]:
        """Number of samples that count in each run."""
        return [int(run.rows.size) for run in self.runs]

    def core(self) -> _core.FrictionData:
        """Return the same for the core."""
        runs = [
            (r.t - r.t[0], r.x, r.v, r.drive, r.load, r.force, r.rows, r.folds) for r in self.runs
        ]
        return _core.FrictionData(runs, self.normal, self.rest_speed)


def prepare(
    measured: Sequence[FrictionRun], *, mass: float | None = None, holdout: Collection[str] = ()
) -> Prepared:
    """Find velocity, friction force, rests and the parts to hold out.

    `holdout` are labels of runs; by default every run is held out in turn, and with one
    or two runs every part of them. InputError where nothing moves, nothing is left to fit
    to, or a run to hold out is unknown.
    """
    if mass is not None:
        mass = parameter("mass").check(mass)
    labels = [run.label for run in measured]
    for label in holdout:
        if label not in labels:
            raise InputError(f"holdout: {unknown('run', label, labels)}")
    if holdout and set(labels) <= set(holdout):
        raise InputError("holdout names every run: allowed are some of them, the rest is fitted to")
    notices: list[str] = []
    motions = [_motion(run, mass, notices) for run in measured]
    rest_speed = _rest_speed(motions)
    stride = max(1, -(-sum(m.t.size for m in motions) // _MOST_SAMPLES))
    if stride > 1:
        notices.append(f"every {stride}th sample is used: {_MOST_SAMPLES} are enough")
    counts = [_rows(m, rest_speed, stride) for m in motions]
    total = sum(sliding.size for _, sliding, _ in counts)
    thin = max(1, -(-total // _MOST_ROWS))
    kept = [
        (m, pick, np.union1d(sliding[::thin], ends))
        for m, (pick, sliding, ends) in zip(motions, counts, strict=True)
    ]
    idle = [m.label for m, _, rows in kept if rows.size < _LEAST_ROWS]
    kept = [one for one in kept if one[2].size >= _LEAST_ROWS]
    if not kept:
        raise InputError(
            f"the data never move faster than {rest_speed:.3g} m/s, which counts as rest: "
            "a friction law needs motion"
        )
    if idle:
        notices.append(f"runs that hardly move, left out: {', '.join(idle)}")
    by, folds = _folds([(m.label, rows) for m, _, rows in kept], holdout, notices)
    runs = [
        PreparedRun(**m.at(pick), rows=rows.astype(np.int64), folds=fold)
        for (m, pick, rows), fold in zip(kept, folds, strict=True)
    ]
    forces = np.concatenate([np.abs(run.force[run.rows]) for run in runs])
    if not 0.0 < float(forces.max()) < _LARGEST_FORCE:
        raise InputError(
            f"the friction force is up to {forces.max():.3g} N: allowed is more than 0 and less "
            f"than {_LARGEST_FORCE:.0e} N"
        )
    loads = np.concatenate([np.abs(run.load[run.rows]) for run in runs])
    middle = float(np.median(loads))
    loaded = bool(middle > 0 and np.ptp(loads) > _SPREAD * middle)
    if middle > 0 and not loaded:
        notices.append("the load hardly differs: how friction follows it cannot be seen")
    gravity = parameter("gravity").default or 1.0
    return Prepared(
        runs,
        normal=1.0 if mass is None else mass * gravity,
        rest_speed=rest_speed,
        force_noise=float(np.median([m.force_noise for m, _, _ in kept])),
        speed_error=float(np.median([m.speed_error for m, _, _ in kept])),
        loaded=loaded,
        held_out=[run.label for run in runs if run.label in set(holdout)],
        by=by,
        breakaways=sum(int(ends.size) for _, _, ends in counts),
        notices=notices,
    )


def fitted_only(data: Prepared, most: int) -> Prepared:
    """Return the runs that are not held out, with at most about `most` samples that count."""
    kept = [run for run in data.runs if run.label not in data.held_out]
    thin = max(1, -(-sum(run.rows.size for run in kept) // most))
    rows = [run.rows[::thin] for run in kept]
    return replace(
        data,
        runs=[
            replace(run, rows=own, folds=np.full(own.size, _FITTED, dtype=np.uint8))
            for run, own in zip(kept, rows, strict=True)
        ],
        held_out=[],
    )


def _motion(run: FrictionRun, mass: float | None, notices: list[str]) -> Motion:
    """Find velocity and friction force at every sample that has all values."""
    where = f"run {run.label}"
    given = run.columns
    known = np.all([np.isfinite(column) for column in given.values()], axis=0)
    if (gone := int((~known).sum())) > 0:
        notices.append(f"{where}: {gone} samples with a missing value, left out")
    source = "force" if "force" in given else "drive"
    if known.sum() >= _LEAST_ROWS:
        lone = _spikes(given[source][known])
        if lone.size:
            notices.append(f"{where}: {lone.size} samples of {source} stand alone, left out")
            known[np.flatnonzero(known)[lone]] = False
    if known.sum() < _LEAST_ROWS:
        raise InputError(f"{where}: {int(known.sum())} usable samples, allowed are {_LEAST_ROWS}")
    t = run.t[known]
    columns = {name: column[known] for name, column in given.items()}
    nothing = np.zeros(t.size)
    if "v" in columns:
        v = columns["v"]
        error = _core.noise(t, v)
    else:
        v, _, error, _ = _core.derivative(t, columns["x"], 1)
    # Only differences of position count: it may begin anywhere.
    steps = 0.5 * (v[1:] + v[:-1]) * np.diff(t)
    x = columns.get("x", np.concatenate([[0.0], np.cumsum(steps)]))
    drive = columns.get("drive", nothing)
    if "force" in columns:
        force = columns["force"]
    else:
        if mass is None:
            raise InputError("mass is missing: allowed is a mass in kg or a column force")
        slope = _core.derivative(t, v, 1) if "v" in columns else _core.derivative(t, x, 2)
        force = drive - mass * slope[0]
    load = columns.get("load", nothing)
    return Motion(run.label, t, x, v, drive, load, force, _core.noise(t, force), error)


def _spikes(force: NDArray[np.float64]) -> NDArray[np.int64]:
    """Lone samples far from their neighbours and from all others, if there are only a few."""
    lone = np.array(_core.spikes(force, _SPIKE), dtype=np.int64)
    others = np.delete(force, lone)
    low, high = float(others.min()), float(others.max())
    # A break-away and a turn stand alone too, but not that far beyond sliding.
    lone = lone[(force[lone] < 2 * low - high) | (force[lone] > 2 * high - low)]
    # A fault of the sensor is rare.
    return lone if lone.size <= 0.002 * force.size + 1 else lone[:0]


def _rest_speed(motions: list[Motion]) -> float:
    speeds = np.abs(np.concatenate([m.v for m in motions]))
    usual = float(np.quantile(speeds, 0.95))
    if usual == 0.0:
        raise InputError("the data never move: a friction law needs motion")
    error = float(np.median([m.speed_error for m in motions]))
    return float(np.clip(_REST * error, 1e-4 * usual, _MOST_REST * usual))


def _rows(
    motion: Motion, rest_speed: float, stride: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Find samples to keep, and of these the sliding ones and the ends of long rests."""
    still = np.abs(motion.v) <= rest_speed
    ends = [end for end in _rests(still) if _breaks(motion, still, end)]
    pick = np.union1d(np.arange(0, motion.t.size, stride), np.array(ends, dtype=np.int64))
    return pick, np.flatnonzero(~still[pick]), np.searchsorted(pick, ends).astype(np.int64)


def _rests(still: NDArray[np.bool_]) -> list[int]:
    """Last samples of rests that are long enough and that motion follows."""
    change = np.diff(still.astype(np.int8))
    begins = np.concatenate([[0] if still[0] else [], np.flatnonzero(change == 1) + 1])
    ends = np.flatnonzero(change == -1)
    pairs = zip(begins.astype(int), ends, strict=False)
    return [int(end) for begin, end in pairs if end - begin + 1 >= _LONG_REST]


def _breaks(motion: Motion, still: NDArray[np.bool_], end: int) -> bool:
    """Return whether a rest ended at the break-away force.

    Where the motion is imposed, a rest may end at any force, and friction only then
    builds up.
    """
    after = np.arange(end + 1, min(end + 6, motion.t.size))
    after = after[~still[after]]
    if after.size == 0:
        return False
    friction = np.sign(motion.v[end + 1]) * motion.force
    return bool(friction[end] >= 0.9 * np.median(friction[after]) > 0.0)


def _folds(
    runs: list[tuple[str, NDArray[np.int64]]], holdout: Collection[str], notices: list[str]
) -> tuple[str, list[NDArray[np.uint8]]]:
    """Choose the held-out data: the runs named, or runs in turn, or parts of runs in turn."""
    sizes = [rows.size for _, rows in runs]
    if holdout:
        kept = [0 if label in holdout else _FITTED for label, _ in runs]
        if set(kept) != {0, _FITTED}:
            raise InputError("of the runs that move, all or none are held out: allowed are some")
        return "runs given", [
            np.full(size, fold, dtype=np.uint8) for size, fold in zip(sizes, kept, strict=True)
        ]
    if len(runs) > 2:
        count = min(len(runs), _FOLDS)
        return "runs in turn", [
            np.full(size, i % count, dtype=np.uint8) for i, size in enumerate(sizes)
        ]
    notices.append(f"{len(runs)} run{'s' * (len(runs) > 1)}: parts of each are held out in turn")
    return "blocks in turn", [
        (np.arange(size) * _PIECES // size % _FOLDS).astype(np.uint8) for size in sizes
    ]
