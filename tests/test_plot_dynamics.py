"""Pictures of friction laws and of motion: labels, units, rest, legends, one frame."""

import numpy as np
import pytest
from matplotlib.figure import Figure

import locosweep as ls
from locosweep import plot, registry
from locosweep.cli.law_pictures import _BESIDE, _lines, overview, page
from locosweep.plot import style
from locosweep.plot.laws import KIND_COLOURS, frame_of
from locosweep.simulation.law_data import EXAMPLE, Behaviour, behaviour_of, characteristic_of

LAWS = [law.name for law in ls.laws()]
WEIGHT = 0.271 * 9.81


def legend_texts(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


@pytest.fixture(scope="module")
def seen():
    return {name: characteristic_of(name, **EXAMPLE) for name in LAWS}


class TestCharacteristic:
    @pytest.mark.parametrize("name", LAWS)
    def test_every_law_opposes_motion_in_one_frame(self, seen, name):
        law = seen[name]
        assert np.isfinite(law.force).all()
        assert (np.sign(law.force) == np.sign(law.speed)).all()
        low, high = frame_of(*seen.values())
        assert low < law.force.min() / law.level < law.force.max() / law.level < high
        ax = plot.characteristic(law, frame=(low, high))
        assert ax.get_ylim() == (low, high)
        assert ax.get_xlabel() == "speed $v$ [m/s]"

    def test_level_is_that_of_coulomb(self, seen):
        assert seen["stribeck"].level == pytest.approx(0.3 * WEIGHT)
        assert seen["mixed"].level == pytest.approx(0.45 * WEIGHT)

    def test_rest_is_a_bar_up_to_break_away(self, seen):
        low, high = seen["static_coulomb"].rest
        assert (low, high) == pytest.approx((-0.45 * WEIGHT, 0.45 * WEIGHT))
        bar = next(line for line in plot.characteristic(seen["static_coulomb"]).lines
                   if line.get_linewidth() > 4)  # fmt: skip
        assert bar.get_xdata().tolist() == [0, 0]
        np.testing.assert_allclose(bar.get_ydata(), [-1.5, 1.5])

    def test_directional_skin_holds_more_backward(self, seen):
        low, high = seen["directional"].rest
        assert low == pytest.approx(-EXAMPLE["skin_ratio"] * high)
        # The simulation breaks away there and no earlier.
        given = {p.name: EXAMPLE[p.name] for p in registry.law("directional").parameters}
        ends = ls.sweep("final_position", law="directional", drive_force=[0.999 * low, 1.001 * low],
                        **given).values  # fmt: skip
        assert ends[0] == 0
        assert ends[1] < 0

    def test_smooth_laws_pass_through_nought_and_bristles_jump(self, seen):
        through = plot.characteristic(seen["tanh"])
        assert any(0.0 in line.get_ydata() and len(line.get_xdata()) > 2 for line in through.lines)
        assert "creeps" in legend_texts(through)[1]
        jump = plot.characteristic(seen["lugre"])
        assert any(line.get_linestyle() == ":" for line in jump.lines)
        assert "deflection" in legend_texts(jump)[1]

    def test_several_laws_differ_in_colour_and_dash(self, seen):
        ax = plot.characteristic(*(seen[name] for name in ("coulomb", "stribeck", "lugre")))
        assert legend_texts(ax) == ["coulomb", "stribeck", "lugre"]
        curves = [line for line in ax.lines if not line.get_label().startswith("_")]
        assert len({line.get_color() for line in curves}) == 3
        assert len({line.get_linestyle() for line in curves}) == 3

    def test_draws_where_it_is_told(self, seen):
        ax = Figure().subplots()
        assert plot.characteristic(seen["coulomb"], ax=ax) is ax

    def test_refused(self, seen):
        with pytest.raises(ls.InputError, match="0 laws"):
            plot.characteristic()
        with pytest.raises(ls.InputError, match="9 laws"):
            plot.characteristic(*([seen["coulomb"]] * 9))
        with pytest.raises(ls.InputError, match="did you mean 'stribeck'"):
            characteristic_of("stribek", mu_coulomb=0.3)
        with pytest.raises(ls.InputError, match="mu_static"):
            characteristic_of("stribeck", mu_coulomb=0.3)
        with pytest.raises(ls.InputError, match="mu_coulomb"):
            characteristic_of("coulomb", mu_coulomb=-1.0)
        with pytest.raises(ls.InputError, match="other than 0"):
            characteristic_of("coulomb", [0.0], mu_coulomb=0.3)
        with pytest.raises(ls.InputError, match="relative to that level"):
            behaviour_of("coulomb", mu_coulomb=0.0)


class TestBehaviour:
    @pytest.mark.parametrize("name", LAWS)
    def test_every_law_has_one(self, name):
        behaviour = behaviour_of(name, **EXAMPLE)
        ax = plot.behaviour(behaviour)
        assert (ax.get_xlabel(), ax.get_ylabel()) == (behaviour.x_label, behaviour.y_label)
        assert "[" in ax.get_xlabel() or "over Coulomb level" in ax.get_xlabel()
        for _, x, y in behaviour.lines:
            assert x.shape == y.shape
            assert np.isfinite(x).all()
            assert np.isfinite(y).mean() > 0.9

    @pytest.mark.parametrize("name", [law.name for law in ls.laws() if law.kind == "bristle"])
    def test_presliding_stays_below_break_away(self, name):
        for share, (_, x, y) in zip((0.3, 0.6, 0.9), behaviour_of(name, **EXAMPLE).lines,
                                    strict=True):  # fmt: skip
            assert np.ptp(x) < 100  # micrometres: it did not slide away
            hold = 1.0 if name == "dahl" else 1.5
            assert np.abs(y).max() == pytest.approx(share * hold, rel=0.02)

    @pytest.mark.parametrize("name", [law.name for law in ls.laws() if law.kind == "smooth"])
    def test_creep_follows_the_characteristic(self, name):
        seen = characteristic_of(name, np.linspace(1e-7, EXAMPLE["transition_speed"], 4001),
                                 **EXAMPLE)  # fmt: skip
        for share, (_, t, x) in zip((0.25, 0.5, 0.75), behaviour_of(name, **EXAMPLE).lines[:3],
                                    strict=True):  # fmt: skip
            steady = seen.speed[np.argmax(seen.force >= share * seen.level)]
            assert (x[-1] - x[-100]) / (t[-1] - t[-100]) == pytest.approx(1e3 * steady, rel=0.01)

    def test_track_shows_its_ratios(self):
        _, x, y = behaviour_of("patch", **EXAMPLE).lines[0]
        inside = (x > 1.01 * 20) & (x < 0.99 * 50)
        np.testing.assert_allclose(y[inside], EXAMPLE["patch_ratio"], rtol=1e-3)
        np.testing.assert_allclose(y[(x > 1) & (x < 19.5)], 1.0, rtol=1e-3)

    def test_load_friction_rises_by_its_coefficient(self):
        sliding = behaviour_of("load_friction", **EXAMPLE).lines[1]
        slope = np.polyfit(sliding[1], sliding[2], 1)[0]
        assert slope == pytest.approx(EXAMPLE["load_friction"], rel=1e-3)


class TestPages:
    def test_every_parameter_that_switches_a_part_off_has_an_example(self):
        harmless = {"ripple_phase_deg", "patch_start"}
        for law in ls.laws():
            for p in law.parameters:
                assert p.default or p.name in EXAMPLE or p.name in harmless, p.name

    def test_notes_of_the_overview_name_known_parameters(self):
        assert set(_BESIDE) <= {p.name for p in ls.parameters()}

    def test_overview_has_a_titled_frame_for_each_law(self, seen):
        frame = frame_of(*seen.values())
        figure = overview(ls.laws(), list(seen.values()), frame)
        titled = [ax for ax in figure.axes if ax.get_title()]
        assert [ax.get_title() for ax in titled] == LAWS
        assert {ax.get_ylim() for ax in titled} == {frame}
        colours = [ax.title.get_color() for ax in titled]
        assert colours == [KIND_COLOURS[law.kind] for law in ls.laws()]

    @pytest.mark.parametrize("name", LAWS)
    def test_formulas_can_be_set(self, name):
        assert _lines(registry.law(name).formula)

    def test_what_cannot_be_set_is_left_out(self):
        assert _lines(r"\unheard{x}") == []

    def test_page_tells_formula_and_values(self, seen):
        law = registry.law("stribeck")
        empty = Behaviour("t", "x", "y", ())
        figure = page(law, seen["stribeck"], empty, (-2, 2), {"mu_static": 0.45})
        assert r"\mu_V v$" in figure.get_suptitle()
        assert figure.get_supxlabel() == r"$\mu_S$ = 0.45"


@pytest.fixture(scope="module")
def motion():
    return ls.simulate(law="static_coulomb", drive="sine", drive_amplitude=1.4, duration=2.0,
                       mu_static=0.4, mu_coulomb=0.3, samples=401)  # fmt: skip


class TestMotion:
    def test_three_panels_with_units(self, motion):
        axes = plot.motion(motion)
        assert [ax.get_ylabel() for ax in axes] == [
            "position $x$ [m]", "speed $v$ [m/s]", "drive force $F_P$ [N]"
        ]  # fmt: skip
        assert axes[2].get_xlabel() == "time $t$ [s]"
        for word in ("static_coulomb", "sine", motion.method):
            assert word in axes[0].get_title(loc="left")
        for ax, name in zip(axes, ("x", "v", "force"), strict=True):
            curve = next(line for line in ax.lines if len(line.get_xdata()) == 401)
            assert curve.get_ydata().tolist() == getattr(motion, name).tolist()

    def test_rest_is_shaded_where_friction_holds(self, motion):
        for ax in plot.motion(motion):
            spans = [patch for patch in ax.patches if patch.get_width() > 0]
            inside = np.zeros(401, bool)
            for span in spans:
                begin = span.get_x()
                inside |= (motion.t >= begin) & (motion.t <= begin + span.get_width())
            np.testing.assert_array_equal(inside, motion.way == 0)
        assert legend_texts(plot.motion(motion)[0]) == ["at rest, held by friction"]

    def test_no_rest_no_shade(self):
        run = ls.simulate(law="coulomb", mu_coulomb=0.1, drive_force=2.0, start_speed=1.0)
        assert all(not ax.patches and ax.get_legend() is None for ax in plot.motion(run))

    @pytest.mark.parametrize("law", ["tanh", "lugre"])
    def test_laws_that_never_hold_have_no_shade(self, law):
        run = ls.simulate(law=law, mu_static=0.4, mu_coulomb=0.3, drive_force=0.1, duration=0.1)
        assert all(not ax.patches for ax in plot.motion(run))

    def test_several_curves_have_a_legend_and_a_bar_each(self):
        run = ls.simulate(law="coulomb", drive="sine", drive_amplitude=2, mu_coulomb=[0.1, 0.2],
                          start_speed=0)  # fmt: skip
        top, middle, _ = plot.motion(run)
        assert legend_texts(top) == [style.setting("mu_coulomb", mu) for mu in (0.1, 0.2)]
        assert len(middle.collections) == 2
        assert any("held by friction" in text.get_text() for text in middle.texts)
        low = middle.get_ylim()[0]
        assert low < run.v.min()

    def test_own_times_for_each_duration(self):
        run = ls.simulate(law="coulomb", drive_force=2, mu_coulomb=0.1, duration=[1, 2], samples=3)
        curves = [line for line in plot.motion(run)[0].lines if len(line.get_xdata()) == 3]
        assert [line.get_xdata().tolist() for line in curves] == [[0, 0.5, 1], [0, 1, 2]]

    def test_axes_and_title_of_ones_own(self, motion):
        axes = Figure().subplots(3, 1)
        found = plot.motion(motion, axes=axes, title="mine")
        assert all(a is b for a, b in zip(axes, found, strict=True))
        assert found[0].get_title(loc="left") == "mine"

    def test_refused(self, motion):
        with pytest.raises(ls.InputError, match="axes has 2"):
            plot.motion(motion, axes=Figure().subplots(2, 1))
        many = ls.simulate(law="coulomb", mu_coulomb=np.linspace(0.1, 0.9, 9), samples=2)
        with pytest.raises(ls.InputError, match="9 trajectories"):
            plot.motion(many)


class TestHeatmaps:
    def test_codes_of_a_simulation_are_hatched_and_named(self):
        result = ls.sweep("stroke_time", law="coulomb", mu_coulomb=0.3,
                          drive_force=np.linspace(0.5, 3, 6), stroke=[0.01, 0.02, 0.5])  # fmt: skip
        ax = result.plot.heatmap()
        code = int(ls.Status.NOT_REACHED)
        assert set(np.unique(result.status).tolist()) == {0, code}
        assert style.hatch(code) in {patch.get_hatch() for patch in ax.patches}
        words = " ".join(" ".join(legend_texts(ax)).split())
        assert ls.Status.NOT_REACHED.sentence in words

    def test_every_status_has_a_hatch_of_its_own(self):
        codes = [int(status) for status in ls.Status if status]
        assert len({style.hatch(code) for code in codes}) == len(codes)

    def test_law_and_drive_stand_in_the_title(self):
        how = {"law": "dahl", "drive": "sine", "method": "rosenbrock"}
        assert style.simulated(how) == "law dahl, drive sine"
        result = ls.sweep("final_position", law="dahl", mu_coulomb=[0.1, 0.3],
                          drive_force=[1, 2], duration=0.5)  # fmt: skip
        assert result.plot.heatmap().get_title().splitlines()[0] == style.simulated(result.how)

    def test_a_trace_of_the_other_sign_does_not_take_half_of_the_colours(self):
        values = np.array([-1e-7, 0.1, 0.5])
        assert style.colours(values, integer=False).cmap.name == style.SEQUENTIAL
        assert style.colours(-values, integer=False).cmap.name == style.SEQUENTIAL
        assert style.colours(values - 0.1, integer=False).cmap.name == style.DIVERGING
