"""Which effects a planned experiment could tell apart, and how large they must be."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from locosweep import _core
from locosweep.diagnosis.design.distance import PlannedRuns, refit, strengths
from locosweep.diagnosis.effects.catalogue import candidates
from locosweep.engine import whole
from locosweep.errors import InputError
from locosweep.files.channels import CHANNELS, REPLAYED
from locosweep.files.robot import Robot, load_robot
from locosweep.files.runs import Run, load_runs
from locosweep.linear_algebra import on_one_thread
from locosweep.progress import progress_of
from locosweep.registry import unknown
from locosweep.simulation.replay import effect

if TYPE_CHECKING:
    import os
    from collections.abc import Mapping, Sequence

    import polars as pl
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike, NDArray

    from locosweep.diagnosis.effects.catalogue import Family
    from locosweep.progress import Progress

    Floats = NDArray[np.float64]
    Values = dict[str, float]

SEEN = 6.0
"""Length of a signal, in sigmas, that a diagnosis detects."""

APART = 3.0
"""Distance, in sigmas, from which two effects are told apart."""


@dataclass(frozen=True)
class Distinction:
    """Effects that an experiment could detect and tell apart.

    Attributes
    ----------
    names : tuple of str
        Effects that the experiment can show.
    distances : ndarray
        Row: the effect at work, its signal `size` sigmas long. Column: the rival
        that is refitted to it. What is left, in sigmas, shape (names, names).
    size : float
        Length of the signals.
    seen_from : dict of str to list of dict
        Parameters at which each effect's signal is 6 sigmas long: one entry for
        each sign that it can have.
    unseen : dict of str to str
        Effects that the experiment cannot show, and why.
    noise : dict of str to float
        Standard deviation of each channel that is measured.
    """

    names: tuple[str, ...]
    distances: Floats
    size: float
    seen_from: dict[str, list[Values]]
    unseen: dict[str, str]
    noise: dict[str, float]

    def rivals(self, name: str) -> list[str]:
        """Return the effects that the experiment cannot tell from one, nearest first."""
        if name not in self.names:
            raise unknown("effect that is seen here", name, self.names)
        row = self.distances[self.names.index(name)]
        near = [(row[k], other) for k, other in enumerate(self.names)
                if other != name and row[k] < APART]  # fmt: skip
        return [other for _, other in sorted(near)]

    def to_polars(self) -> pl.DataFrame:
        """Return a table, a row an effect: seen from, nearest rival, those too near."""
        import polars as pl

        rows = []
        for k, name in enumerate(self.names):
            others = np.where(np.arange(len(self.names)) == k, np.inf, self.distances[k])
            nearest = int(others.argmin()) if len(self.names) > 1 else None
            rows.append({
                "effect": name,
                "seen_from": _told(name, self.seen_from[name]),
                "nearest_rival": None if nearest is None else self.names[nearest],
                "distance": None if nearest is None else float(others[nearest]),
                "not_told_from": ", ".join(self.rivals(name)),
                "unseen_because": None,
            })  # fmt: skip
        rows += [{"effect": name, "unseen_because": why} for name, why in self.unseen.items()]
        schema = {"effect": pl.String, "seen_from": pl.String, "nearest_rival": pl.String,
                  "distance": pl.Float64, "not_told_from": pl.String,
                  "unseen_because": pl.String}  # fmt: skip
        return pl.DataFrame(rows, schema=schema)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the matrix of distances, on axes of pyplot if none are given."""
        from locosweep.diagnosis.design.figures_matrix import matrix

        return matrix(self, ax=ax)

    def __repr__(self) -> str:
        lines = [f"Distinction of {len(self.names)} effects by {', '.join(self.noise)}"]
        for name in self.names:
            near = ", ".join(self.rivals(name))
            lines.append(f"  {name}: {'not told from ' + near if near else 'told from all others'}")
        lines += [f"  {name}: not seen, {why}" for name, why in self.unseen.items()]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from locosweep.diagnosis.design.figures_matrix import matrix_figure
        from locosweep.plot.html import card

        return card(repr(self), matrix_figure(self))


def _told(name: str, found: Sequence[Values]) -> str:
    """Return an effect's parameters, those of both signs beside each other."""
    units = {p.name: "" if p.unit == "1" else f" {p.unit}" for p in effect(name).parameters}
    first, last = found[0], found[-1]
    parts = []
    for key, value in first.items():
        other = last[key]
        if value == other:
            text = f"{value:.4g}"
        elif abs(value + other) < 0.1 * abs(value):
            text = f"±{max(abs(value), abs(other)):.3g}"
        else:
            text = f"{value:.5g} or {other:.5g}"
        parts.append(f"{key} = {text}{units[key]}")
    return ", ".join(parts)


@on_one_thread
def distinguish(
    nominal: Robot | str | os.PathLike[str],
    runs: str | os.PathLike[str] | Sequence[Run] | Mapping[str, tuple[ArrayLike, ArrayLike]],
    *,
    channels: Sequence[str] | None = None,
    noise: Mapping[str, float] | None = None,
    size: float = 10.0,
    threads: int | None = None,
    progress: bool | Progress | None = None,
) -> Distinction:
    """Say, before anything is measured, which effects an experiment could tell apart.

    Each effect is made so strong that its signal is `size` sigmas long; then every
    rival is refitted to that signal, with both signs and its own shapes, and the
    distance is what is left. Start offset and start velocity of each run are free.

    Parameters
    ----------
    nominal : Robot or path-like
        The nominal model.
    runs : path-like, sequence of Run or mapping
        A file of runs, runs, or for each label times in s and drive commands.
    channels : sequence of str, optional
        What will be measured, of x, v, x_rear and force; default what the runs
        have, and x without any.
    noise : mapping of str to float, optional
        Standard deviation of a channel; default from the model's [sensor] table.
    size : float
        Length of the signals in sigmas.
    threads : int, optional
        As in `sweep`.
    progress : bool or callable, optional
        As in `sweep`; it counts effects.

    Returns
    -------
    Distinction

    Raises
    ------
    InputError
        No runs, an unknown channel, no noise of a channel, nothing that moves.

    Examples
    --------
    >>> import numpy as np
    >>> import locosweep as ls
    >>> robot = ls.Robot({"mass": 0.271, "segments": 4.0, "mu_coulomb": 0.15})
    >>> t = np.arange(0.0, 1.0, 0.01)
    >>> d = ls.distinguish(robot, {"push": (t, np.where(t < 0.5, 0.6, 0.0))},
    ...                    noise={"x": 1e-4})
    >>> d.rivals("viscous_friction")[0]
    'back_emf'
    """
    robot = nominal if isinstance(nominal, Robot) else load_robot(nominal)
    given = _runs(runs)
    spread = _noise(robot, given, channels, noise)
    if not np.isfinite(size) or size <= 0.0:
        raise InputError(f"size is {size!r}: allowed is a number above 0")
    workers = _core.threads_to_use(whole("threads", threads))
    meter = progress_of(progress, "distinguish", "effects")
    plan = PlannedRuns(robot, given, spread, workers)
    motions = np.split(plan.readings["x"][0], np.cumsum(plan.lengths)[:-1])
    if not any(np.ptp(x) > 0.0 for x in motions):
        raise InputError("the head does not move under these drives: allowed are drives that "
                         "exceed its friction")  # fmt: skip
    names_here, unseen = candidates(robot, plan.noise)
    families = {name: plan.families[name] for name in names_here}
    signed = [(family, sign) for family in families.values() for sign in family.signs]
    seen = strengths(plan, signed, SEEN)
    strong = strengths(plan, signed, size)
    names, seen_from = [], {}
    for name, family in families.items():
        own = [i for i, (other, _) in enumerate(signed) if other is family]
        found = [family.parameters(theta) for i in own if (theta := seen[i]) is not None]
        if found and any(strong[i] is not None for i in own):
            seen_from[name] = found
            names.append(name)
        else:
            unseen[name] = f"no strength that the rig allows gives a signal of {size:g} sigmas"
    truths = [(family.name, theta) for (family, _), theta in zip(signed, strong, strict=True)
              if theta is not None and family.name in seen_from]  # fmt: skip
    distances = _distances(plan, families, names, truths, size, meter)
    return Distinction(tuple(names), distances, float(size), seen_from, unseen, plan.noise)


def _distances(
    plan: PlannedRuns,
    families: Mapping[str, Family],
    names: Sequence[str],
    truths: Sequence[tuple[str, Floats]],
    size: float,
    progress: Progress | None,
) -> Floats:
    signals = plan.signals([(name, families[name].parameters(theta)) for name, theta in truths])
    lengths = np.sqrt(np.einsum("ij,ij->i", signals, signals))
    rows = {name: i for i, name in enumerate(names)}
    found = np.full((len(names), len(names)), np.inf)
    begun = time.perf_counter()
    for k, rival in enumerate(names):
        reference = next(float(theta[0]) for name, theta in truths if name == rival)
        others = [i for i, (name, _) in enumerate(truths) if name != rival]
        left, _ = refit(plan, families[rival], signals[others], reference)
        for i, distance in zip(others, left, strict=True):
            row = rows[truths[i][0]]
            # Effects whose weakest form is stronger than asked for: by proportion.
            found[row, k] = min(found[row, k], distance * size / lengths[i])
        found[k, k] = 0.0
        if progress is not None:
            progress(k + 1, len(names), (k + 1) / max(time.perf_counter() - begun, 1e-9))
    return found


def _runs(given: Any) -> list[Run]:
    if isinstance(given, dict):
        found = []
        for label, (t, drive) in given.items():
            times, values = np.asarray(t, dtype=np.float64), np.asarray(drive, dtype=np.float64)
            if times.ndim != 1 or times.shape != values.shape or times.size < 2:
                raise InputError(f"run {label}: times have shape {times.shape}, drives "
                                 f"{values.shape}: allowed are two or more of each")  # fmt: skip
            if not (np.isfinite(times).all() and np.isfinite(values).all()):
                raise InputError(f"run {label}: allowed are finite times and drives")
            if (np.diff(times) <= 0.0).any():
                raise InputError(f"run {label}: time must rise")
            found.append(Run(str(label), times, values))
    elif isinstance(given, list | tuple):
        found = list(given)
    else:
        found, _ = load_runs(given, needs=("t", "drive"))
    if not found:
        raise InputError("runs is empty: allowed is at least one run")
    return found


def _noise(
    robot: Robot,
    runs: Sequence[Run],
    channels: Sequence[str] | None,
    noise: Mapping[str, float] | None,
) -> dict[str, float]:
    """Return each channel's standard deviation, quantisation included."""
    stated = dict(noise or {})
    for name in (*(channels or ()), *stated):
        if name not in REPLAYED:
            raise unknown("channel", name, REPLAYED)
    measured = [name for name in REPLAYED if any(name in run.channels for run in runs)]
    chosen = list(dict.fromkeys(channels or [*(measured or ["x"]), *stated]))
    found = {}
    for name in chosen:
        kind = CHANNELS[name].sensor
        sd = stated.get(name, robot.other.get(f"sensor.{kind}_noise"))
        step = 0.0 if name in stated else robot.other.get(f"sensor.{kind}_resolution", 0.0)
        if sd is None and not step:
            raise InputError(f"the noise of {name} is not known: the model's [sensor] table has no "
                             f"{kind}_noise, and noise has no {name}")  # fmt: skip
        deviation = float(sd or 0.0)
        total = float(np.hypot(deviation, float(step) / np.sqrt(12.0)))
        if not np.isfinite(total) or deviation < 0.0 or total == 0.0:
            raise InputError(f"noise of {name} is {deviation!r}: allowed is a number above 0")
        found[name] = total
    return found
