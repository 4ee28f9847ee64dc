"""Drives that swing fast against the time step: break-aways are found, and steps that
do not follow the drive say so. The reference is an integration by SciPy whose waits are
watched at a hundred points per period of the highest frequency.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
import pytest
from scipy.optimize import brentq

import locosweep as ls

if TYPE_CHECKING:
    from collections.abc import Callable

    Force = Callable[[float], float]

MASS, GRAVITY = 0.271, 9.81
STATIC, COULOMB = 0.4 * MASS * GRAVITY, 0.3 * MASS * GRAVITY
# Excites break-away by 12 % of the static friction.
SWING = {"drive_amplitude": 1.276, "drive_force": 0.2}
GIVEN = {"mass": MASS, "mu_static": 0.4, "mu_coulomb": 0.3, **SWING}


def sine(frequency: float) -> tuple[Force, Force, Force]:
    """Force, its integral and the integral of that."""
    w = 2 * math.pi * frequency
    a, f = SWING["drive_amplitude"], SWING["drive_force"]
    return (
        lambda t: f + a * math.sin(w * t),
        lambda t: f * t - a / w * math.cos(w * t),
        lambda t: f * t * t / 2 - a / w**2 * math.sin(w * t),
    )


def multisine(frequency: float, harmonics: int) -> tuple[Force, Force, Force]:
    """Schroeder's phases, see the drive's formula."""
    a = SWING["drive_amplitude"] * math.sqrt(2 / harmonics)
    f = SWING["drive_force"]
    j = np.arange(1, harmonics + 1)
    w, phase = 2 * math.pi * frequency * j, -math.pi * j * (j - 1) / harmonics
    return (
        lambda t: f + a * float(np.sin(w * t + phase).sum()),
        lambda t: f * t - a * float((np.cos(w * t + phase) / w).sum()),
        lambda t: f * t * t / 2 - a * float((np.sin(w * t + phase) / w**2).sum()),
    )


def first(function: Force, start: float, end: float, spacing: float) -> float | None:
    """First time at which a function is positive, from one where it is not."""
    count = max(math.ceil((end - start) / spacing), 1)
    low = start
    for i in range(1, count + 1):
        high = start + (end - start) * i / count
        if function(high) > 0:
            return float(brentq(function, low, high, xtol=1e-18, rtol=1e-15))
        low = high
    return None


def final_position(drive: tuple[Force, Force, Force], highest: float, duration: float) -> float:
    """Position after a run from rest: speed and path in closed form from event to event."""
    force, impulse, path = drive
    spacing = 0.01 / highest
    t, x, way = 0.0, 0.0, 0
    while True:
        if way == 0:
            found = first(lambda s: abs(force(s)) - STATIC, t, duration, spacing)
            if found is None:
                return x
            t, way = found, int(math.copysign(1, force(found)))
        begin, sign = t, way

        def speed(s: float, begin: float = begin, sign: int = sign) -> float:
            return (impulse(s) - impulse(begin) - sign * COULOMB * (s - begin)) / MASS

        # A speed just after the start is rounding.
        stop = first(lambda s, sign=sign: -sign * speed(s), t + 0.5 * spacing, duration, spacing)
        end = duration if stop is None else stop
        span = end - begin
        x += (
            path(end) - path(begin) - impulse(begin) * span - sign * COULOMB * span * span / 2
        ) / MASS
        if stop is None:
            return x
        t = stop
        push = force(t)
        way = int(math.copysign(1, push)) if abs(push) > STATIC else 0


def run(drive: str, method: str, **given: float) -> tuple[float, str]:
    result = ls.sweep(
        "final_position", law="static_coulomb", drive=drive, method=method, **GIVEN, **given
    )
    status = ls.Status(int(result.status_of("final_position")))
    return float(result.values), status.name.lower()


FREQUENCIES = [30.0, 50.0, 111.0, 200.0, 333.3, 499.0, 500.0, 501.0, 997.0, 1000.0, 2500.0]


@pytest.mark.parametrize("frequency", FREQUENCIES)
def test_break_away_under_a_fast_sine(frequency: float) -> None:
    expected = final_position(sine(frequency), frequency, 0.2)
    assert expected > 0
    more = {"drive_frequency": frequency, "duration": 0.2}
    adaptive, status = run("sine", "dormand_prince", **more, tolerance=1e-9)
    assert status == "ok"
    assert adaptive == pytest.approx(expected, rel=1e-6)
    # The fixed step of 1 ms follows the drive, or says that it does not.
    fixed, status = run("sine", "runge_kutta", **more)
    assert status == ("ok" if frequency <= 250 else "unresolved")
    if status == "ok":
        assert fixed == pytest.approx(expected, rel=0.02)
    fine, status = run("sine", "runge_kutta", **more, time_step=1 / (40 * frequency))
    assert status == "ok"
    assert fine == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("frequency", [10.0, 61.0, 125.0])
def test_break_away_under_a_fast_multisine(frequency: float) -> None:
    expected = final_position(multisine(frequency, 8), 8 * frequency, 0.2)
    more = {"drive_frequency": frequency, "drive_harmonics": 8.0, "duration": 0.2}
    adaptive, status = run("multisine", "dormand_prince", **more, tolerance=1e-9)
    assert status == "ok"
    assert adaptive == pytest.approx(expected, rel=1e-6)
    status = run("multisine", "runge_kutta", **more)[1]
    assert status == ("ok" if 8 * frequency <= 250 else "unresolved")


def test_a_step_of_one_period_does_not_answer() -> None:
    """Each step looks at the same phase of the drive, so break-away went unseen."""
    more = {"drive_frequency": 1000.0, "duration": 0.2}
    assert run("sine", "runge_kutta", **more)[1] == "unresolved"
    assert run("sine", "dormand_prince", **more)[0] == pytest.approx(2.96e-5, rel=5e-3)


def test_a_chirp_is_followed_while_the_step_allows() -> None:
    more = {"drive_frequency": 5.0, "duration": 0.5}
    slow, status = run("chirp", "runge_kutta", **more, drive_frequency_end=60.0)
    assert status == "ok"
    assert slow == pytest.approx(
        run("chirp", "dormand_prince", **more, drive_frequency_end=60.0, tolerance=1e-9)[0],
        rel=1e-2,
    )
    assert run("chirp", "runge_kutta", **more, drive_frequency_end=900.0)[1] == "unresolved"
    # Backward through the frequencies as well.
    back = {"drive_frequency": 900.0, "drive_frequency_end": 5.0, "duration": 0.5}
    assert run("chirp", "runge_kutta", **back)[1] == "unresolved"


def test_a_drive_that_friction_holds_needs_no_short_step() -> None:
    """At rest the drive is looked at, not stepped through."""
    more = {"drive_frequency": 3000.0, "drive_amplitude": 0.8, "duration": 0.2}
    given = {**GIVEN, **more}
    for method in ("runge_kutta", "dormand_prince"):
        result = ls.sweep(
            ["final_position", "stuck_time"],
            law="static_coulomb",
            drive="sine",
            method=method,
            **given,
        )
        assert float(result["final_position"]) == 0.0
        assert float(result["stuck_time"]) == pytest.approx(0.2)
    # Beyond 64 periods a step it is not.
    result = ls.sweep(
        "final_position",
        law="static_coulomb",
        drive="sine",
        **{**given, "drive_frequency": 1e5},
    )
    assert int(result.status_of("final_position")) == ls.Status.UNRESOLVED


@pytest.mark.parametrize(
    ("law", "method"), [("tanh", "runge_kutta"), ("lugre", "rosenbrock_fixed")]
)
def test_other_laws_in_fixed_steps(law: str, method: str) -> None:
    for frequency, status in ((100.0, ls.Status.OK), (1000.0, ls.Status.UNRESOLVED)):
        result = ls.sweep(
            "final_position",
            law=law,
            drive="sine",
            method=method,
            **GIVEN,
            transition_speed=0.5,
            bristle_stiffness=1e3,
            bristle_damping=10.0,
            drive_frequency=frequency,
            duration=0.2,
        )
        assert int(result.status_of("final_position")) == status


def test_a_grazing_break_away_is_found() -> None:
    """The force exceeds static friction by 1e-6 of it at the sine's peak, between looks."""
    for frequency in (77.7, 113.0, 123.4):
        amplitude = STATIC * (1 + 1e-6)
        given = {**GIVEN, "drive_force": 0.0, "drive_amplitude": amplitude}
        result = ls.sweep(
            "stuck_time",
            law="static_coulomb",
            drive="sine",
            **given,
            drive_frequency=frequency,
            duration=0.3 / frequency,
        )
        waited = math.asin(1 / (1 + 1e-6)) / (2 * math.pi * frequency)
        assert float(result.values) == pytest.approx(waited, rel=1e-6)
