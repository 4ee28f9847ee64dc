"""Pictures: labels, units, hatches, colours, provenance, one-line errors."""

import hashlib
import os
import subprocess
import sys

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import BoundaryNorm, CenteredNorm, LogNorm, to_rgb
from matplotlib.figure import Figure
from matplotlib.mathtext import MathTextParser
from matplotlib.patches import PathPatch
from PIL import Image

import locosweep as ls
import locosweep.plot
from locosweep.plot import caption, style
from locosweep.plot.numbers import PlainNumbers
from locosweep.plot.save import lay_out, save_figure
from locosweep.provenance import spec_hash
from locosweep.registry import parameter

MU = {"mu_static": 0.5, "mu_coulomb": 0.3}


@pytest.fixture(scope="module")
def speed():
    names = ["mean_velocity", "best_segments", "net_force"]
    return ls.sweep(
        names, **MU, slope_deg=np.linspace(0, 30, 16), anchor_weight=[0, 1], segments=range(1, 9)
    )


def legend_texts(ax):
    return [text.get_text() for text in ax.get_legend().get_texts()]


def colour_bar(ax):
    return ax.collections[0].colorbar


def hatches(ax):
    return {p.get_hatch() for p in ax.patches if isinstance(p, PathPatch) and p.get_hatch()}


def test_axes_and_colour_bar_carry_name_symbol_and_unit(speed):
    ax = speed.plot.heatmap(anchor_weight=1, x="segments", y="slope_deg")
    assert ax.get_xlabel() == "number of segments of the robot $N$"
    assert ax.get_ylabel() == r"slope of the ground $\alpha$ [deg]"
    assert colour_bar(ax).ax.get_ylabel() == r"mean velocity $\bar v$ [m/s]"
    assert ax.get_title().splitlines()[0] == "$w$ = 1"


def test_defaults_are_the_last_free_axes(speed):
    assert "slope" in speed.plot.heatmap(anchor_weight=0).get_ylabel()
    ax = speed.plot.heatmap(segments=4)
    assert "weight" in ax.get_xlabel()
    assert "slope" in ax.get_ylabel()


def test_transposed_picture_shows_the_same_cells(speed):
    one = speed.plot.heatmap("segments", "slope_deg", anchor_weight=1).collections[0].get_array()
    two = speed.plot.heatmap("slope_deg", "segments", anchor_weight=1).collections[0].get_array()
    np.testing.assert_array_equal(np.ma.filled(one, -1), np.ma.filled(two.T, -1))
    np.testing.assert_array_equal(np.ma.filled(one, np.nan), speed.values[:, 1, :])


def test_descending_axis_is_put_in_order():
    up, down = (
        ls.sweep("mean_velocity", **MU, slope_deg=slopes, segments=[3, 4])
        for slopes in ([0, 5, 10], [10, 5, 0])
    )
    same = [r.plot.heatmap().collections[0].get_array() for r in (up, down)]
    np.testing.assert_array_equal(*same)


def test_every_status_has_its_hatch_and_its_sentence(speed):
    ax = speed.plot.heatmap(anchor_weight=1)
    codes = set(np.unique(speed.status[:, 1, :]).tolist()) - {0}
    assert len(codes) >= 3
    assert hatches(ax) == {style.hatch(code) for code in codes}
    words = " ".join(" ".join(legend_texts(ax)).split())
    for code in codes:
        assert ls.Status(code).sentence in words


def test_hatched_area_is_exactly_the_cells_of_the_status(speed):
    ax = speed.plot.heatmap(anchor_weight=1)
    code = int(ls.Status.SLIDES_BACK)
    patch = next(p for p in ax.patches if p.get_hatch() == style.hatch(code))
    slopes, counts = speed.axes["slope_deg"], speed.axes["segments"]
    for i, slope in enumerate(slopes):
        for j, count in enumerate(counts):
            inside = any(
                part.contains_point((count, slope))
                for part in map(mpl.path.Path, patch.get_path().to_polygons())
            )
            assert inside == (speed.status[i, 1, j] == code)


def test_hatches_of_all_statuses_differ():
    codes = [int(status) for status in ls.Status if status]
    assert len({style.hatch(code) for code in codes}) == len(codes)


def test_picture_without_any_value_names_the_reason():
    r = ls.sweep(
        "mean_velocity", mu_static=0.1, mu_coulomb=0.1, slope_deg=[20, 30], segments=[3, 4]
    )
    ax = r.plot.heatmap()
    assert legend_texts(ax) == [ls.Status.SLIDES_BACK.sentence]


def test_highest_value_is_marked_where_it_is(speed):
    ax = speed.plot.heatmap(anchor_weight=1)
    star = next(line for line in ax.lines if line.get_marker() == "*")
    assert (star.get_xdata()[0], star.get_ydata()[0]) == (3.0, 0.0)
    assert "0.08735 m/s" in star.get_label()
    plain = speed.plot.heatmap(anchor_weight=1, mark_optimum=False)
    assert not plain.lines


def test_contours_are_labelled_with_units(speed):
    ax = speed.plot.heatmap(anchor_weight=1, levels=[0.03, 0.06])
    assert {text.get_text() for text in ax.texts} <= {"0.03 m/s", "0.06 m/s"}
    assert ax.texts
    assert not speed.plot.heatmap(anchor_weight=1, levels=0).texts


def test_whole_numbers_get_one_colour_each():
    r = ls.sweep("best_segments", **MU, slope_deg=np.linspace(0, 15, 31), anchor_weight=[0, 1])
    ax = r.plot.heatmap("slope_deg", "anchor_weight")
    norm = ax.collections[0].norm
    assert isinstance(norm, BoundaryNorm)
    whole = np.arange(r.values.min(), r.values.max() + 1)
    ticks = colour_bar(ax)
    assert [t.get_text() for t in ticks.ax.get_yticklabels()] == [f"{n:.0f}" for n in whole]
    assert len(set(norm(whole).tolist())) == len(whole)
    assert not ax.lines


def test_many_whole_numbers_get_sensible_classes():
    r = ls.sweep("best_segments", **MU, slope_deg=np.linspace(0, 26.5, 500), anchor_weight=[1])
    ax = r.plot.heatmap()
    bounds = np.array(ax.collections[0].norm.boundaries)
    low, high = r.values.min(), r.values.max()
    assert (bounds[0], bounds[-1]) == (low - 0.5, high + 0.5)
    assert 6 <= len(bounds) <= 16
    assert (bounds % 1 == 0.5).all()
    labels = [t.get_text() for t in colour_bar(ax).ax.get_yticklabels()]
    assert labels[:4] == ["3", "4", "5", "6–7"]
    assert labels[-1].endswith(f"–{high:.0f}")


@pytest.mark.parametrize("low", [0, 1, 7, 130, -40])
@pytest.mark.parametrize("width", [0, 1, 11, 13, 45, 400, 1e4, 1e6])
def test_classes_cover_any_range_once(low, width):
    values = np.unique(np.round(np.linspace(low, low + width, 60)))
    shown = style.colours(values, integer=True)
    bounds = np.array(shown.norm.boundaries)
    assert (np.diff(bounds) > 0).all()
    assert bounds[0] < values.min()
    assert bounds[-1] > values.max()
    assert len(shown.ticks) == len(shown.names) == len(bounds) - 1 <= 15


def test_both_signs_diverge_around_zero():
    r = ls.sweep("resistance", mu_coulomb=0.3, slope_deg=[-40, 0, 40], moving=[1, 2])
    mesh = r.plot.heatmap().collections[0]
    assert isinstance(mesh.norm, CenteredNorm)
    assert mesh.norm(0.0) == 0.5
    assert mesh.cmap.name == style.DIVERGING


def test_colour_bar_of_a_log_norm_has_plain_numbers_and_shows_what_lies_beyond():
    r = ls.sweep("optimal_segments", **MU, slope_deg=np.linspace(0, 26.5, 200), gravity=[9, 10])
    ax = r.plot.heatmap("slope_deg", "gravity", norm=mpl.colors.LogNorm(4, 500))
    bar = colour_bar(ax)
    ax.figure.canvas.draw()
    assert {"10", "20", "50", "100"} <= {t.get_text() for t in bar.ax.get_yticklabels()}
    assert bar.extend == "both"
    assert colour_bar(r.plot.heatmap("slope_deg", "gravity", norm="log")).extend == "neither"


def luminance(colours):
    rgb = np.asarray(colours)[:, :3]
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    return linear @ [0.2126, 0.7152, 0.0722]


def test_luminance_of_the_maps_is_monotone():
    steps = np.linspace(0, 1, 256)
    assert (np.diff(luminance(mpl.colormaps[style.SEQUENTIAL](steps))) > 0).all()
    both = luminance(mpl.colormaps[style.DIVERGING](steps))
    assert (np.diff(both[:128]) > 0).all()
    assert (np.diff(both[128:]) < 0).all()


def test_lines_differ_in_colour_dash_and_marker():
    for part in zip(*style.LINES, strict=True):
        assert len({str(item) for item in part}) == len(style.LINES)
    assert max(luminance([to_rgb(colour) for colour, _, _ in style.LINES])) < 0.6


def test_curves_show_the_values_with_gaps_and_reasons(speed):
    ax = speed.plot.curves("segments", by="slope_deg", slope_deg=[0, 10, 30], anchor_weight=1)
    lines = [line for line in ax.lines if line.get_marker() != "*"]
    assert len(lines) == 3
    np.testing.assert_array_equal(lines[1].get_ydata(), speed.values[5, 1, :])
    assert lines[2].get_label().endswith("no value")
    below = [legend for legend in ax.get_children() if isinstance(legend, mpl.legend.Legend)]
    words = [" ".join(t.get_text().split()) for legend in below for t in legend.get_texts()]
    for code in set(np.unique(speed.status[[0, 5, 15], 1, :]).tolist()) - {0}:
        assert f"gap: {ls.Status(code).sentence}" in words
    stars = [line for line in ax.lines if line.get_marker() == "*"]
    assert [star.get_xdata()[0] for star in stars] == [3.0, 5.0]


def test_curve_of_whole_numbers_is_a_step_line():
    r = ls.sweep("best_segments", **MU, slope_deg=np.linspace(0, 20, 50))
    assert r.plot.curves("slope_deg").lines[0].get_drawstyle() == "steps-mid"


@pytest.mark.parametrize("shape", [(1, 1), (1, 3), (3, 1)])
def test_axes_of_one_value(shape, tmp_path):
    slopes, counts = [0, 5, 10][: shape[0]], [3, 4, 5][: shape[1]]
    r = ls.sweep("mean_velocity", **MU, slope_deg=slopes, segments=counts)
    save_figure(r.plot.heatmap(), tmp_path / "a.png")
    save_figure(r.plot.curves("segments", slope_deg=0), tmp_path / "b.png")


def test_a_figure_that_was_laid_out_is_saved_as_one_that_was_not(speed, tmp_path):
    for name in ("plain.png", "laid_out.png"):
        figure = speed.plot.heatmap(anchor_weight=1).figure
        assert figure.get_layout_engine() is not None
        if name == "laid_out.png":
            lay_out(figure)
            assert figure.get_layout_engine() is None
        save_figure(figure, tmp_path / name)
    assert (tmp_path / "plain.png").read_bytes() == (tmp_path / "laid_out.png").read_bytes()


def test_own_axes_are_used(speed):
    figure = Figure()
    left, right = figure.subplots(1, 2)
    assert speed.plot.heatmap(anchor_weight=1, ax=left) is left
    assert speed.plot.curves("segments", slope_deg=0, anchor_weight=1, ax=right) is right
    assert len(figure.axes) == 3


def test_all_symbols_can_be_drawn():
    parser = MathTextParser("path")
    for record in [*ls.parameters(), *ls.quantities()]:
        parser.parse(f"${record.symbol}$")


def test_pyplot_shows_what_is_drawn_without_axes(speed):
    import matplotlib.pyplot as plt

    ax = speed.plot.heatmap(anchor_weight=1)
    assert plt.gcf() is ax.figure
    other = speed.plot.curves("segments", slope_deg=0, anchor_weight=1)
    assert other.figure is not ax.figure
    assert plt.get_fignums() == [1, 2]


def test_an_empty_figure_of_pyplot_is_used_and_a_full_one_is_left(speed):
    import matplotlib.pyplot as plt

    mine = plt.figure(figsize=(3, 2))
    assert speed.plot.heatmap(anchor_weight=1).figure is mine
    _, (left, right) = plt.subplots(1, 2)
    assert speed.plot.curves("segments", slope_deg=0, anchor_weight=1) is right
    plt.sca(left)
    assert speed.plot.heatmap(anchor_weight=0) is left
    assert speed.plot.heatmap(anchor_weight=0).figure is plt.figure(3)
    shown = locosweep.plot.motion(ls.simulate(law="coulomb", mu_coulomb=0.3, drive_force=2))
    assert shown[0].figure is plt.figure(4)


CODE = """
import sys, matplotlib
from matplotlib.figure import Figure
before = dict(matplotlib.rcParams)
import locosweep as ls
from locosweep.cli import main
from locosweep.plot.save import save_figure
r = ls.sweep("mean_velocity", mu_static=0.5, mu_coulomb=0.3, slope_deg=[0, 40], segments=[3, 4])
for kind in ("png", "svg", "pdf"):
    save_figure(r.plot.heatmap(ax=Figure().subplots()), "a." + kind)
r.save("r.parquet")
mu = ["--set", "mu_coulomb=0.3"]
assert main(["plot", "r.parquet"]) == 0
assert main(["plot", "r.parquet", "--by", "slope_deg", "--out", "b.svg"]) == 0
assert main(["simulate", *mu, "--set", "drive_force=2", "--plot", "m.png"]) == 0
assert main(["heatmap", "mean_velocity", "--x", "segments=2:4", "--y", "slope_deg=0:9:3", *mu,
             "--set", "mu_static=0.5"]) == 0
assert main(["laws", "dahl", "--out", "laws"]) == 0
assert dict(matplotlib.rcParams) == before
assert "matplotlib.pyplot" not in sys.modules
"""


@pytest.mark.whole
def test_axes_of_ones_own_and_commands_load_no_pyplot_and_change_no_setting(tmp_path):
    # Without it, reading rcParams looks for a backend and loads pyplot.
    environment = {**os.environ, "MPLBACKEND": "agg"}
    command = [sys.executable, "-W", "error", "-c", CODE]
    subprocess.run(command, check=True, env=environment, cwd=tmp_path)


def test_png_says_what_it_shows(speed, tmp_path):
    file = tmp_path / "a.png"
    spec = spec_hash(speed)
    ax = speed.plot.heatmap(anchor_weight=1)
    save_figure(ax, file, command="locosweep sweep ü", spec=spec)
    with Image.open(file) as image:
        assert image.info["Software"] == f"locosweep {ls.__version__}"
        assert image.info["Spec"] == spec
        assert image.info["Command"] == "locosweep sweep ü"
        assert abs(image.info["dpi"][0] - 150) < 0.1


@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_bytes_repeat_and_carry_provenance(speed, kind, tmp_path):
    hashes = set()
    for name in ("a", "b"):
        file = tmp_path / f"{name}.{kind}"
        save_figure(speed.plot.heatmap(anchor_weight=1), file, command="made by hand", spec="abc")
        hashes.add(hashlib.sha256(file.read_bytes()).hexdigest())
    assert len(hashes) == 1
    text = file.read_bytes()
    assert f"locosweep {ls.__version__}".encode() in text
    assert b"made by hand" in text
    assert sorted(p.name for p in tmp_path.iterdir()) == [f"a.{kind}", f"b.{kind}"]


def test_spec_hash_follows_the_question_not_the_numbers():
    grid = ls.Grid(**MU, segments=[3, 4])
    one = ls.sweep("mean_velocity", grid)
    assert spec_hash(one) == spec_hash(ls.sweep("mean_velocity", grid, dtype="float32"))
    others = [
        ls.sweep("cycle_time", grid),
        ls.sweep("mean_velocity", **MU, segments=[3, 5]),
        ls.sweep("mean_velocity", grid, slope_deg=1),
        ls.sweep("mean_velocity", grid, over="segments", reduce="max"),
    ]
    assert len({spec_hash(r) for r in [one, *others]}) == 5
    assert spec_hash(one, others[0]) != spec_hash(one)


BAD = [
    (lambda r: r.plot.heatmap(), "need one value each: slope_deg"),
    (lambda r: r.plot.heatmap("segments", "slope_deg"), "anchor_weight=0|1"),
    (lambda r: r.plot.heatmap("segmets"), "did you mean 'segments'"),
    (lambda r: r.plot.heatmap("segments", "segments", slope_deg=0, anchor_weight=0), "both"),
    (lambda r: r.plot.heatmap(anchor_weight=0.5), "anchor_weight is 0.5: allowed"),
    (lambda r: r.plot.heatmap(anchor_weight="one"), "anchor_weight is 'one'"),
    (lambda r: r.plot.heatmap(anchor_weight=[0]), r"anchor_weight is \[0\]"),
    (lambda r: r.plot.heatmap(anchor_weight=float("nan")), "anchor_weight is nan"),
    (lambda r: r.plot.heatmap(mass=1), "unknown axis 'mass'"),
    (lambda r: r.plot.heatmap(segments=3, slope_deg=0), "needs two axes"),
    (lambda r: r.plot.heatmap("segments", segments=3, anchor_weight=0), "an axis of the picture"),
    (lambda r: r.plot.heatmap(value="speed", anchor_weight=0), "unknown output 'speed'"),
    (lambda r: r.plot.heatmap(anchor_weight=0, cmap="jett"), "cmap is 'jett'"),
    (lambda r: r.plot.heatmap(anchor_weight=0, norm="logit"), "norm is 'logit'"),
    (lambda r: r.plot.heatmap(value="net_force", anchor_weight=1, norm="log"), "norm is 'log'"),
    (lambda r: r.plot.curves("segments", by="slope_deg", anchor_weight=1), "16 lines"),
    (lambda r: r.plot.curves("segments", by="segments"), "already x"),
    (lambda r: r.plot.curves("segments", by="slope_deg"), "lines|one value"),
    (lambda r: r.plot.curves("nothing"), "unknown axis"),
    (lambda _: save_figure(Figure(), "a.jpg"), r"\.png, \.svg, \.pdf"),
    (lambda _: save_figure(Figure(), "no/such/folder/a.png"), "does not exist"),
]


@pytest.mark.parametrize(("call", "text"), BAD)
def test_bad_input_is_named_in_one_line(speed, call, text):
    with pytest.raises(ls.InputError, match=text) as caught:
        call(speed)
    assert "\n" not in str(caught.value)


def test_infinite_axis_values_are_refused_along_an_axis_but_fine_as_lines():
    r = ls.sweep("mean_velocity", **MU, drive_limit=[1, np.inf], segments=[3, 4])
    with pytest.raises(ls.InputError, match="drive_limit has infinite values"):
        r.plot.heatmap()
    ax = r.plot.curves("segments", by="drive_limit")
    assert any("∞" in text for text in legend_texts(ax))


def test_long_axes_are_thinned_but_optimum_and_colours_are_of_all_cells():
    x, y = np.linspace(0.5, 0.9, 1501), np.linspace(0.1, 0.3, 3)
    result = ls.sweep("mean_velocity", mu_static=x, mu_coulomb=y[::-1], segments=4)
    values = result.values.copy()
    values[700, 1] = 9.0
    held = ls.Result(result.outputs, result.axes, result.fixed, [values])
    ax = held.plot.heatmap("mu_static", "mu_coulomb")
    mesh = ax.collections[0]
    assert mesh.get_array().shape == (3, 600)
    assert 9.0 not in mesh.get_array()
    assert mesh.norm.vmax == 9.0
    star = next(line for line in ax.lines if line.get_marker() == "*")
    assert star.get_xdata()[0] == x[700]
    assert star.get_ydata()[0] == y[1]


def offsets(figure):
    figure.canvas.draw()
    return [axis.get_offset_text().get_text()
            for ax in figure.axes for axis in (ax.xaxis, ax.yaxis)]  # fmt: skip


def test_axes_have_no_factor_or_offset_in_a_corner():
    near = 0.85 + 1e-6 * np.arange(5)
    r = ls.sweep("mean_velocity", **MU, drive_limit=near, segments=[3, 4])
    line = ls.sweep("mean_velocity", **MU, drive_limit=near, segments=4)
    run = ls.simulate(law="coulomb", mu_coulomb=0.3, drive_force=2, duration=1e-7)
    for ax in (r.plot.heatmap(), line.plot.curves("drive_limit"), locosweep.plot.motion(run)[0]):
        assert set(offsets(ax.figure)) == {""}
    ticks = [text.get_text() for text in line.plot.curves("drive_limit").get_xticklabels()]
    assert len(set(ticks)) == len(ticks) > 2
    assert all(abs(float(text) - 0.85) < 1e-5 for text in ticks)


@pytest.mark.parametrize("start", [0.0, 1.0, -2.5, 123.0, 1e7])
@pytest.mark.parametrize("step", [1e-9, 1e-6, 0.002, 0.25, 1.0, 5e3, 2e8])
def test_numbers_at_ticks_are_whole_and_differ(start, step):
    if step < 1e-13 * abs(start):
        return
    ticks = start + step * np.arange(-2, 3)
    texts = PlainNumbers().format_ticks(ticks)
    read = [float(text.replace("−", "-")) for text in texts]
    np.testing.assert_allclose(read, ticks, atol=1e-2 * step)
    assert max(map(len, texts)) <= 18


def test_title_says_what_is_fixed_but_not_what_is_left_out():
    r = ls.sweep("mean_velocity", **MU, slope_deg=[0, 10], segments=[3, 4], drive_limit=0.85)
    ax = r.plot.heatmap(note="robot: mine.toml")
    fixed, note = ax.get_title().splitlines()[:-1], ax.get_title().splitlines()[-1]
    text = " ".join(fixed)
    assert text.startswith("fixed: ")
    for word in (r"$\mu_S$ = 0.5", r"$\mu_C$ = 0.3", r"$\delta$ = 0.02 m", "0.85 N"):
        assert word in text
    assert note == "robot: mine.toml"
    # No viscous friction and no slope of its own: these stand in no caption.
    assert parameter("viscous").symbol not in text
    assert parameter("slope_deg").symbol not in text
    best = ls.sweep("mean_velocity", **MU, slope_deg=[0, 10], stroke=[0.01, 0.02],
                    segments=range(2, 9), over="segments", reduce="max")  # fmt: skip
    assert "$N$ from 2 to 8" in best.plot.heatmap().get_title()


def test_long_captions_are_broken_into_lines():
    lines = caption.title(["a = 1"], [f"$x_{{{i}}}$ = {i} m" for i in range(30)]).splitlines()
    assert lines[0] == "a = 1"
    assert lines[1].startswith("fixed: ")
    assert 3 <= len(lines) <= 7
    assert all(len(caption._plain(line)) <= caption._WIDTH + 2 for line in lines)
    assert caption.title([], []) == ""


def test_only_what_is_better_when_larger_is_marked():
    better = {q.name for q in ls.quantities() if q.larger_is_better}
    assert better >= {"mean_velocity", "final_position", "gait_advance"}
    assert not better & {"stroke_time", "cycle_time", "gait_slip", "dissipated"}
    given = {"law": "coulomb", "mu_coulomb": [0.1, 0.2], "drive_force": [2, 3], "stroke": 0.01}
    slow = ls.sweep("stroke_time", **given)
    assert not slow.plot.heatmap().lines
    assert slow.plot.heatmap(mark_optimum=True).lines
    assert ls.sweep("final_position", **given).plot.heatmap().lines
    line = ls.sweep("stroke_time", **{**given, "mu_coulomb": 0.1}).plot.curves("drive_force")
    assert [one.get_marker() for one in line.lines] == [""]


@pytest.mark.parametrize("size", [2, 3, 40])
@pytest.mark.parametrize("slopes", [(0, 10), (-10, 0)])
def test_the_star_stands_off_the_tick_labels(size, slopes):
    r = ls.sweep("mean_velocity", mu_static=np.linspace(0.5, 0.9, size), mu_coulomb=0.3,
                 segments=3, slope_deg=np.linspace(*slopes, size))  # fmt: skip
    ax = r.plot.heatmap()
    ax.figure.canvas.draw()
    star = next(line for line in ax.lines if line.get_marker() == "*")
    # Half of a star's size is 7 points.
    frame = ax.get_window_extent()
    x, y = star.get_transform().transform(np.column_stack(star.get_data()))[0]
    room = 0.9 * 7 / 72 * ax.figure.dpi
    assert frame.x0 + room < x < frame.x1 - room
    assert frame.y0 + room < y < frame.y1 - room


def contour_texts(values, output_of="final_position"):
    """Labels of the contours of a map with given values."""
    given = {"law": "coulomb", "mu_coulomb": np.linspace(0.1, 0.5, values.shape[0])}
    r = ls.sweep(output_of, **given, drive_force=np.linspace(0.1, 1, values.shape[1]))
    r.values[:] = values
    return [text.get_text() for text in r.plot.heatmap().texts]


def test_rounding_errors_have_no_contours():
    random = np.random.default_rng(0)
    noise = 1e-17 * random.standard_normal((20, 20))
    ramp = np.maximum(0.0, np.linspace(-1.0, 1.0, 20))[:, None] * np.ones(20)
    assert contour_texts(0.3 + noise) == []
    # Robots that stay where they are, but for rounding, and others that move.
    found = contour_texts(ramp + noise)
    assert found
    assert "0 m" not in found
    assert "0 m" in contour_texts(np.linspace(-1.0, 1.0, 20)[:, None] + noise)


def test_the_highest_of_whole_numbers_is_one_and_has_no_contours():
    r = ls.sweep("best_segments", **MU, slope_deg=np.linspace(0, 20, 12), stroke=[0.01, 0.02, 0.03],
                 anchor_weight=[0, 1], over="anchor_weight", reduce=["max", "mean"])  # fmt: skip
    assert [output.integer for output in r.outputs] == [True, False]
    ax = r.plot.heatmap(value="best_segments_max")
    assert not ax.texts
    assert isinstance(ax.collections[0].norm, BoundaryNorm)
    assert not r.plot.heatmap(value="best_segments_max", levels=5).texts


def test_a_reduced_axis_is_named_where_none_of_it_works():
    r = ls.sweep("mean_velocity", **MU, slope_deg=[0, 40], stroke=[0.01, 0.02],
                 segments=range(2, 9), over="segments", reduce="argmax")  # fmt: skip
    words = " ".join(legend_texts(r.plot.heatmap()))
    assert "no value of segments from 2 to 8 works" in words
    assert "reduced axis" not in words


def test_cells_overlap_so_that_vector_pictures_have_no_seams(speed):
    mesh = speed.plot.heatmap(anchor_weight=1).collections[0]
    assert mesh.get_linewidth()[0] > 0
    mesh.figure.canvas.draw()
    np.testing.assert_array_equal(mesh.get_edgecolor(), mesh.get_facecolor())


def test_a_quantile_says_which():
    r = ls.sweep("mean_velocity", **MU, mass=np.linspace(0.1, 0.4, 5), segments=[3, 4],
                 slope_deg=[0, 5], over="mass", reduce="quantile", q=0.05)  # fmt: skip
    title = " ".join(r.plot.heatmap().get_title().split())
    assert "$q$ = 0.05" in title
    assert "(0.05)" in repr(r)


def test_a_closed_form_beside_a_simulated_output_is_not_called_simulated():
    r = ls.sweep(["mean_velocity", "final_position"], **MU, slope_deg=[0, 5], segments=[3, 4])
    assert "drive" not in r.plot.heatmap(value="mean_velocity").get_title()
    assert "drive" in r.plot.heatmap(value="final_position").get_title()


@pytest.mark.parametrize("slopes", [[-30.0, -20.0], [-20.0, 0.0, 30.0], [0.0, 30.0]])
def test_colours_of_a_log_norm_take_values_of_any_sign_and_size(slopes):
    r = ls.sweep("resistance", mu_coulomb=0.3, slope_deg=slopes, mass=np.geomspace(1e-9, 1e3, 9))
    ax = r.plot.heatmap("mass", "slope_deg", norm=LogNorm(1e-3, 1.0))
    ax.figure.canvas.draw()


def test_a_value_between_two_gaps_is_a_point():
    r = ls.sweep("cycle_time", slope_deg=[-30, 0, 40], segments=4, mu_static=0.5, mu_coulomb=0.3)
    assert np.isfinite(r.values).tolist() == [False, True, False]
    ax = r.plot.curves("slope_deg")
    points = [line for line in ax.lines if line.get_marker() != ""]
    assert any(line.get_xdata().tolist() == [0.0] for line in points)
    assert ax.get_xlim()[0] <= -30.0
    assert ax.get_xlim()[1] >= 40.0


def test_counts_are_written_in_full():
    assert style.setting("segments", 12345.0) == "$N$ = 12345"
