"""Parts and pictures of run folders: those of the result, from the cells that they show."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from run_cases import ALL, CLOSED, forget_last_chunk

import locosweep as ls
from locosweep.cli import main
from locosweep.plot import heatmap as pictures
from locosweep.run_folder.verified_store import VerifiedStore

LONG: dict[str, Any] = {**CLOSED, "mu_static": np.linspace(0.2, 0.8, 60)}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("whole") / "run"
    ls.sweep(**CLOSED, chunk=40, out=folder)
    return folder


@pytest.fixture(scope="module")
def long(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("long") / "run"
    ls.sweep(**LONG, chunk=7, out=folder)
    return folder


def empty() -> Any:
    """Return axes of a figure of their own."""
    return Figure(figsize=(6.8, 5.0), layout="constrained").subplots()


@pytest.mark.parametrize("kind", ALL)
def test_a_part_is_that_of_the_result(kind: str, tmp_path: Path) -> None:
    result = ls.sweep(**ALL[kind])
    run = ls.sweep(**ALL[kind], chunk=5, out=tmp_path / "run")
    first, *_ = result.axes
    at = {first: result.axes[first][::-2]}
    for given in ({}, at, {first: result.axes[first][1]}):
        mine, theirs = run.sel(**given), result.sel(**given)
        assert mine.fixed == theirs.fixed
        assert list(mine.axes) == list(theirs.axes)
        for output in run.outputs:
            assert np.array_equal(mine[output.name], theirs[output.name], equal_nan=True)
            assert np.array_equal(mine.status_of(output.name), theirs.status_of(output.name))


def test_odd_parts_are_refused(whole: Path) -> None:
    run = ls.open_run(whole)
    for given, words in (
        ({"mass": 1.0}, "unknown axis 'mass'"),
        ({"segments": 2.5}, "segments is 2.5: allowed are the values of that axis"),
        ({"segments": []}, "segments is empty"),
        ({"method": "far"}, "method is 'far'"),
    ):
        with pytest.raises(ls.InputError, match=words):
            run.sel(**given)
    assert run.sel(segments=[7, 3, 7]).axes["segments"].tolist() == [7.0, 3.0, 7.0]
    near = run.sel(segments=4.2, slope_deg=9, method="nearest")
    assert (near.fixed["segments"], near.fixed["slope_deg"]) == (4.0, 10.0)


def test_pictures_are_those_of_the_result(whole: Path) -> None:
    run, result = ls.open_run(whole), ls.sweep(**CLOSED)
    for draw, given in (
        ("heatmap", {"x": "segments", "y": "mu_static", "slope_deg": 10.0, "levels": 3}),
        ("heatmap", {"value": "peak_power", "mu_static": 0.5, "note": "a robot"}),
        ("curves", {"x": "segments", "by": "slope_deg", "mu_static": 0.5}),
        ("curves", {"x": "mu_static", "by": "segments", "segments": [3, 5], "slope_deg": 0.0}),
    ):
        drawn = []
        for shown in (run, result):
            ax = getattr(shown.plot, draw)(ax=empty(), **given)
            drawn.append(sorted(text.get_text().replace("fixed: ", "") for text in ax.texts))
            drawn.append(ax.get_xlabel() + ax.get_ylabel())
            values = [c.get_array() for c in ax.collections if c.get_array() is not None]
            values += [line.get_ydata() for line in ax.lines]
            drawn.append([np.ma.filled(one, np.nan).tolist() for one in values])
        assert repr(drawn[:3]) == repr(drawn[3:])


def test_of_a_long_axis_some_cells_are_read(long: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pictures, "_MOST_CELLS", 6)
    run = ls.open_run(long)
    read: set[str] = set()
    content = VerifiedStore._content

    def told(store: VerifiedStore, key: str) -> bytes | None:
        read.add(key)
        return content(store, key)

    monkeypatch.setattr(VerifiedStore, "_content", told)
    ax = run.plot.heatmap("segments", "mu_static", slope_deg=0.0, ax=empty(), note="mine")
    assert ax.collections[0].get_array().shape == (6, 6)
    words = " ".join(ax.get_title().split())
    assert "mine; drawn: 6 of 7 values of segments, 6 of 60 values of mu_static" in words
    chunks = {key.partition("/")[2] for key in read if key.startswith("mean_velocity/c")}
    assert 0 < len(chunks) < run.manifest.plan.count / 2


def test_what_is_no_picture_is_refused_before_cells_are_read(
    whole: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = ls.open_run(whole)
    monkeypatch.setattr(type(run), "read", lambda *_: pytest.fail("read"))
    for draw, given, words in (
        ("heatmap", {}, "these axes need one value each: mu_static="),
        ("heatmap", {"x": "segments", "y": "segments"}, "x and y are both segments"),
        ("heatmap", {"x": "mass"}, "unknown axis 'mass'"),
        ("heatmap", {"x": "segments", "y": "mu_static", "segments": 3}, "it is an axis of the pic"),
        ("curves", {"x": "segments"}, "these axes need one value each"),
        ("curves", {"x": "segments", "by": "mass"}, "unknown axis 'mass'"),
    ):
        with pytest.raises(ls.InputError, match=words):
            getattr(run.plot, draw)(**given)


def test_a_run_that_is_not_whole_says_so(whole: Path, tmp_path: Path) -> None:
    folder = tmp_path / "holed"
    shutil.copytree(whole, folder)
    forget_last_chunk(folder)
    with pytest.raises(ls.InputError, match="chunks are not computed"):
        ls.open_run(folder).plot.heatmap("segments", "mu_static", slope_deg=0.0)
    run = ls.open_run(folder, allow_missing=True)
    with pytest.raises(ls.InputError, match="this part is not computed as a whole"):
        run.plot.curves("segments", mu_static=0.8, slope_deg=30.0)
    first = run.plot.curves("segments", mu_static=0.2, slope_deg=0.0)
    assert first.get_lines()


def test_the_command_draws_a_run(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(("plot", f"{whole}/", "--x", "segments", "--at", "slope_deg=10")) == 0
    assert (tmp_path / "run.png").read_bytes()[1:4] == b"PNG"
    assert main(("plot", str(whole), "--by", "slope_deg", "--at", "mu_static=0.5",
                 "--out", "lines.svg")) == 0  # fmt: skip
    assert (tmp_path / "lines.svg").exists()
    capsys.readouterr()
    assert main(("plot", str(tmp_path), "--out", "no.png")) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert not (tmp_path / "no.png").exists()


def test_a_picture_of_a_run_names_what_it_is_cut_at(tmp_path: Path) -> None:
    run = ls.sweep(**CLOSED, out=tmp_path / "run")
    result = ls.sweep(**CLOSED)
    titles = [one.plot.heatmap("segments", "mu_static", slope_deg=0).get_title()
              for one in (run, result)]  # fmt: skip
    assert titles[0] == titles[1]
    run.plot.curves("segments", by="mu_static", mu_static=0.5, slope_deg=0)
