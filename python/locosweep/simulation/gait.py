"""One whole robot through its gait: who moves, slips and holds, with what force and power."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from locosweep import _core, memory
from locosweep.engine import whole
from locosweep.errors import InputError, SolveError
from locosweep.grid import real_array
from locosweep.registry import Status, unknown

if TYPE_CHECKING:
    from collections.abc import Sequence

    import polars as pl
    from numpy.typing import NDArray

    from locosweep._core import CancelToken, Gait, GaitParameter
    from locosweep.files.robot import Robot

    Floats = NDArray[np.float64]
    Value = float | Sequence[float]

UNITS = {
    "t": "s",
    "phase": "1",
    "x": "m",
    "v": "m/s",
    "force": "N",
    "sliding": "1",
    "heap": "m",
    "power": "W",
    "propulsive": "N",
}
"""Units of the arrays of a run."""

_SAID = ("velocity", "advance", "slip_max", "time", "actuator_peak", "power_mean")
"""Numbers of a run that one looks at first."""

_UNSOLVED = {Status.NOT_FINITE, Status.UNRESOLVED, Status.DIVERGED, Status.TOO_MANY_STEPS}
"""Statuses that speak of the solver, not of a robot that this gait does not move."""


def gaits() -> list[Gait]:
    """List the gaits that a whole robot can be simulated with.

    Returns
    -------
    list of Gait
        Records with ``name`` and ``meaning``.

    Examples
    --------
    >>> import locosweep as ls
    >>> [gait.name for gait in ls.gaits()]
    ['single', 'block', 'window', 'wave', 'inchworm', 'concertina']
    """
    return _core.gaits()


@cache
def gait_parameters() -> dict[str, GaitParameter]:
    """Map the name of every parameter of a run to its record.

    A record has ``parameter`` (as in ``locosweep.parameters()``), ``part`` (run, segment
    or joint) and the ``table`` and ``key`` of a gait file.

    Examples
    --------
    >>> from locosweep.simulation.gait import gait_parameters
    >>> [name for name, p in gait_parameters().items() if p.part == "joint"]
    ['drive_limit', 'speed_limit', 'stroke', 'joint_stiffness', 'joint_damping']
    """
    return {record.parameter.name: record for record in _core.gait_parameters()}


@dataclass(frozen=True, repr=False)
class GaitRun:
    """Motion of a robot of N segments. Segment 0 is the head; joint j joins j and j + 1.

    Attributes
    ----------
    gait : str
        Name of the gait.
    values : dict of str to float or tuple of float
        All parameters; a tuple has a value for each segment or joint.
    results : dict of str to float
        Numbers of the whole run by the names of ``summary``.
    slip : ndarray
        Way in m that each segment slides backward per cycle, shape (N,).
    t : ndarray
        Times in s, shape (T,).
    phase : ndarray of int
        Phase of the cycle from 0, shape (T,).
    x, v : ndarray
        Displacement in m and speed in m/s, shape (T, N).
    force : ndarray
        Force of each joint's actuator in N, positive where it pushes apart, shape
        (T, N - 1).
    sliding : ndarray of int
        1 slides forward, 0 is anchored, -1 slides backward; shape (T, N).
    heap : ndarray
        Fresh ground in m whose lubricant each segment pushes along, swept since its last
        rest or turn; 0 without lubricant. Shape (T, N).
    power : ndarray
        Electrical power of all motors in W, shape (T,).
    propulsive : ndarray
        Force of the joints on the moving segments in N, shape (T,).
    """

    gait: str
    values: dict[str, float | tuple[float, ...]]
    results: dict[str, float]
    slip: Floats
    t: Floats
    phase: NDArray[np.int64]
    x: Floats
    v: Floats
    force: Floats
    sliding: NDArray[np.int8]
    heap: Floats
    power: Floats
    propulsive: Floats
    units: dict[str, str] = field(default_factory=lambda: dict(UNITS), repr=False)

    @property
    def summary(self) -> pl.DataFrame:
        """The run's numbers: output, value, unit and meaning, a row each."""
        import polars as pl

        records = _core.gait_outputs()
        return pl.DataFrame(
            {
                "output": [record.name for record in records],
                "value": [self.results[record.name] for record in records],
                "unit": [record.unit for record in records],
                "meaning": [record.meaning for record in records],
            }
        )

    def to_polars(self) -> pl.DataFrame:
        """Return the trace as a long table, a row for each time and segment.

        Columns are t, phase, segment, x, v, sliding, heap, joint_force (of the joint
        behind the segment; none for the rear), power and propulsive, in the units
        of ``units``.
        """
        import polars as pl

        times, count = self.x.shape
        columns = {
            "t": np.repeat(self.t, count),
            "phase": np.repeat(self.phase, count),
            "segment": np.tile(np.arange(count), times),
            "x": self.x.ravel(),
            "v": self.v.ravel(),
            "sliding": self.sliding.ravel(),
            "heap": self.heap.ravel(),
        }
        rear = np.full((times, 1), np.nan)
        behind = pl.Series("joint_force", np.hstack([self.force, rear]).ravel()).fill_nan(None)
        shared = {name: np.repeat(getattr(self, name), count) for name in ("power", "propulsive")}
        return pl.DataFrame({**columns, "joint_force": behind, **shared})

    def __repr__(self) -> str:
        times, count = self.x.shape
        lines = [f"GaitRun: {count} segments in gait '{self.gait}', {times} samples"]
        units = {record.name: record.unit for record in _core.gait_outputs()}
        for name in _SAID:
            unit = "" if units[name] == "1" else f" {units[name]}"
            lines.append(f"  {name}: {self.results[name]:.4g}{unit}")
        lines.append(f"  {len(units) - len(_SAID)} more in .summary; motion in .t, .x, .v, .force")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        from locosweep.plot.html import gait_card

        return gait_card(self)


def run_gait(
    gait: str = "single",
    *,
    robot: Robot | None = None,
    samples: int = 601,
    every: float | None = None,
    memory_limit: int | None = None,
    token: CancelToken | None = None,
    **values: Value,
) -> GaitRun:
    """Simulate one whole robot through the cycles of a gait.

    Segments in a line are joined by prismatic actuators. Who sticks and who slides
    is decided for all of them together at every instant, so anchors that cannot
    hold slide back. Ideal joints run from event to event without a step size,
    elastic ones (``joint_stiffness``) in steps of ``time_step``. Friction that falls
    with the speed and lubricant that piles up need elastic joints.

    Parameters
    ----------
    gait : str
        Name from ``locosweep.gaits()``.
    robot : Robot, optional
        Gives the parameters that are not in `values`; those of its parameters that
        no gait takes are left out (a simulated anchor always carries its weight).
    samples : int
        Evenly spread times at which the motion is kept, from 2 upward.
    every : float, optional
        Seconds between them, in place of `samples`.
    memory_limit : int, optional
        Bytes; a longer trace is refused. Default 80 % of the free memory.
    token : CancelToken, optional
        Lets another thread stop the run, which then raises ``Cancelled``.
    **values
        Parameters by name (``locosweep.simulation.gait.gait_parameters()``); segments,
        mu_static and mu_coulomb have no default. Those of segments and joints may
        be sequences with a value for each, from the head backward.

    Returns
    -------
    GaitRun

    Raises
    ------
    InputError
        Unknown names, values out of range, sequences of another length, or a robot
        that this gait does not move; the message says why.
    SolveError
        The motion could not be computed.
    Cancelled
        The token was used.

    Examples
    --------
    >>> import locosweep as ls
    >>> run = ls.run_gait("single", segments=4, mu_static=0.5, mu_coulomb=0.3,
    ...                   drive_limit=0.85, break_away=0, impact=0, cycles=2)
    >>> run.x.shape, run.sliding.shape, run.force.shape
    ((601, 4), (601, 4), (601, 3))
    >>> round(run.results["advance"], 12)
    0.02
    """
    named = [record.name for record in gaits()]
    if gait not in named:
        raise unknown("gait", gait, named)
    shared, own, joints = _split(_given(robot, values))
    lists = (list(shared.items()), list(own.items()), list(joints.items()))
    count = whole("samples", samples) or 0
    if count < 2:
        raise InputError(f"samples is {samples}: allowed is a whole number from 2 upward")
    first = _core.gait_run(gait, *lists, None, token)
    results = dict(first.results)
    if first.status:
        status = Status(first.status)
        kind = SolveError if status in _UNSOLVED else InputError
        said = f"gait '{gait}': {status.sentence} ({status.name.lower()})"
        if status is Status.DRIVE_TOO_WEAK:
            # The closed forms, which most users come from, leave static friction out.
            eased = list((shared | {"break_away": 0.0}).items())
            if not _core.gait_run(gait, eased, *lists[1:], None, token).status:
                said += (
                    "; break_away=0 starts segments against Coulomb friction, as closed forms do"
                )
        raise kind(said)
    if every is None:
        # A little less, so that no rounding puts the last sample behind the end.
        every = results["time"] / (count - 1) * (1.0 - 1e-12)
    if not 0 < every < math.inf:
        raise InputError(f"every is {every!r} s: allowed is a number above 0")
    segments = len(first.slip)
    # Eight numbers of a sample are shared, five belong to each segment.
    needed = 8 * (5 * segments + 8) * (results["time"] / every + 2)
    memory.check(int(min(needed, 2.0**62)), memory_limit, "the trace", "keep fewer samples")
    trace = _core.gait_run(gait, *lists, every, token)
    times = len(trace.t)
    heap = trace.heap if len(trace.heap) else np.zeros(times * segments)
    defaults = {name: record.parameter.default for name, record in gait_parameters().items()}
    used: dict[str, float | tuple[float, ...]] = {
        **{name: value for name, value in defaults.items() if value is not None},
        **shared,
        **{name: tuple(several) for name, several in (own | joints).items()},
    }
    return GaitRun(
        gait=gait,
        values=used,
        results=results,
        slip=trace.slip,
        t=trace.t,
        phase=trace.phase,
        x=trace.x.reshape(times, segments),
        v=trace.v.reshape(times, segments),
        force=trace.force.reshape(times, segments - 1),
        sliding=trace.slide.reshape(times, segments),
        heap=heap.reshape(times, segments),
        power=trace.power,
        propulsive=trace.propulsive,
    )


def _given(robot: Robot | None, values: dict[str, Value]) -> dict[str, Value]:
    known = gait_parameters()
    for name in values:
        if name not in known:
            raise unknown("parameter of a gait", name, known)
    if robot is None:
        return values
    if "surface.coulomb_force" in robot.other and "mu_coulomb" not in values:
        raise InputError(
            "the robot has coulomb_force: a gait needs mu_coulomb, as friction follows load"
        )
    return {n: v for n, v in robot.parameters.items() if n in known} | values


def _split(
    values: dict[str, Value],
) -> tuple[dict[str, float], dict[str, list[float]], dict[str, list[float]]]:
    """Values that hold for all, those of segments, those of joints."""
    shared: dict[str, float] = {}
    parts: dict[str, dict[str, list[float]]] = {"segment": {}, "joint": {}}
    for name, value in values.items():
        record = gait_parameters()[name]
        array = real_array(name, value)
        if array.ndim == 0:
            shared[name] = float(array)
        elif array.ndim > 1 or record.part == "run":
            allowed = "one number" if record.part == "run" else f"a number for each {record.part}"
            raise InputError(f"{name} has the shape {array.shape}: allowed is {allowed}")
        else:
            parts[record.part][name] = array.tolist()
    return shared, parts["segment"], parts["joint"]
