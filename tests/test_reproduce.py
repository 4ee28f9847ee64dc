"""The paper's figures and numbers come out, and the verdicts follow from them."""

import re

import numpy as np
import pytest
from PIL import Image

import locosweep as ls
from locosweep.paper.claims import crossing
from locosweep.paper.reproduce import Report, reproduce

pytestmark = pytest.mark.whole

NUMBERS = (2, 3, 4, 5, 7, 8, 9, 10, 11, 12, 13)
ILLUSTRATIONS = (7, 8, 9, 11)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    calls = []
    folder = tmp_path_factory.mktemp("paper") / "new" / "folder"
    report = reproduce("all", folder, progress=lambda *state: calls.append(state))
    return report, folder, calls


def row(made, *words):
    hits = [r for r in made[0].rows if all(word in f"{r.claim} {r.source}" for word in words)]
    assert len(hits) == 1, hits
    return hits[0]


def numbers(text):
    return [float(n) for n in re.findall(r"-?\d+\.?\d*", text)]


def test_all_files_are_there_and_legible(made):
    report, folder, calls = made
    names = [f"figure{n}.png" for n in NUMBERS] + ["reproduction.png", "reproduction.md"]
    assert [file.name for file in report.files] == names
    assert sorted(p.name for p in folder.iterdir()) == sorted(names)
    for file in report.files[:-1]:
        with Image.open(file) as image:
            assert min(image.size) > 700
            assert image.info["Software"] == f"locosweep {ls.__version__}"
            assert "reproduce" in image.info["Command"]
    assert [done for done, _, _ in calls] == list(range(1, 14))
    assert all(total == 13 and rate > 0 for _, total, rate in calls)


def test_markdown_holds_every_row(made):
    report, folder, _ = made
    text = (folder / "reproduction.md").read_text(encoding="utf-8")
    table = [line for line in text.splitlines() if line.startswith("| ")]
    assert len(table) == len(report.rows) + 2
    assert {line.count("|") for line in table} == {7}
    for r in report.rows:
        assert any(r.claim in line and r.ours in line and r.verdict in line for line in table)
    assert text == report.to_markdown()


def test_four_at_equal_friction(made):
    r = row(made, "on the flat with equal coefficients")
    assert numbers(r.ours) == [4, 4]
    assert r.verdict == "agrees"
    assert numbers(row(made, "only accelerates").ours)[:2] == [4, 3]


def test_forces(made):
    net, gross = row(made, "net of friction"), row(made, "gross, as (4)")
    assert numbers(net.ours) == pytest.approx([3.19021], abs=5e-4)
    assert net.verdict == "agrees"
    assert numbers(gross.ours) == pytest.approx([3.98777], abs=5e-4)
    assert gross.verdict == "differs"
    drive = row(made, "far below")
    assert numbers(drive.ours)[0] == 27
    assert drive.verdict == "agrees"
    assert "N* = 2" in drive.note
    assert row(made, "far above friction").verdict == "ambiguous in the paper"


def test_figure_2_both_variants(made):
    one, zero = row(made, "Highest", "w = 1"), row(made, "Highest", "w = 0")
    assert numbers(one.ours) == [3, 11, 1.91, 7.97]
    assert numbers(zero.ours) == [7, 11, 3.27, 17.28]
    assert {one.verdict, zero.verdict} == {"ambiguous in the paper"}
    flat = row(made, "Highest", "flat ground")
    assert flat.verdict == "differs"
    assert numbers(flat.ours)[:3] == [3, 87.35, 85.78]
    assert "1.8%" in flat.note


def test_figure_3_trends(made):
    assert row(made, "grows with the number").verdict == "agrees"
    assert row(made, "falls with the slope").verdict == "agrees"


def test_figure_4_reaches_500(made):
    one, zero = row(made, "extreme", "w = 1"), row(made, "extreme", "w = 0")
    assert numbers(one.ours)[:2] == [500, 26.38]
    assert numbers(zero.ours)[0] == 500
    assert numbers(zero.ours)[1] == pytest.approx(68.0, abs=0.05)
    assert {one.verdict, zero.verdict} == {"agrees"}


def test_figure_5_crossing_and_limits(made):
    dropped, kept = (row(made, "curves cross", word) for word in ("dropped", "kept"))
    assert numbers(dropped.ours) == pytest.approx([0.328376, 1.449616], abs=5e-4)
    assert dropped.verdict == "agrees"
    assert "2.686" in dropped.note
    assert kept.verdict == "differs"
    assert "2.015" in kept.note
    assert numbers(row(made, "Limit", "dropped").ours) == pytest.approx([3.190212], abs=5e-4)
    assert numbers(row(made, "Limit", "kept").ours) == pytest.approx([2.392659], abs=5e-4)
    assert numbers(row(made, "Dry velocity").ours)[0] == 4.4145


def test_cycle_time(made):
    assert row(made, "Cycle time", "cycle time N t").verdict == "differs"
    assert row(made, "Cycle time", "phase time t").verdict == "agrees"


def test_three_surfaces(made):
    near = row(made, "almost equal")
    apart, _, *times = numbers(near.ours)
    assert apart < 2
    assert times[1:] == sorted(times[1:])
    late = numbers(row(made, "arrives later").ours)
    assert 0 < late[1] < late[0] < 10
    rear = row(made, "rear stands still")
    # 0.85 N of (N - 1) mu_S m g.
    assert numbers(rear.ours) == pytest.approx([0, 0.85, 36, 2.39, 21, 3.99])
    force, power = row(made, "Figure 12"), row(made, "Figure 13")
    # At constant voltage power is proportional to force: 10 V over 1.7 N/A.
    assert numbers(force.ours)[0] == numbers(power.ours)[0] < 10
    assert numbers(power.ours)[1] == 5
    verdicts = {r.verdict for r in (near, rear, force, power)}
    assert verdicts == {"agrees"}
    assert all("assumed" in r.note for r in (near, rear, force, power))


def test_other_segments_move_above_the_gross_anchoring_capacity(made):
    r = row(made, "other segments move")
    # (N - 1) mu_S m g: 3.2 N is the net force, below which and above which they stand still.
    assert numbers(r.ours) == pytest.approx([3.98777, 3.25, 0.0], abs=5e-4)
    assert r.verdict == "differs"
    assert numbers(r.note)[-1] == pytest.approx(0.5 * 0.271 * 9.81, abs=5e-4)


def test_the_drive_that_moves_others_is_what_the_simulation_says():
    from locosweep.paper.limits import drive_that_moves_others, ways_of_others

    found = drive_that_moves_others(slice(0, 1))
    capacity = 3 * 0.5 * 0.271 * 9.81
    assert found == pytest.approx(capacity, abs=2e-6)
    assert ways_of_others(found - 1e-5)[0] == 0.0
    assert ways_of_others(found + 1e-5)[0] > 1.0


def test_velocity_falls_beyond_the_optimum(made):
    r = row(made, "Velocity falls with the number", "Figure 2")
    assert r.verdict == "agrees"
    flat, steep = r.ours.split(". w = 0")[0].split("; ")
    assert numbers(flat) == [1, 11, 11, 0, 87.3, 77.4, 27.3, 3, 6, 64]
    assert numbers(steep) == [20, 23.1, 19.9, 13.3, 12, 24, 64]


@pytest.mark.parametrize(
    ("surface", "law", "planted"),
    [
        ("dry", "coulomb", {"mu_coulomb": 0.15}),
        ("oil", "coulomb_viscous", {"mu_coulomb": 0.15, "viscous": 0.2}),
        ("lubricant", "buildup", {"mu_coulomb": 0.15, "viscous": 0.2, "buildup": 5.0}),
    ],
)
def test_friction_planted_in_the_rig_is_found_again(surface, law, planted):
    from locosweep.paper.contact import contact

    of = contact(surface)
    assert of.planted == planted
    assert of.fit.status == "chosen"
    assert of.fit.chosen.law == law
    assert not of.fit.chosen.offset
    for name, found in of.fit.chosen.parameters.items():
        if found.interval is None:
            assert found.value == planted.get(name, 0.0) == 0.0
            continue
        low, high = found.interval
        assert low < planted.get(name, 0.0) < high, name
    # Nothing but the load cell's 0.01 N is left where the sign of the velocity is certain: below
    # it noise ends a stroke early, and with it the heap.
    data, law = of.fit.data, of.fit.chosen
    sure = np.abs(data.column("v")) > 0.005
    left = (data.column("force") - law.held_out)[sure]
    assert np.sqrt(np.mean(left**2)) == pytest.approx(0.01, rel=0.05)


def test_the_heap_pushes_in_proportion_and_holds_the_layer_scraped_up():
    from locosweep.paper.heap import heap_force, heap_size

    t = np.linspace(0.0, 0.2, 101)
    way = 0.5 * t**2
    assert heap_force(t, way, "lubricant") == pytest.approx(5.0 * way, abs=1e-12)
    assert not heap_force(t, way, "oil").any()
    length, height = heap_size(0.02)
    assert length * height / 2 == pytest.approx(0.5e-3 * 0.02)
    assert height / length == pytest.approx(np.tan(np.radians(30.0)))


def test_illustrations_are_named_as_such_and_compared_with_nothing(made, tmp_path):
    from locosweep.paper.reproduce import _FIGURES

    assert tuple(_FIGURES) == NUMBERS
    for number in ILLUSTRATIONS:
        title = _FIGURES[number]()[0].get_suptitle()
        assert title.startswith(f"Figure {number}: ")
        assert "Illustration: the paper prints no numbers" in title
        assert "assumed" in title
    assert "illustrates them and is compared with nothing" in made[0].to_markdown()
    report = reproduce(7, tmp_path)
    assert report.files[0].name == "figure7.png"
    assert not [r for r in report.rows if "Figure" in r.source and "7" in r.source]


def test_build_up_in_the_whole_robot(made):
    swept = row(made, "Build-up in the whole robot")
    head, follower = numbers(swept.ours)
    # As the single segment: the heap holds up the head by some per cent, and nobody else.
    assert 1 < head < 5
    assert follower < 0.1
    assert (swept.verdict, "assumed" in swept.note) == ("agrees", True)


def test_dry_head_reaches_the_stroke_as_the_viscous_closed_form():
    from locosweep.paper.surfaces import _head

    head = _head("dry")
    loss = 1.7**2 / 20
    form = ls.sweep("phase_time", mu_static=10, mu_coulomb=0.15, segments=4, viscous=loss,
                    drive_limit=0.85)  # fmt: skip
    assert head.arrival == pytest.approx(float(form.values), rel=1e-6)
    assert head.x[-1] == pytest.approx(0.02, rel=1e-6)


def test_crossing_of_two_known_curves():
    t = np.linspace(0, 2, 21)
    assert crossing(t, t, t**2) == pytest.approx((1.0, 1.0), abs=1e-9)
    assert crossing(t, t, 2 * t) is None


def test_one_figure_only(tmp_path):
    report = reproduce([5], tmp_path)
    assert isinstance(report, Report)
    assert [f.name for f in report.files] == ["figure5.png", "reproduction.png", "reproduction.md"]
    sources = {r.source for r in report.rows}
    assert "Figure 5" in sources
    assert not sources & {"Figure 2", "Figure 3", "Figure 4"}


@pytest.mark.parametrize("figures", [6, 14, "5", [], [2, 6], True, "everything"])
def test_other_figures_are_refused_in_one_line(figures, tmp_path):
    with pytest.raises(
        ls.InputError, match="2, 3, 4, 5, 7, 8, 9, 10, 11, 12, 13 or 'all'"
    ) as caught:
        reproduce(figures, tmp_path)
    assert "\n" not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_a_file_in_the_way_is_named(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(ls.InputError, match="taken"):
        reproduce(5, tmp_path / "taken")


def test_a_robot_file_is_held_against_the_paper(tmp_path):
    robot = ls.Robot(parameters={"segments": 5.0, "mass": 0.271})
    rows = reproduce(5, tmp_path, robot=robot).rows
    verdicts = [row.verdict for row in rows if row.claim.startswith("Robot file")]
    assert verdicts == ["differs", "agrees", "differs"]
