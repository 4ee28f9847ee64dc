"""Numbers of friction models that others published, or that follow from theirs,
by simulation.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

import locosweep as ls

# The standard set of the LuGre model (Canudas de Wit and others 1995, Table 1).
STANDARD: dict[str, Any] = {
    "mass": 1.0,
    "gravity": 1.0,
    "mu_coulomb": 1.0,
    "mu_static": 1.5,
    "stribeck_speed": 1e-3,
    "bristle_stiffness": 1e5,
    "bristle_damping": math.sqrt(1e5),
    "viscous": 0.4,
}
# A mass pulled by a spring, as in Figure 5 of that paper.
PULLED: dict[str, Any] = {"spring_stiffness": 2.0, "pull_speed": 0.1}
UNIT: dict[str, Any] = {"mass": 1.0, "gravity": 1.0}


def digits(value: float, published: str) -> None:
    """Compare to as many digits as were published."""
    places = len(published.partition(".")[2])
    assert value == pytest.approx(float(published), abs=0.5000001 * 10.0**-places), published


def values(names: str, law: str, drive: str = "constant", **given: Any) -> list[Any]:
    wanted = names.split()
    result = ls.sweep(wanted, law=law, drive=drive, **given)
    return [result[name] if result[name].ndim else float(result[name]) for name in wanted]


def crossings(t: NDArray[np.float64], v: NDArray[np.float64], level: float) -> list[float]:
    """When a speed rises through a level."""
    rises = np.flatnonzero((v[:-1] < level) & (v[1:] >= level))
    out = []
    for i in rises:
        near = slice(max(i - 3, 0), i + 5)
        roots = CubicSpline(t[near], v[near]).solve(level, extrapolate=False)
        out += [float(root) for root in roots if t[i] <= root <= t[i + 1]]
    return out


def test_lugre_stick_slip() -> None:
    # Number 3: Radau at three tolerances gave these.
    given = {**STANDARD, **PULLED, "duration": 30.0, "tolerance": 1e-9}
    x, peak = values("final_position peak_motion", "lugre", **given)
    run = ls.simulate(law="lugre", samples=60001, **given)
    starts = crossings(run.t, run.v, 0.02)
    digits(starts[0], "7.47855")
    assert len(starts) == 4
    for period in np.diff(starts):
        assert period == pytest.approx(6.36272, abs=2e-5)
    digits(peak, "0.369816")
    digits(x, "2.5451019")


@pytest.mark.parametrize(
    ("viscous", "slip", "stick", "period", "peak", "step"),
    [
        (0.0, "2.6112593", "5.0000000", "7.6112593", "0.4674235", "0.7611259"),
        (0.4, "2.8137437", "3.6401890", "6.4539327", "0.3768190", None),
    ],
)
def test_stick_slip_with_events(
    viscous: float, slip: str, stick: str, period: str, peak: str, step: str | None
) -> None:
    # Number 4: static 1.5 N and Coulomb 1 N, the spring of number 3.
    levels = {**UNIT, "mu_static": 1.5, "mu_coulomb": 1.0, "viscous": viscous}
    times = np.array([9.0, 12.0, 16.0])
    names = "stuck_time stick_phases final_position peak_motion"
    rest, phases, x, top = values(
        names, "static_viscous", duration=times, time_step=1e-3, **levels, **PULLED
    )
    # The runs end in the first slip, the rest after it, and the second slip.
    assert list(phases) == [0.0, 1.0, 1.0]
    assert rest[0] == pytest.approx(7.5, abs=1e-9)
    first_slip = times[1] - rest[1]
    digits(first_slip, slip)
    digits(rest[2] - rest[0], stick)
    digits(first_slip + rest[2] - rest[0], period)
    digits(top[2], peak)
    if step is not None:
        digits(x[1], step)


@pytest.mark.parametrize(
    ("rate", "force"),
    [
        (1, "1.43241"),
        (2, "1.39442"),
        (5, "1.31321"),
        (10, "1.21995"),
        (20, "1.09861"),
        (50, "1.00747"),
    ],
)
def test_break_away_force_over_rate(rate: float, force: str) -> None:
    # Number 5: the first peak of friction under a force that rises evenly. What
    # friction is follows from drive and acceleration.
    given = {**STANDARD, "duration": 1.7 / rate, "drive_rate": rate, "drive_amplitude": 100.0}
    run = ls.simulate(law="lugre", drive="ramp", samples=20001, tolerance=1e-10, **given)
    friction = run.force - CubicSpline(run.t, run.v)(run.t, 1)
    peaks = np.flatnonzero((friction[1:-1] > friction[:-2]) & (friction[1:-1] >= friction[2:])) + 1
    i = next(int(i) for i in peaks if friction[i] > 0.9)
    digits(friction[i], force)


@pytest.mark.parametrize(
    ("share", "place"), [(0.5, "10.3972"), (0.8, "24.1416"), (0.95, "44.9360")]
)
def test_slow_presliding(share: float, place: str) -> None:
    # Number 6: F = F_S (1 - e^(-sigma_0 x/F_S)), here under a force that takes
    # hours to rise, so that damping and inertia take no part.
    rate = 1e-5
    given = {**STANDARD, "duration": 1.5 * share / rate, "drive_rate": rate}
    (x,) = values("final_position", "lugre", "ramp", drive_amplitude=2.0, tolerance=1e-8, **given)
    assert 1e6 * x == pytest.approx(float(place), rel=2e-5)


def test_dahl_loop() -> None:
    # Number 6: a closed loop of 1e-5 m to either side has its tips at tanh 1 and
    # costs 9.536234e-6 J; driven here by the force of its tips.
    tip = math.tanh(1.0)
    digits(tip, "0.7615942")
    given: dict[str, Any] = {**UNIT, "mu_coulomb": 1.0, "bristle_stiffness": 1e5, "viscous": 30.0}
    given |= {"drive_amplitude": tip, "drive_frequency": 1e-3, "tolerance": 1e-9}
    times = 1000 * np.array([2.0, 2.25, 2.75, 3.0])
    x, heat, stored = values(
        "final_position dissipated stored", "dahl", "sine", duration=times, **given
    )
    assert (x[1] - x[2]) / 2 == pytest.approx(1e-5, rel=1e-5)
    spent = heat[3] - heat[0] + stored[3] - stored[0]
    assert spent == pytest.approx(9.536234e-6, rel=2e-5)


@pytest.mark.parametrize(
    ("law", "until", "place", "published"),
    [
        ("lugre", 5.0, 79.95e-6, 0.01e-6),
        ("lugre", 10.0, 155.29e-6, 0.01e-6),
        ("elasto_plastic", 5.0, 3.74887e-6, 1e-11),
        ("elasto_plastic", 10.0, 3.74887e-6, 1e-11),
    ],
)
def test_drift(law: str, until: float, place: float, published: float) -> None:
    # Number 7: a force below break-away that varies; only LuGre's bristles creep.
    given = dict(STANDARD)
    if law == "elasto_plastic":
        given["elastic_share"] = 0.7
    swing = {"drive_force": 0.4, "drive_amplitude": 0.25, "drive_frequency": 5.0}
    (x,) = values("final_position", law, "sine", duration=until, tolerance=1e-8, **given, **swing)
    assert x == pytest.approx(place, abs=0.51 * published)


@pytest.mark.parametrize(
    ("law", "speed"), [("tanh", 0.549306), ("threlfall", 0.231049), ("coulomb", 0.0)]
)
def test_creep_on_a_slope(law: str, speed: float) -> None:
    # Number 8: half of what friction could hold. A smooth law creeps down at a
    # share of its transition speed for ever; a dry one holds.
    slope, transition = 12.0, 1e-3
    hold = 2 * math.tan(math.radians(slope))
    given: dict[str, Any] = {"slope_deg": slope, "mu_coulomb": hold, "duration": 2.0}
    if law != "coulomb":
        given |= {"transition_speed": transition, "tolerance": 1e-9}
    if law == "tanh":
        given["mu_static"] = hold
    x, v, stuck = values("final_position final_speed stuck_time", law, **given)
    if law == "coulomb":
        assert (x, v, stuck) == (0.0, 0.0, 2.0)
    else:
        assert v == pytest.approx(-speed * transition, abs=0.51e-6 * transition)
        assert x == pytest.approx(2.0 * v, rel=1e-3)


@pytest.mark.parametrize(
    ("viscous", "time", "path"),
    [(0.5, "0.4404446", "0.1907190"), (0.0, "0.6795727", "0.3397863")],
)
def test_stop(viscous: float, time: str, path: str) -> None:
    # Number 10: the robot of the paper slides from 1 m/s to rest.
    given: dict[str, Any] = {"mu_coulomb": 0.15, "viscous": viscous, "duration": 2.0}
    given["start_speed"] = 1.0
    level = 0.15 * 0.271 * 9.81
    x, stuck, phases, heat = values(
        "final_position stuck_time stick_phases dissipated", "coulomb_viscous", **given
    )
    assert phases == 1.0
    # Published for F_C = 0.39878 N, which is rounded in its fifth digit.
    scale = 0.39878 / level
    assert 2.0 - stuck == pytest.approx(float(time), rel=2 * abs(scale - 1) + 2e-7)
    assert x == pytest.approx(float(path), rel=2 * abs(scale - 1) + 2e-7)
    rounded = {**given, "mu_coulomb": 0.15 * scale}
    x, stuck = values("final_position stuck_time", "coulomb_viscous", **rounded)
    digits(2.0 - stuck, time)
    digits(x, path)
    assert heat == pytest.approx(0.271 / 2, rel=1e-12)


def test_coulomb_oscillator() -> None:
    # Number 11: the amplitude falls by 2 F_C/k at each turn.
    given: dict[str, Any] = {
        **UNIT,
        "mu_coulomb": 1.0,
        "spring_stiffness": 100.0,
        "start_position": 0.055,
    }
    turns = np.arange(1, 4) * math.pi / 10
    names = "final_position stuck_time stick_phases"
    x, stuck, phases = values(
        names, "coulomb", duration=np.append(turns, 2.0), time_step=1e-3, **given
    )
    assert x[:3] == pytest.approx([-0.035, 0.015, 0.005], abs=1e-11)
    assert x[3] == pytest.approx(0.005, abs=1e-11)
    assert 2.0 - stuck[3] == pytest.approx(3 * math.pi / 10, abs=1e-9)
    assert phases[3] == 1.0


def test_modelica_example() -> None:
    # Number 12: stop 1 of the example Friction, from rest.
    given: dict[str, Any] = {
        **UNIT,
        "viscous": 1.0,
        "mu_coulomb": 5.0,
        "mu_static": 15.0,
        "modelica_decay": 2.0,
    }
    given |= {"drive_amplitude": 25.0, "drive_frequency": 0.25, "time_step": 1e-4}
    stuck, peak, place = values(
        "stuck_time peak_motion peak_position", "modelica", "sine", duration=2.5, **given
    )
    digits(stuck, "0.4096655")
    digits(peak, "11.0176487")
    digits(place, "13.4555881")
    run = ls.simulate(
        law="modelica", drive="sine", duration=2.5, samples=25001, tolerance=1e-12, **given
    )
    # Spans away from both events, over which the speed is smooth.
    fast = (run.t > 1.3) & (run.t < 1.8)
    (top,) = CubicSpline(run.t[fast], run.v[fast]).derivative().roots(extrapolate=False)
    # At the top force and friction are equal, so that its time follows from the
    # speed: 25 sin(pi t/2) = 5 + v + 10 e^(-2 v) on the falling side.
    against = 5 + peak + 10 * math.exp(-2 * peak)
    assert top == pytest.approx(2 - math.asin(against / 25) * 2 / math.pi, abs=1e-7)
    digits(float(top), "1.55728")
    # The speed is still above 0 at the last of these, less than 0.1 ms before.
    late = (run.t > 2.43) & (run.way > 0)
    last = run.t[late][-1]
    zero = min(t for t in CubicSpline(run.t[late], run.v[late]).roots() if t >= last)
    digits(float(zero), "2.4426906")


@pytest.mark.parametrize(("inertia", "time"), [(1.0, "4.60070"), (0.0, "4.65399")])
def test_belt_that_accelerates(inertia: float, time: str) -> None:
    # Number 13: a mass on a belt of speed V sin(w t). Seen from the belt it
    # slides by u on ground at rest, and spring, damper and the belt's own
    # acceleration together are a sine about a constant force:
    #   -k V/w (1 - cos w t) - d V sin w t - m V w cos w t.
    mass, spring, damper, speed, circle = 20.0, 70.0, 10.0, 3.0, 2 * math.pi / 50
    across = spring * speed / circle - inertia * mass * speed * circle
    along = -damper * speed
    given = {"mass": mass, "gravity": 9.81, "mu_coulomb": 1.5, "time_step": 1e-3}
    given |= {"spring_stiffness": spring, "spring_damping": damper, "duration": 4.8}
    given |= {"drive_force": -spring * speed / circle, "drive_frequency": 1 / 50}
    given["drive_amplitude"] = math.hypot(along, across)
    given["drive_phase_deg"] = math.degrees(math.atan2(across, along))
    stuck, v = values("stuck_time final_speed", "coulomb", "sine", **given)
    digits(stuck, time)
    assert v < 0
