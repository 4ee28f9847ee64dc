"""Columns that cannot be what they are called: wrong units or signs, swapped or dead columns.

No model is fitted: what the drive could do at most, the sign of its work, and one replay of the
nominal model say which columns no effect accounts for.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from locosweep.diagnosis.data.noise import noise_of
from locosweep.diagnosis.data.readings.bounds import largest_acceleration, resistance
from locosweep.diagnosis.data.readings.coarse import coarse
from locosweep.diagnosis.data.readings.finding import Finding
from locosweep.errors import DataFileError
from locosweep.simulation.replay import nominal_of, replay_runs, sensor_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from locosweep.diagnosis.data.readings.coarse import Coarse
    from locosweep.files.robot import Robot
    from locosweep.files.runs import Run

    Floats = NDArray[np.float64]

LENGTHS = {"um": 1e6, "mm": 1e3, "cm": 1e2, "inch": 1.0 / 0.0254}
ANGLES = {"deg": 180.0 / np.pi}
FORCES = {"percent": 1e2, "mN": 1e3}
"""Factors of wrong units by their names, the SI unit being 1."""
LARGEST = 1e15
"""Largest usual size of a column, in SI: squares of it are still numbers."""
_NEAR = float(np.log(3.0))
"""Logarithm of a factor up to which it is that of a unit: effects change the travel, too."""
_FAST, _STRONG = 0.9, 0.95
"""Quantiles of accelerations and drives that stand for their largest values."""
_SWAP = (
    "the columns {a} and {b} seem to be swapped (--column {a}={b} --column {b}={a}); no cause is "
    "looked for before they are right"
)
_SPREADS = 3.0
"""Deviations of an acceleration by noise that do not count in it."""
_TOO_FAST = 3.0
"""Acceleration over what all forces at once could make; 0.4 at most in simulated rigs with any
listed effect, 0.2 in two measured ones, 0.8 where foreign forces push."""
_TOO_FAR, _RUNS_TOO_FAR, _ALIKE = 15.0, 10.0, 5.0
"""Travel over that of the nominal model, of the median run and of the lower quarter, and ratio
of the upper to the lower quarter: all runs are too long by one factor. Effects reach 6 in the
median run, 14 with an uneven slope, but never 10 in three of four."""
_SAME_COURSE = 0.8
"""Squared correlation of such positions with the nominal ones, at least."""
_EASED, _FORCE = 0.3, "surface.coulomb_force"
"""Part of the friction that a nominal head with hardly any is given."""
_BEYOND, _FAR_BEYOND = 2.0, 8.0
"""Travel over that of such a head: where the nominal model accounts for most of the motion in the
likely unit, and where only the course is the same."""
_ONE_FACTOR, _SLIDES = 2.0, 60.0
"""Ratio of the upper to the lower quarter of all travels over the nominal ones, below which they
are too long by one factor even where friction would make as much; and travel with hardly any
friction over the nominal one, up to which the nominal head slides at all."""
_TOO_STRONG, _TOO_SLOW = 20.0, 0.03
"""Drive force over what holds the head, and accelerations over what they could be, that say
that the drive is too large; drives reach 7, and where inertia takes them up, accelerations 0.3."""
_TOO_WEAK = 0.05
"""Drive force over friction and weight below which nothing that moves is moved by it."""
_MOVES = 30.0
"""Travel of a nominal run in deviations of noise, from which it is compared."""
_AGAINST = -0.25
"""Work of drive and weight over the sum of its parts without signs: -0.01 at least in
simulated and measured rigs, as friction only takes."""
_RUN_AGAINST, _OTHERS_WITH = -0.8, 0.5
"""The same for one run that is turned round, and for the others: single runs reach -0.6."""
_LATE = 0.2
"""Delays up to which, in s, motion that follows its drive late may seem to go against it."""
_SWAPPED, _AS_IS = 0.5, 0.2
"""Share of the motion that the nominal model accounts for with two columns swapped, at least,
and as they are, at most; in another unit of the drive it is more than that, too."""
_LIKE_DRIVE, _UNLIKE_DRIVE = 0.98, 0.9
"""Correlation with the drive of a force, at least, and of what is called one, at most: a position
may follow a slow drive as well, but then so does the force."""
_STILL, _WOULD_MOVE = 4.0, 50.0
"""Travel, in deviations of noise, of a head that does not move, and of the nominal one that
does."""


@dataclass(frozen=True)
class Columns:
    """What columns cannot be, and whether runs are of use nevertheless."""

    runs: tuple[Run, ...]
    """The runs, without those that are known to be turned round."""
    findings: tuple[Finding, ...] = ()

    @property
    def hopeless(self) -> bool:
        """True if no run can be diagnosed before its columns are put right."""
        return any(not found.masked for found in self.findings)


@dataclass(frozen=True)
class _Seen:
    """Runs in steps, measured and as the nominal model replays them."""

    robot: Robot
    runs: Sequence[Run]
    noise: float
    """Deviation of a reading of x, in the unit that x is in."""
    stated: float
    """The same as the nominal file gives it, in SI; infinite where it does not."""

    @cached_property
    def nominal(self) -> dict[str, float]:
        return nominal_of(self.robot)

    @cached_property
    def pairs(self) -> list[tuple[Run, Coarse, Coarse]]:
        """Runs that both are known of."""
        read = replay_runs(replace(self.robot, effects={}), self.runs)["x"].to_numpy()
        parts = np.split(read, np.cumsum([run.t.size for run in self.runs])[:-1])
        found = []
        for run, x in zip(self.runs, parts, strict=True):
            if not np.isfinite(x).all():
                continue
            measured = coarse(run, run.channels["x"], self.nominal)
            x = np.where(np.isfinite(run.channels["x"]), x, np.nan)
            replayed = coarse(run, x, self.nominal)
            if measured is not None and replayed is not None:
                found.append((run, measured, replayed))
        return found

    @cached_property
    def moving(self) -> list[tuple[Run, Coarse, Coarse]]:
        """Runs whose measured motion is far beyond the noise."""
        return [row for row in self.pairs if row[1].span > _MOVES * self.noise]

    @cached_property
    def pace(self) -> float:
        """Acceleration over what all forces at once could make, of the median run that moves."""
        found = []
        for run, one, _ in self.moving:
            spread = np.sqrt(6.0) * self.noise / float(np.median(np.diff(one.t))) ** 2
            fast = float(np.quantile(np.abs(one.accelerations), _FAST)) - _SPREADS * spread
            found.append(max(fast, 0.0) / largest_acceleration(run, self.nominal))
        return float(np.median(found)) if found else 0.0

    @cached_property
    def accounted(self) -> float:
        """Share of the motion that the nominal model accounts for, of the median run."""
        shares = []
        for _, one, other in self.pairs:
            x, y = one.x - one.x[0], other.x - other.x[0]
            total = float(((x - x.mean()) ** 2).sum())
            shares.append(1.0 - float(((x - y) ** 2).sum()) / total if total > 0.0 else 0.0)
        return float(np.median(shares)) if shares else 0.0

    def ratios(self, least: float) -> Floats:
        """Travel of moving runs over that of the nominal model, where that is not the `least`."""
        return np.array([a.span / b.span for _, a, b in self.moving if b.span > least])

    def eased(self) -> _Seen:
        """Return the same with less friction than any listed effect leaves."""
        robot = replace(self.robot, parameters=dict(self.robot.parameters))
        robot = replace(robot, other=dict(self.robot.other))
        for given, name in ((robot.parameters, "mu_coulomb"), (robot.other, _FORCE)):
            if name in given:
                given[name] = _EASED * float(given[name])
        return replace(self, robot=robot)

    @cached_property
    def course(self) -> float:
        """Squared correlation of measured and nominal positions, of the median run that moves."""
        found = [max(_correlation(one.x, other.x), 0.0) ** 2 for _, one, other in self.moving]
        return float(np.median(found)) if found else 0.0

    def whole(self, column: str, kind: str, note: str, likely: str = "") -> Columns:
        """Return a finding over the whole of each run."""
        return Columns(
            tuple(self.runs),
            tuple(
                Finding(run.label, float(run.t[0]), float(run.t[-1]), column, kind, run.t.size,
                        masked=False, note=note, likely=likely)
                for run in self.runs
            ),
        )  # fmt: skip


def check_columns(runs: Sequence[Run], robot: Robot) -> Columns:
    """Say which columns of measured runs cannot be what they are called on this rig.

    DataFileError where numbers are beyond all that can be computed with.
    """
    for run in runs:
        for name, values in (("x", run.channels["x"]), ("drive", run.drive)):
            size = float(np.median(np.abs(values[np.isfinite(values)])))
            if size > LARGEST:
                raise DataFileError(
                    f"run {run.label}, column {name}: its values are about {size:.2g}, allowed is "
                    f"up to {LARGEST:g}"
                )
    sensor = sensor_of(robot)
    noise = noise_of("x", runs, sensor).sd
    seen = _Seen(robot, runs, noise, sensor.get("position_noise", np.inf))
    if seen.pairs:
        for find in (_swapped, _still, _against, _unit_of_x, _unit_of_drive, _turned):
            found = find(seen)
            if found is not None:
                return found
    return Columns(tuple(runs))


def _swapped(seen: _Seen) -> Columns | None:
    """Find x and another column in each other's place."""
    if seen.accounted < _AS_IS:
        other = [replace(run, drive=run.channels["x"], channels={"x": run.drive})
                 for run in seen.runs if np.isfinite(run.channels["x"]).all()]  # fmt: skip
        if other and replace(seen, runs=other).accounted > _SWAPPED:
            return seen.whole("x", "swapped", _SWAP.format(a="x", b="drive"), "drive")
    for column in ("force", "x_rear"):
        runs = [run for run in seen.runs if column in run.channels]
        if runs and all(_FITS_BETTER[column](seen, run, column) for run in runs):
            return seen.whole("x", "swapped", _SWAP.format(a="x", b=column), column)
    return None


def _is_force(seen: _Seen, run: Run, column: str) -> bool:
    """Return whether x follows the drive at once, and the force does not."""
    del seen
    both = np.isfinite(run.channels["x"]) & np.isfinite(run.channels[column])
    x, y = (_correlation(run.channels[name][both], run.drive[both]) for name in ("x", column))
    return abs(x) > _LIKE_DRIVE and abs(y) < _UNLIKE_DRIVE


def _is_rear(seen: _Seen, run: Run, column: str) -> bool:
    """Return whether the head rests while the body goes where the drive pushes the head."""
    head = coarse(run, run.channels["x"], seen.nominal)
    body = coarse(run, run.channels[column], seen.nominal)
    if head is None or body is None:
        return False
    work, parts = body.work
    moves = body.span > _MOVES * seen.noise and work > _OTHERS_WITH * parts
    return head.span < _STILL * seen.noise and moves


_FITS_BETTER: dict[str, Callable[[_Seen, Run, str], bool]] = {
    "force": _is_force, "x_rear": _is_rear
}  # fmt: skip


def _correlation(a: Floats, b: Floats) -> float:
    if a.size < 2 or np.ptp(a) == 0.0 or np.ptp(b) == 0.0:
        return 0.0
    return float(np.corrcoef(a, b)[0, 1])


def _still(seen: _Seen) -> Columns | None:
    """Find an encoder that shows no motion in any run, where the nominal head moves far."""
    if any(one.span > _STILL * seen.noise for _, one, _ in seen.pairs):
        return None
    if np.median([other.span for _, _, other in seen.pairs]) <= _WOULD_MOVE * seen.noise:
        return None
    note = (
        "x shows no motion in any run, where the nominal head would move far: is the encoder dead, "
        "or the drive off? Nothing tells causes apart without motion, so none is looked for"
    )
    return seen.whole("x", "frozen", note)


def _work(runs: Sequence[tuple[Run, Coarse, Coarse]]) -> float:
    """Return the work of drive and weight over the sum of its parts without signs."""
    work, parts = np.sum([one.work for _, one, _ in runs], axis=0) if runs else (0.0, 0.0)
    return float(work / parts) if parts > 0.0 else 0.0


def _against(seen: _Seen) -> Columns | None:
    """Find a head that moves against its drive."""
    work = _work(seen.moving)
    if work >= _AGAINST or _late(seen, -0.5 * work):
        return None
    note = (
        "the drive takes energy from the head instead of giving it some: x, the drive or the gain "
        "has the wrong sign; no cause is looked for before it is right"
    )
    return seen.whole("x", "sign", note)


def _late(seen: _Seen, least: float) -> bool:
    """Return whether the head would move with its drive if it were read late."""
    for late in np.linspace(0.0, _LATE, 16)[1:]:
        shifted = []
        for run, _, other in seen.moving:
            t, x = run.since_start, run.channels["x"]
            ok = np.isfinite(x)
            earlier = np.interp(t + late, t[ok], x[ok])
            one = coarse(run, np.where(t + late <= t[-1], earlier, np.nan), seen.nominal)
            if one is not None:
                shifted.append((run, one, other))
        if _work(shifted) > least:
            return True
    return False


def _turned(seen: _Seen) -> Columns | None:
    """Find single runs that go against their drive while the others go with it."""
    works = [_work([row]) for row in seen.moving]
    turned = [row for row, work in zip(seen.moving, works, strict=True) if work < _RUN_AGAINST]
    others = [row for row, work in zip(seen.moving, works, strict=True) if work >= _RUN_AGAINST]
    if not turned or _work(others) < _OTHERS_WITH:
        return None
    labels = {run.label for run, _, _ in turned}
    findings = tuple(
        Finding(run.label, float(run.t[0]), float(run.t[-1]), "x", "sign", run.t.size, masked=True,
                note="the head moves against its drive, in the other runs with it: x or the drive "
                "has the wrong sign, the run is left out")
        for run, _, _ in turned
    )  # fmt: skip
    return Columns(tuple(run for run in seen.runs if run.label not in labels), findings)


def _unit_of_x(seen: _Seen) -> Columns | None:
    """Find positions that are too large for what the drive could do."""
    least = _MOVES * min(seen.noise, seen.stated)
    ratios = seen.ratios(least)
    far = False
    if ratios.size and 2 * ratios.size >= len(seen.pairs):
        low, middle, high = np.quantile(ratios, [0.25, 0.5, 0.75])
        far = bool(middle > _TOO_FAR and low > _RUNS_TOO_FAR and high < _ALIKE * low)
    units = ANGLES if "gravity_torque" in seen.nominal else LENGTHS
    near = _near(units, float(np.median(ratios))) if ratios.size else []
    likely = near[0] if near else ""
    far = far and _in_a_unit(seen, ratios, least, units.get(likely))
    if not far and seen.pace <= _TOO_FAST:
        return None
    much = f"{np.median(ratios):.3g} times as far as the nominal head" if ratios.size else "too far"
    options = " or ".join(f"--unit x={unit}" for unit in near)
    meant = f"it seems to be in {' or '.join(near)} ({options})" if near else "which unit is it in?"
    note = (
        f"x moves {much}, which no listed effect makes: {meant}; no cause is looked for before the "
        "units of x, of the drive and of the nominal mass are right"
    )
    return seen.whole("x", "unit", note, likely)


def _in_a_unit(seen: _Seen, ratios: Floats, least: float, factor: float | None) -> bool:
    """Return whether positions that are too large are so by a unit rather than by an effect.

    Where friction all but holds the nominal head, an error of it, of the mass or of a slope makes
    any travel, but by another course, or another one in each run.
    """
    beyond = float(np.median(seen.eased().ratios(least)))
    if beyond > _FAR_BEYOND and seen.course > _SAME_COURSE:
        return True
    low, middle, high = np.quantile(ratios, [0.25, 0.5, 0.75])
    one = high < _ONE_FACTOR * low and middle < _SLIDES * beyond
    if factor is None or not (one or beyond > _BEYOND):
        return False
    shrunk = [replace(run, channels={"x": run.channels["x"] / factor}) for run in seen.runs]
    return replace(seen, runs=shrunk).accounted > _SWAPPED


def _near(units: Mapping[str, float], factor: float) -> list[str]:
    """Return the units whose factors are near, the nearest first.

    Of an inch and a centimetre no model tells which: effects change the travel by more.
    """
    apart = {name: abs(float(np.log(factor / one))) for name, one in units.items()}
    return [name for name in sorted(apart, key=lambda unit: apart[unit]) if apart[name] < _NEAR]


def _unit_of_drive(seen: _Seen) -> Columns | None:
    """Find drives far beyond what holds the head, or far below it while the head moves."""
    held, swings = [], seen.nominal.get("gravity_torque", 0.0)
    for run, _, _ in seen.pairs:
        drive = float(np.quantile(np.abs(run.drive), _STRONG)) * seen.nominal["gain"]
        held.append((drive, resistance(run, seen.nominal)))
    weak = max(drive / holds if holds > 0.0 else np.inf for drive, holds in held)
    if weak < _TOO_WEAK and 2 * len(seen.moving) >= len(seen.pairs):
        note = (
            f"the head moves, and the drive is never more than {weak:.2g} of what holds it: which "
            "unit is it in? No cause is looked for before the unit or the gain of the drive is "
            "right"
        )
        return seen.whole("drive", "unit", note)
    strong = max(d / (h + swings) if h + swings > 0.0 else 0.0 for d, h in held)
    if strong <= _TOO_STRONG or seen.pace >= _TOO_SLOW:
        return None
    fits = {}
    for unit, factor in FORCES.items():
        runs = [replace(run, drive=run.drive / factor) for run in seen.runs]
        fits[unit] = replace(seen, runs=runs).accounted
    likely = max(fits, key=lambda unit: fits[unit])
    if fits[likely] < _AS_IS:
        # Friction that grows with the speed holds such a head, too.
        return None
    note = (
        f"the drive is {strong:.3g} times what holds the head, which hardly accelerates: it "
        f"seems to be in {likely} (--unit drive={likely}); no cause is looked for before the unit "
        "of the drive is right"
    )
    return seen.whole("drive", "unit", note, likely)
