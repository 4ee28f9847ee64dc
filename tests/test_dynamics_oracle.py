# ruff: noqa: S311, T201 -- cases are random but repeatable; the worst errors are printed
"""Trajectories against independent ones: SciPy with a stick logic of its own, and
dense scans for events over many cases; then events built to be missed.
"""

from __future__ import annotations

import math
import random
from fractions import Fraction
from typing import Any, ClassVar

import numpy as np
import pytest

import dynamics_scipy as reference
import locosweep as ls
from dynamics_exact import Case
from dynamics_laws import BRISTLE, DRY, KINDS, SMOOTH, Plant, random_plant
from dynamics_scan import Scan, pulse_ends
from locosweep import _core

STEP = 1e-4
STATES = {"lugre": 1, "dahl": 1, "elasto_plastic": 1, "gonthier": 2, "maxwell_slip": 4}
# Laws with a corner in the curve, where steps of any order fall to a low one.
KINKED = ("threlfall", "bengisu_akay")


def one(names: str, plant: Plant, **options: Any) -> list[float]:
    """One point of a sweep."""
    wanted = names.split()
    given = {**plant.given, **options.pop("more", {})}
    result = ls.sweep(
        wanted, law=plant.law, drive=plant.drive, table=plant.table, **given, **options
    )
    return [float(result[name]) for name in wanted]


class TestAgainstSciPy:
    """Final place and speed relative to the largest of the run, time at rest to
    the length of the run, work and heat to themselves.
    """

    @pytest.mark.slow
    def test_dry_laws(self) -> None:
        rng = random.Random(5)
        laws = (*DRY, "directional", "bo_pavelescu", "modelica")
        settings: dict[str, dict[str, Any]] = {
            "runge_kutta": {"time_step": STEP},
            "dormand_prince": {"tolerance": 1e-11},
        }
        worst: dict[str, dict[str, float]] = {method: {} for method in settings}
        miscounted = []
        stops = 0
        for i in range(220):
            plant = random_plant(rng, laws[i % len(laws)])
            run = reference.dry(plant)
            names = "final_position final_speed stuck_time stick_phases work_in dissipated"
            stops += run.sticks
            moved = abs(run.work) + run.heat
            for method, setting in settings.items():
                x, v, stuck, sticks, work, heat = one(names, plant, method=method, **setting)
                errors = {
                    "x": abs(x - run.x) / max(run.far, 1e-9),
                    "v": abs(v - run.v) / max(run.fast, 1e-9),
                    "rest": abs(stuck - run.stuck) / plant.p["duration"],
                    "work": abs(work - run.work) / max(moved, 1e-9),
                    "heat": abs(heat - run.heat) / max(moved, 1e-9),
                }
                known = worst[method]
                worst[method] = {k: max(error, known.get(k, 0)) for k, error in errors.items()}
                if sticks != run.sticks:
                    miscounted.append((i, method, plant.law, sticks, run.sticks))
        print(f"\ndry laws, SciPy: {stops} stops, worst {worst}, miscounted {miscounted}")
        assert stops > 200
        assert max(max(errors.values()) for errors in worst.values()) < 1e-9
        assert not miscounted

    @pytest.mark.slow
    def test_smooth_laws(self) -> None:
        rng = random.Random(8)
        worst = dict.fromkeys(SMOOTH, 0.0)
        for i in range(100):
            plant = random_plant(rng, SMOOTH[i % len(SMOOTH)])
            run = reference.smooth(plant)
            x, v, work, heat = one(
                "final_position final_speed work_in dissipated",
                plant,
                method="runge_kutta",
                time_step=STEP / 5,
            )
            moved = abs(run.work) + abs(run.heat)
            errors = [abs(x - run.x) / run.far, abs(v - run.v) / run.fast]
            errors += [abs(work - run.work) / moved, abs(heat - run.heat) / moved]
            worst[plant.law] = max(worst[plant.law], *errors)
        print(f"\nsmooth laws, SciPy: worst {worst}")
        for law, error in worst.items():
            assert error < (1e-7 if law in KINKED else 1e-9), law

    @pytest.mark.slow
    def test_bristle_laws(self) -> None:
        rng = random.Random(9)
        tolerances = (1e-5, 1e-6, 1e-7)
        worst = {(law, tolerance): 0.0 for law in BRISTLE for tolerance in tolerances}
        for i in range(40):
            plant = random_plant(rng, BRISTLE[i % len(BRISTLE)])
            plant.given["duration"] = plant.p["duration"] = 0.3
            run = reference.bristle(plant, STATES[plant.law])
            for tolerance in tolerances:
                x, v = one("final_position final_speed", plant, tolerance=tolerance)
                error = max(abs(x - run.x) / run.far, abs(v - run.v) / run.fast)
                key = plant.law, tolerance
                worst[key] = max(worst[key], error)
        print(f"\nbristle laws, SciPy: worst {worst}")
        for (law, tolerance), error in worst.items():
            assert error < 4 * tolerance, law

    def test_reference_covers_every_law_it_names(self) -> None:
        assert {KINDS[law] for law in DRY} == {"dry"}
        assert set(SMOOTH) == {law for law, kind in KINDS.items() if kind == "smooth"}
        assert set(BRISTLE) == {law for law, kind in KINDS.items() if kind == "bristle"}


LAWS = {
    "coulomb": {},
    "coulomb_viscous": {"viscous": 0.7},
    "static_coulomb": {"mu_static": 0.45},
    "static_viscous": {"mu_static": 0.4, "viscous": 3.0},
    "load_friction": {"mu_static": 0.35, "viscous": 0.05, "load_friction": 0.3},
    "directional": {"mu_static": 0.4, "viscous": 1e-3, "skin_ratio": 2.2},
}


def scan(law: str, p: dict[str, Any], shape: tuple[int, ...]) -> Scan:
    """The oracle for a grid."""
    wide = {k: np.broadcast_to(np.asarray(v, np.longdouble), shape).ravel() for k, v in p.items()}
    angle = np.deg2rad(wide["slope_deg"])
    load = wide["mass"] * wide["gravity"]
    normal = load * np.cos(angle)
    slide, static = wide["mu_coulomb"] * normal, wide.get("mu_static", 0 * normal) * normal

    def factor(level: Any, way: Any, drive: Any) -> Any:
        if law == "load_friction":
            return level + wide["load_friction"] * np.abs(drive)
        return level * np.where(way < 0, wide["skin_ratio"], 1) if law == "directional" else level

    return Scan(
        wide["mass"],
        load * np.sin(angle),
        wide.get("viscous", 0 * normal),
        lambda way, drive: factor(slide, way, drive),
        lambda way, drive: factor(static, way, drive),
        0 * normal,
        wide["start_speed"].copy(),
    )


@pytest.mark.parametrize("drive", ["pulse", "table"])
@pytest.mark.parametrize("law", LAWS)
def test_dense_scan_finds_no_other_events(law: str, drive: str) -> None:
    rng = np.random.default_rng(sum(map(ord, law + drive)))
    shape = (14, 12, 10, 5)
    size_name = "gain" if drive == "table" else "drive_amplitude"
    axes: dict[str, Any] = {
        size_name: np.sort(rng.uniform(-6, 12, shape[0])),
        "drive_force": np.sort(rng.uniform(-4, 4, shape[1])),
        "start_speed": np.append(np.sort(rng.uniform(-1.5, 1.5, shape[2] - 1)), 0.0),
        "slope_deg": rng.uniform(-12, 12, shape[3]),
    }
    fixed = {"mass": 1.3, "gravity": 9.81, "mu_coulomb": 0.3, "duration": 1.7, **LAWS[law]}
    table = None
    if drive == "pulse":
        fixed |= {"drive_back": 3.1, "drive_period": 0.23, "drive_duty": 0.37}
    else:
        table = (np.cumsum(rng.uniform(0.01, 0.25, 13)) - 0.05, rng.uniform(-1, 1, 13))
    names = ["final_position", "final_speed", "stuck_time", "stick_phases"]
    found = ls.sweep(names, ls.Grid(**axes, **fixed), law=law, drive=drive, table=table)
    x, v, stuck, sticks = (found[name].ravel() for name in names)

    place = np.meshgrid(*axes.values(), indexing="ij")
    p = {**fixed, **dict(zip(axes, place, strict=True))}
    oracle = scan(law, p, shape)
    size, offset = (p[k].astype(np.longdouble).ravel() for k in (size_name, "drive_force"))
    everywhere = np.ones_like(size)
    if drive == "pulse":
        period, duty, end = (np.longdouble(fixed[f"drive_{k}"]) for k in ("period", "duty", "back"))
        ends = pulse_ends(period, duty, np.longdouble(fixed["duration"]), 8)
        forces = [offset + size, offset - end] * 8
    else:
        assert table is not None
        ends = [min(t, fixed["duration"]) for t in (*table[0][1:], np.inf)]
        forces = [offset + size * np.longdouble(u) for u in table[1]]
    for until, force in zip(ends, forces, strict=True):
        oracle.piece(until * everywhere, force)
    assert (oracle.t == fixed["duration"]).all()

    error_x = float((np.abs(x - oracle.x) / np.maximum(oracle.far, 1e-3)).max())
    error_v = float((np.abs(v - oracle.v) / np.maximum(oracle.fast, 1e-3)).max())
    error_t = float(np.abs(stuck - oracle.stuck).max()) / fixed["duration"]
    other = int((sticks != oracle.sticks).sum())
    print(
        f"\n{law}, {drive}: {x.size} cases, {oracle.sticks.sum()} rests, {oracle.reversals} turns;"
        f" errors x {error_x:.1e}, v {error_v:.1e}, rest {error_t:.1e}; {other} miscounted"
    )
    assert oracle.sticks.sum() > 0.5 * x.size
    assert oracle.reversals > 0.05 * x.size
    assert other == 0
    assert max(error_x, error_v, error_t) < 1e-12


UNIT = {"mass": 1.0, "gravity": 1.0}
OFF = [sign * size for size in (1e-9, 1e-12, 1e-15, 0.0) for sign in (1, -1)]


class TestBuiltToBeMissed:
    """Exact propagation where one rounding decides."""

    @pytest.mark.parametrize("after", [0.3, -0.3, 2.0, -2.0])
    @pytest.mark.parametrize("off", OFF)
    def test_stop_at_the_end_of_a_piece(self, off: float, after: float) -> None:
        # Coulomb friction of 1/2 N stops 1 kg from v in 2 v seconds, without a
        # rounding; there the force changes, a little early or late.
        rng = random.Random(1)
        for _ in range(200):
            v = rng.uniform(0.1, 1.0)
            change = 2 * v * (1 + off)
            if off == 0:
                change = math.nextafter(2 * v, rng.choice((0.0, 9.0)))
            given = {**UNIT, "mu_coulomb": 0.5, "start_speed": v, "duration": 3.0}
            plant = Plant("coulomb", "table", {**given, "gain": 1.0})
            plant.table = ([0.0, change], [0.0, after])
            found = one("final_position final_speed stuck_time stick_phases", plant)
            assert_close(found, stop_near(v, change, after, 3.0))

    @pytest.mark.parametrize("way", [1, -1])
    @pytest.mark.parametrize("law", ["static_coulomb", "directional", "coulomb"])
    def test_force_equal_to_what_holds(self, law: str, way: int) -> None:
        given = {**UNIT, "mu_coulomb": 0.6 if law == "coulomb" else 0.4, "mu_static": 0.6}
        ratio = 2.5 if law == "directional" and way < 0 else 1.0
        given |= {"skin_ratio": 2.5} if law == "directional" else {}
        if law == "coulomb":
            del given["mu_static"]
        holds = 0.6 * ratio
        forces = [holds * (1 + off) for off in (-1e-12, -1e-15, 1e-15, 1e-12)]
        forces += [holds, math.nextafter(holds, 9), math.nextafter(holds, 0)]
        for force in forces:
            plant = Plant(law, "constant", {**given, "drive_force": way * force})
            x, v, stuck = one("final_position final_speed stuck_time", plant)
            if force > holds:
                assert (way * x > 0, way * v > 0, stuck) == (True, True, 0.0), force
            else:
                assert (x, v, stuck) == (0.0, 0.0, 1.0), force

    @pytest.mark.parametrize("duty", [0.0, 1.0])
    def test_pieces_without_length(self, duty: float) -> None:
        rng = random.Random(2)
        names = "final_position final_speed stuck_time stick_phases work_in"
        for _ in range(300):
            given = {**UNIT, "mu_coulomb": rng.uniform(0.1, 0.9), "duration": 2.0, "viscous": 0.3}
            given["start_speed"] = rng.choice((0.0, rng.uniform(-1, 1)))
            force = rng.uniform(-1.5, 1.5)
            push = {"drive_amplitude": force, "drive_back": rng.uniform(-3, 3)}
            if duty == 0:
                push = {"drive_amplitude": rng.uniform(-3, 3), "drive_back": -force}
            period = rng.choice((0.25, 0.1, 1 / 3))
            pulses = {**given, **push, "drive_duty": duty, "drive_period": period}
            whole = one(
                names, Plant("coulomb_viscous", "constant", {**given, "drive_force": force})
            )
            assert_close(one(names, Plant("coulomb_viscous", "pulse", pulses)), whole)

    def test_pieces_of_almost_no_length(self) -> None:
        rng = random.Random(3)
        for i in range(60):
            given = {**UNIT, "mu_coulomb": 0.3, "mu_static": 0.4, "duration": 1.0, "viscous": 0.2}
            given["start_speed"] = rng.choice((0.0, 0.3, -0.3))
            size_name = "drive_amplitude" if i % 2 else "gain"
            given |= {size_name: rng.uniform(-2, 2), "stroke": 10.0}
            if i % 2:
                given |= {"drive_back": rng.uniform(-0.5, 1), "drive_period": 0.1}
                given["drive_duty"] = rng.choice((1e-15, 1e-12, 1e-6, 1 - 1e-15, 1 - 1e-9))
                case = Case("static_viscous", "pulse", given)
            else:
                times = [0.0]
                while len(times) < 12:
                    times += [t := times[-1] + rng.uniform(0.02, 0.1), math.nextafter(t, 9)]
                    times.append(times[-1] + 1e-12)
                case = Case("static_viscous", "table", given)
                case.table = (times, [rng.uniform(-1, 1) for _ in times])
            found, (want, _) = case.found(), case.expected()
            names = ["final_position", "final_speed", "stuck_time", "stick_phases", "work_in"]
            assert_close([found[name] for name in names], [float(want[name]) for name in names])


def stop_near(v: float, change: float, after: float, end: float) -> list[float]:
    """The same in exact fractions."""
    half, push, zero = Fraction(1, 2), Fraction(after), Fraction(0)
    at, start, last = Fraction(change), Fraction(v), Fraction(end)
    left = start - at * half
    stuck, sticks = zero, 0
    if left < 0:
        x, speed, way, t = start * start, zero, 0, at
        stuck, sticks = at - 2 * start, 1
    else:
        x, speed, way, t = (start + left) / 2 * at, left, 1, at
    pull = push - half
    if way and speed + pull * (last - t) < 0:
        brake = -speed / pull
        x, t, speed, way = x + speed * brake / 2, t + brake, zero, 0
        sticks += abs(push) <= half
    if not way and abs(push) > half:
        way, pull = (1, push - half) if push > 0 else (-1, push + half)
    if way:
        x += speed * (last - t) + pull * (last - t) ** 2 / 2
        speed += pull * (last - t)
    else:
        stuck += last - t
    return [float(x), float(speed), float(stuck), float(sticks)]


def assert_close(found: list[float], want: list[float]) -> None:
    for a, b in zip(found, want, strict=True):
        assert math.isclose(a, b, rel_tol=1e-13, abs_tol=1e-14), (found, want)


def under_sine(
    names: str, law: str, given: dict[str, Any], locate: bool, method: str
) -> list[float]:
    """One point of a sweep with a sine, with or without search for events."""
    wanted = names.split()
    requests = [(name, None, None) for name in wanted]
    options: dict[str, Any] = {
        "law": law,
        "drive": "sine",
        "method": method,
        "locate": locate,
    }
    job = _core.Sweep([], list(given.items()), requests, None, **options)
    arrays = [np.empty(()) for _ in wanted]
    job.run(list(enumerate(arrays)), 1, None, None, None, None, True)
    return [float(array) for array in arrays]


class TestWithinOneStep:
    """A sine of 1 Hz in steps of 1/101 s: its turning points lie inside a step."""

    STEP = 1 / 101
    DIPS = (2e-4, 1e-5, 1e-6, 1e-7)
    METHODS = ("runge_kutta", "dormand_prince_fixed", "dormand_prince")

    @pytest.mark.parametrize("method", METHODS)
    @pytest.mark.parametrize("way", [1, -1])
    @pytest.mark.parametrize("depth", [*DIPS, *(-dip for dip in DIPS)])
    def test_speed_that_dips_to_zero_and_rises(self, depth: float, way: int, method: str) -> None:
        # v = v0 - A/w (1 - cos w t) is least at half the period; where it has
        # passed zero before, friction holds until then.
        circle, amplitude = 2 * math.pi, 3.0
        deepest = 2 * amplitude / circle
        v0 = deepest * (1 - depth)
        given = {**UNIT, "mu_coulomb": 0.5, "start_speed": way * v0, "duration": 0.97}
        given |= {"drive_force": way * 0.5, "drive_amplitude": -way * amplitude}
        given |= {"time_step": self.STEP, "tolerance": 1e-10}
        names = "stick_phases stuck_time final_speed final_position"
        sticks, stuck, v, x = under_sine(names, "coulomb", given, True, method)
        if method != "dormand_prince":
            missed = under_sine(names, "coulomb", given, False, method)
            assert missed[:2] == [0.0, 0.0]
        fade = amplitude / circle * (1 - math.cos(circle * 0.97))
        path = amplitude / circle * (0.97 - math.sin(circle * 0.97) / circle)
        blur = 1e-7
        if depth < 0:
            assert (sticks, stuck) == (0.0, 0.0)
            assert way * v == pytest.approx(v0 - fade, abs=blur)
            assert way * x == pytest.approx(v0 * 0.97 - path, abs=blur)
            return
        stop = math.acos(1 - v0 * circle / amplitude) / circle
        assert sticks == 1.0
        assert stuck == pytest.approx(0.5 - stop, rel=1e-3 + 1e-8 / depth)
        assert way * v == pytest.approx(deepest - fade, abs=blur)

    @pytest.mark.parametrize("method", METHODS)
    @pytest.mark.parametrize("way", [1, -1])
    @pytest.mark.parametrize("excess", [1e-4, 1e-5, 1e-6, 1e-8, -1e-8, -1e-5])
    def test_break_away_at_a_peak(self, excess: float, way: int, method: str) -> None:
        circle, size = 2 * math.pi, 1 + excess
        given = {**UNIT, "mu_coulomb": 0.5, "mu_static": 1.0, "duration": 0.4}
        given |= {"drive_amplitude": way * size, "time_step": self.STEP, "tolerance": 1e-10}
        names = "stuck_time stick_phases final_speed final_position"
        stuck, sticks, v, x = under_sine(names, "static_coulomb", given, True, method)
        missed = under_sine(names, "static_coulomb", given, False, method)
        assert missed[0] == pytest.approx(0.4)
        assert missed[1:] == [0.0, 0.0, 0.0]
        assert sticks == 0.0
        if excess < 0:
            assert stuck == pytest.approx(0.4)
            assert (v, x) == (0.0, 0.0)
            return
        go = math.asin(1 / size) / circle
        left, level = 0.4 - go, size / circle
        speed = level * (math.cos(circle * go) - math.cos(circle * 0.4)) - 0.5 * left
        area = (math.sin(circle * 0.4) - math.sin(circle * go)) / circle
        place = level * (math.cos(circle * go) * left - area) - 0.25 * left**2
        assert stuck == pytest.approx(go, abs=1e-11)
        assert way * v == pytest.approx(speed, abs=1e-8)
        assert way * x == pytest.approx(place, abs=1e-8)

    def test_break_away_is_no_rest(self) -> None:
        # One push from rest, still under way at the end: friction at rest is what
        # slows the first motion, so that this begins with no acceleration.
        given = {**UNIT, "mu_coulomb": 0.5, "quadratic": 1.0, "duration": 0.45}
        grid = ls.Grid(drive_amplitude=np.linspace(0.8, 1.5, 2000), **given)
        run = ls.sweep(["stick_phases", "final_speed"], grid, law="quadratic", drive="sine")
        assert run["final_speed"].min() > 0.04
        assert np.count_nonzero(run["stick_phases"]) == 0


class TestDenseOutput:
    """Single trajectories of dry laws: samples are read, not stepped to."""

    GIVEN: ClassVar = {**UNIT, "mu_static": 0.7, "mu_coulomb": 0.5, "stribeck_speed": 0.1} | {
        "drive_amplitude": 1.1,
        "drive_frequency": 1.5,
        "duration": 2.0,
        "tolerance": 1e-11,
    }

    def test_samples_do_not_move_one_another(self) -> None:
        few, many = (
            ls.simulate(law="stribeck", drive="sine", samples=n, **self.GIVEN) for n in (11, 10001)
        )
        assert few.method == many.method == "dormand_prince"
        for field in ("x", "v", "force", "way"):
            # The times that are asked for differ by rounding themselves.
            expected = getattr(many, field)[::1000]
            size = np.abs(expected).max()
            np.testing.assert_allclose(getattr(few, field), expected, rtol=0, atol=1e-13 * size)
        assert 0.05 < np.mean(many.way == 0) < 0.95

    def test_samples_are_those_of_small_steps(self) -> None:
        dense = ls.simulate(law="stribeck", drive="sine", samples=2001, **self.GIVEN)
        steps = ls.simulate(
            law="stribeck", drive="sine", samples=2001, method="runge_kutta", **self.GIVEN
        )
        size = np.abs(steps.v).max()
        assert np.abs(dense.v - steps.v).max() < 1e-9 * size
        assert np.abs(dense.x - steps.x).max() < 1e-9 * size
