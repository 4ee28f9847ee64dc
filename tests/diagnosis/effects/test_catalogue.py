"""Every consumer of the registry over every effect: a row that is forgotten anywhere fails."""

from __future__ import annotations

import ast
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from locosweep import _core
from locosweep.diagnosis.design.distance import PlannedRuns
from locosweep.diagnosis.effects import catalogue
from locosweep.diagnosis.effects.scale import Scale, scale_of
from locosweep.diagnosis.estimate.motion import Motion, terms_of
from locosweep.diagnosis.report import page
from locosweep.diagnosis.report.model_file import write_augmented
from locosweep.errors import DataFileError, InputError
from locosweep.files.robot import Robot, load_robot
from locosweep.files.runs import Run
from locosweep.simulation.replay import effect, effect_values, effects, nominal_of, replay_runs
from locosweep.validation.judge import CONTAINS
from locosweep.validation.laws import CAUSES
from locosweep.validation.laws import Scale as RealScale
from locosweep.validation.rivals import rivals_of

ROOT = Path(__file__).parents[3]
PACKAGE = ROOT / "python" / "locosweep"
NAMES = [record.name for record in effects()]
UNITS = {"1", "N", "N s/m", "N s^2/m^2", "m/s", "N/m", "m", "rad", "s", "kg", "deg"}
NEEDS = {"body", "rear_sensor", "slope"}
SHOWN = {"at_rest", "moving", "forward", "both_ways"}

ROBOT = Robot({"mass": 0.5, "segments": 4.0, "mu_coulomb": 0.2, "viscous": 0.3})
BENCH = Robot({"mass": 0.5, "segments": 4.0}, {"surface.coulomb_force": 1.2})
T = np.arange(0.0, 2.0, 0.01)
DRIVE = 2.4 * np.sin(2 * np.pi * (0.7 * T + 0.4 * T**2)) + 0.8


def scale(robot: Robot, *, windows: bool = False) -> Scale:
    travel = 0.3 * (1.0 - np.cos(np.pi * T))
    found = scale_of(robot, [Run("0", T, DRIVE, {"x": travel})])
    return replace(found, replayed=0.1) if windows else found


SCALES = {
    "coefficient": scale(ROBOT),
    "force": scale(BENCH),
    "windows": scale(ROBOT, windows=True),
}
SURFACES = {
    "coefficient": "[surface]\nmu_coulomb = 0.2\n",
    "force": "[surface]\ncoulomb_force = 1.2\n",
}


@pytest.fixture(params=NAMES)
def name(request):
    return request.param


@pytest.fixture(params=list(SCALES))
def rig(request):
    return SCALES[request.param]


def first_values(name: str, rig: Scale) -> dict[str, float]:
    """Parameters at the first start of an effect."""
    free = catalogue.parameters_of(name, rig)
    return {f.name: float(v) for f, v in zip(free, catalogue.starts_of(name, rig)[0], strict=True)}


def test_a_delay_is_early_only_where_no_other_makes_up_for_it() -> None:
    """A late drive beside an early reading made the motion of a head that hits a wall."""
    scale = SCALES["force"]
    (alone,) = catalogue.parameters_of("sensor_delay", scale, ("sensor_delay", "drive_lag"))
    assert alone.low < 0.0
    for name, other in (("sensor_delay", "drive_delay"), ("drive_delay", "sensor_delay")):
        (beside,) = catalogue.parameters_of(name, scale, (name, other))
        assert beside.low == 0.0
        assert beside.high == alone.high


class TestRow:
    def test_every_parameter_has_its_unit_symbol_meaning_and_fit(self, name):
        record = effect(name)
        assert [p.name for p in record.parameters] == [fit.name for fit in record.fits]
        assert all(p.unit in UNITS and p.symbol and p.meaning for p in record.parameters)
        assert record.formula
        assert record.meaning

    def test_words_are_of_the_vocabulary(self, name):
        record = effect(name)
        assert set(record.needs) <= NEEDS
        assert record.shown in SHOWN
        assert {fit.only_with for fit in record.fits} <= {None, "mu_coulomb", "coulomb_force"}
        assert record.refined is None or record.refined in dict(record.over)

    def test_limits_are_effects_with_fewer_parameters(self, name):
        own = catalogue.parameters_of(name, SCALES["force"])
        for limit in effect(name).contains:
            assert len(catalogue.parameters_of(limit, SCALES["force"])) < len(own)
            assert name in CONTAINS[limit]

    def test_an_error_of_a_value_is_of_one_that_may_be_uncertain(self, name):
        keys = {p.file_key[1] for p in _core.file_keys() if p.file_key[0] == "uncertainty"}
        assert effect(name).error_of in keys | {None}

    def test_a_parameter_checks_its_own_range(self, name):
        for parameter in effect(name).parameters:
            low, high = parameter.range
            assert parameter.check(low if np.isfinite(low) else high) in (low, high)
            with pytest.raises(InputError, match=parameter.name):
                parameter.check(low - 1.0)

    def test_of_two_parameters_of_one_name_each_checks_its_own(self):
        of_body = effect("anchor_slip").parameters[0]
        of_robot = next(p for p in _core.parameters() if p.name == of_body.name)
        assert of_body.check(2e3) == 2e3
        with pytest.raises(InputError):
            of_robot.check(2e3)


class TestStarts:
    def test_lie_within_their_ranges(self, name, rig):
        free = catalogue.parameters_of(name, rig)
        rows = catalogue.starts_of(name, rig)
        assert rows.shape == (len(rows), len(free))
        assert len(rows) > 0
        assert np.isfinite(rows).all()
        records = {p.name: p for p in effect(name).parameters}
        for f, column in zip(free, rows.T, strict=True):
            assert f.low < f.high
            assert (f.low <= column).all()
            assert (column <= f.high).all()
            assert f.size > 0.0
            assert not f.log or f.low > 0.0
            for value in column:
                records[f.name].check(float(value))

    def test_leave_the_nominal_model(self, name, rig):
        for f, column in zip(
            catalogue.parameters_of(name, rig), catalogue.starts_of(name, rig).T, strict=True
        ):
            assert np.isnan(f.off) or (column != f.off).mean() > 0.5

    def test_friction_at_rest_may_fall_where_another_effect_lowers_the_level(self):
        rig = SCALES["coefficient"]
        alone = catalogue.parameters_of("stribeck_friction", rig)[0]
        beside = catalogue.parameters_of("stribeck_friction", rig, ["payload_mass"])[0]
        assert alone.low == rig.level
        assert beside.low == 0.0


class TestMagnitudes:
    def test_every_shape_and_size_gives_finite_parameters_in_range(self, name, rig):
        family = catalogue.families(rig)[name]
        assert family.low <= 0.0 < family.high
        records = {p.name: p for p in effect(name).parameters}
        for u, start in product((0.01, 0.3, 0.9), family.starts()):
            given = [s.coordinate(v) for s, v in zip(family.shapes, start, strict=True)]
            for sign in family.signs:
                values = family.parameters(np.array([sign * u, *given]))
                assert list(values) == [f.name for f in catalogue.parameters_of(name, rig)]
                for key, value in values.items():
                    assert np.isfinite(value)
                    records[key].check(value)

    def test_a_shape_stays_within_its_bounds(self, name, rig):
        for shape in catalogue.families(rig)[name].shapes:
            assert shape.low < shape.high
            assert all(shape.low <= start <= shape.high for start in shape.starts)
            assert shape.value(1e6) == pytest.approx(shape.high)

    def test_an_effect_is_felt(self, name):
        run = Run("0", T, DRIVE)
        plan = PlannedRuns(ROBOT, [run], {"x": 1e-5, "v": 1e-3, "x_rear": 1e-5, "force": 1e-3})
        family = plan.families[name]
        start = family.starts()[-1]
        given = [s.coordinate(v) for s, v in zip(family.shapes, start, strict=True)]
        signal = plan.signals([(name, family.parameters(np.array([0.6, *given])))])
        assert 1.0 < np.linalg.norm(signal) < np.inf


class TestMeaning:
    def test_an_effect_is_left_out_where_a_rig_lacks_what_it_needs(self, name):
        for need in NEEDS:
            assert (name in catalogue.lacking({need: False})) == (need in effect(name).needs)

    def test_on_a_robot_with_all_sensors_all_have_a_meaning(self):
        names, out = catalogue.candidates(ROBOT, {"x", "x_rear"})
        assert names == NAMES
        assert out == {}

    def test_on_a_rotary_bench_no_slope_and_no_body(self):
        rotary = Robot(
            {"mass": 0.5}, {"bench.kind": "rotary", "surface.coulomb_force": 1.0}
        )  # fmt: skip
        names, out = catalogue.candidates(rotary, {"x", "x_rear"})
        assert list(out) == ["anchor_slip", "slope_error"]
        assert not set(names) & set(out)


class TestVariables:
    def test_another_law_has_terms_in_its_variable(self, name):
        variable = catalogue.VARIABLES.get(name)
        if variable is None:
            assert effect(name).site in ("body", "environment", "friction")
            return
        found = replay_runs(ROBOT, [Run("0", T, DRIVE)])
        x, v, force = (found[c].to_numpy() for c in ("x", "v", "force"))
        same = np.zeros(T.size, dtype=np.intp)
        motion = Motion(
            T, x, v, force, DRIVE, same, np.abs(x), x, 0.5, 0.3, np.ones(T.size), 0.0 * T
        )
        groups, _ = terms_of(variable, motion)
        assert sum(np.abs(group).sum() > 0.0 for group in groups) > 0


class TestFiles:
    @pytest.mark.parametrize("form", SURFACES)
    def test_a_table_needs_all_parameters_of_the_row(self, name, form, tmp_path):
        path = tmp_path / "model.toml"
        values = first_values(name, SCALES[form])
        for left_out in [*values, None]:
            kept = "".join(f"{k} = {v!r}\n" for k, v in values.items() if k != left_out)
            path.write_text(f"{SURFACES[form]}[effects.{name}]\n{kept}")
            if left_out is None:
                assert load_robot(path).effects == {name: values}
            else:
                with pytest.raises(DataFileError, match=f"has no {left_out}"):
                    load_robot(path)

    def test_the_two_forms_of_a_level_exclude_each_other(self, tmp_path):
        path = tmp_path / "model.toml"
        for form, key in (("coefficient", "d_force"), ("force", "d_mu")):
            own = "d_mu" if key == "d_force" else "d_force"
            path.write_text(f"{SURFACES[form]}[effects.coulomb_error]\n{own} = 0.1\n{key} = 0.1\n")
            with pytest.raises(DataFileError, match=f"has {key}, which goes with"):
                load_robot(path)

    def test_an_augmented_model_is_read_back(self, name, tmp_path):
        values = first_values(name, SCALES["coefficient"])
        model = replace(ROBOT, effects={name: values})
        write_augmented(model, tmp_path / "model.toml")
        assert load_robot(tmp_path / "model.toml") == model


REAL = RealScale(1.0, 3.0, 0.5, 14.0, 0.8, 0.5, 0.0, 0.5, 2.0, 0.2)
FORMS = {(name, form): set(keys) for name, form, keys in _core.reality_forms()}


class TestBlindCheck:
    def test_a_case_is_drawn_of_it_or_its_row_says_not(self, name):
        assert effect(name).drawn == (name in CAUSES)

    @pytest.mark.parametrize("as_force", [False, True])
    def test_rivals_have_the_parameters_of_the_reality(self, name, as_force):
        own = [r for r in rivals_of(REAL, as_force=as_force) if r.cause == name]
        assert bool(own) == effect(name).drawn
        for rival in own:
            for s in (0.3, -0.3):
                cause, form, values = rival.effect(s)
                assert FORMS[cause, form] == set(values)
                assert all(np.isfinite(v) for v in values.values())
            assert rival.allows(0.3)

    def test_a_reality_starts_and_the_engine_follows(self, name):
        if not effect(name).drawn:
            return
        rival = next(r for r in rivals_of(REAL, as_force=False) if r.cause == name)
        _, _, values = rival.effect(0.2)
        job = _core.Replay(nominal_of(ROBOT), [(T, DRIVE, 0.0)])
        read = job.run(
            [(0, 0, T.size, [name])], effect_values({name: values})[None, :],
            np.array([[1.0, 1.0, 1.0, 0.0]]), np.zeros((1, 2)), 1,
        )  # fmt: skip
        assert np.isfinite(read).all()


class TestPages:
    def test_the_documentation_describes_it_and_its_parameters(self, name):
        pages = (ROOT / "docs" / "effects.md").read_text(encoding="utf-8").split("\n## ")
        (own,) = [page for page in pages if page.startswith(f"{name}\n")]
        assert effect(name).formula in own
        for parameter in effect(name).parameters:
            assert f"| `{parameter.name}` |" in own

    def test_the_report_says_what_it_is(self, name):
        assert page._meaning(name) == effect(name).meaning


ELSEWHERE = {
    # The paper's own gap is made of these two.
    "paper/gap.py": {"drive_saturation", "lubricant_buildup"},
    # A clock that is off delays the drive; a robot turned round, a window's true start.
    "diagnosis/report/model_file.py": {"drive_delay"},
    "diagnosis/estimate/problem.py": {"slope_error"},
    "diagnosis/estimate/shooting.py": {"sensor_scale", "sensor_drift", "sensor_delay"},
    # Mass and damping of a fitted motion.
    "diagnosis/estimate/motion.py": {"payload_mass", "viscous_friction", "back_emf"},
    # A robot that was turned round sees the other sign of it.
    "diagnosis/estimate/equation_error.py": {"slope_error"},
    # Play and spring with a rigid joint are one; the shortest delay a force sensor sees.
    "validation/sizes.py": {"transmission_backlash", "transmission_compliance"},
    "validation/cases.py": {
        "transmission_backlash", "transmission_compliance", "coulomb_error", "drive_delay",
    },
    "validation/next_run.py": {"slope_error"},
    # How strong the independent reality makes each cause.
    "validation/laws.py": set(NAMES),
    # How each effect comes into a log; what is calibrated.
    "validation/planting.py": set(NAMES),
    "validation/extra_friction.py": set(NAMES),
    "validation/calibration.py": {
        "coulomb_error", "viscous_friction", "payload_mass", "drive_gain_error",
    },
}  # fmt: skip
"""Files that say something of one effect that is in no row, and of which."""


def test_a_joint_starts_underdamped_whatever_the_mass_on_the_drive_s_side():
    """Its damping is a share of what is critical for that side, which swings on the spring."""
    least = {}
    for k, d, side in catalogue.starts_of("transmission_compliance", SCALES["coefficient"]):
        share = d / (2.0 * np.sqrt(k * side))
        least[k, side] = min(share, least.get((k, side), np.inf))
    assert len({side for _, side in least}) > 1
    assert max(least.values()) < 0.3


def test_no_other_file_of_the_package_names_an_effect():
    faults = []
    for path in sorted(PACKAGE.rglob("*.py")):
        allowed = ELSEWHERE.get(path.relative_to(PACKAGE).as_posix(), set())
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and node.value in set(NAMES) - allowed:
                faults.append(f"{path.name}:{node.lineno} {node.value}")
    assert faults == []


def test_a_model_has_one_effect_of_a_place():
    for record in effects():
        assert all(record.name in effect(other).excludes for other in record.excludes)
    joints = ["transmission_backlash", "transmission_compliance"]
    assert not catalogue.goes_with(joints[0], ["drive_lag", joints[1]])
    assert not catalogue.goes_with("drive_lag", ["drive_lag"])
    assert catalogue.goes_with(joints[0], ["drive_lag", "presliding_compliance"])
