"""Pages that show a sweep: what they carry, what they leave out, and which commands they give."""

import base64
import json
import re
import shlex

import numpy as np
import pytest

import locosweep as ls
from locosweep.cli import main
from locosweep.errors import InputError
from locosweep.plot.explorer.cells import NOT_COMPUTED, chosen, packed, told
from locosweep.plot.explorer.commands import python_axis, shell_axis
from locosweep.plot.explorer.page import LARGEST, Explorer, digest_of, explorer, json_block
from locosweep.registry import Status

SURFACE = {"mu_static": 0.5, "mu_coulomb": 0.3}


def read(html):
    """The data of a page and the arrays of its outputs, with their statuses."""
    data = json.loads(re.search(r'id="sweep">(.*?)</script>', html)[1])
    arrays = []
    for k, output in enumerate(data["outputs"]):
        raw = base64.b64decode(re.search(rf'id="values-{k}">(.*?)</script>', html)[1])
        if output["kind"] == "float32":
            values = np.frombuffer(raw, "<f4").astype(float)
            codes = np.where(np.isnan(values), np.frombuffer(raw, "<u4") & 31, 0)
        else:
            bits = np.frombuffer(raw, "<u2").astype(float)
            codes = np.where(bits >= 65504, bits - 65504, 0)
            values = output["lo"] + (output["hi"] - output["lo"]) * bits / 65503
            values = np.where(bits >= 65504, np.nan, values)
        arrays.append((values, codes))
    return data, arrays


@pytest.fixture(scope="module")
def slopes():
    return ls.sweep(["mean_velocity", "best_segments"], slope_deg=np.linspace(-5, 25, 16),
                    segments=range(2, 9), drive_limit=[0.5, 1.0, float("inf")],
                    **SURFACE)  # fmt: skip


class TestCells:
    def test_all_values_and_statuses_are_there(self, slopes):
        data, arrays = read(slopes.explore().html)
        assert [axis["name"] for axis in data["axes"]] == list(slopes.axes)
        for output, (values, codes) in zip(slopes.outputs, arrays, strict=True):
            assert np.allclose(values, slopes[output.name].ravel(), rtol=1e-7, equal_nan=True)
            assert (codes == slopes.status_of(output.name).ravel()).all()
        assert data["axes"][2]["values"] == ["0.5", "1.0", "Infinity"]
        assert "To keep this page small" not in slopes.explore().html

    def test_a_falling_axis_rises_on_the_page(self):
        r = ls.sweep("mean_velocity", slope_deg=[20.0, 0.0, 10.0], segments=[3, 4], **SURFACE)
        data, ((values, _),) = read(r.explore().html)
        assert data["axes"][0]["values"] == ["0.0", "10.0", "20.0"]
        assert np.allclose(values.reshape(3, 2), r.values[[1, 2, 0]], equal_nan=True)

    def test_more_cells_than_fit_are_rounded_then_left_out_and_it_says_so(self, slopes):
        size = len(slopes.explore().html)
        rounded = slopes.explore(limit=65_000).html
        assert len(rounded) < size
        assert "Values are stored in 16 bits, rounded to steps of" in rounded
        data, ((values, codes), _) = read(rounded)
        step = (data["outputs"][0]["hi"] - data["outputs"][0]["lo"]) / 65503
        assert np.nanmax(np.abs(values - slopes.values.ravel())) <= 0.51 * step
        assert (codes == slopes.status.ravel()).all()
        fewer = slopes.explore(limit=63_000).html
        assert len(fewer) < 63_000
        data, _ = read(fewer)
        shown = data["axes"][0]["values"]
        assert 2 <= len(shown) < 16
        assert (shown[0], shown[-1]) == ("-5.0", "25.0")
        assert f"{len(shown)} of 16 values of slope_deg" in fewer
        # The command computes all of them.
        assert data["axes"][0]["shell"] == "slope_deg=-5.0:25.0:16"

    def test_a_limit_that_holds_nothing_is_refused(self, slopes):
        with pytest.raises(InputError, match="do not fit into a page"):
            slopes.explore(limit=1000)

    def test_large_sweeps_are_thinned_along_the_longest_axes(self):
        axes = {"mu_static": np.linspace(0.1, 1, 200), "slope_deg": np.linspace(0, 25, 200),
                "mu_coulomb": np.linspace(0.05, 0.5, 20),
                "segments": np.arange(2.0, 22.0)}  # fmt: skip
        some, kind = chosen(axes, 1, LARGEST)
        lengths = [len(index) for index in some.values()]
        assert kind == "uint16"
        assert lengths[2:] == [20, 20]
        assert lengths[0] == lengths[1] > 80
        assert np.prod(lengths) * 2 * 4 / 3 < LARGEST

    @pytest.mark.parametrize("kind", ["float32", "uint16"])
    def test_one_value_and_none(self, kind):
        codes = np.array([0, 0, 5], np.uint8)
        one = packed(np.array([2.0, 2.0, np.nan]), codes, kind)
        assert (one.low, one.high) == (2.0, 2.0)
        none = packed(np.full(3, np.nan), np.array([3, 255, 1], np.uint8), kind)
        raw = base64.b64decode(none.text)
        found = np.frombuffer(raw, "<u4") & 31 if kind == "float32" else (
            np.frombuffer(raw, "<u2") - 65504)  # fmt: skip
        assert found.tolist() == [3, NOT_COMPUTED, 1]

    def test_statuses_of_the_core_leave_room(self):
        assert max(Status) < NOT_COMPUTED

    def test_nothing_left_out_is_nothing_said(self):
        axes = {"slope_deg": np.arange(3.0)}
        assert told(axes, axes, "float32", []) == []


class TestPage:
    def test_nothing_to_explore(self):
        with pytest.raises(InputError, match="no axis has more than one value"):
            ls.sweep("mean_velocity", segments=[3], **SURFACE).explore()
        with pytest.raises(InputError, match="no axis has more than one value"):
            ls.sweep("mean_velocity", segments=3, **SURFACE).explore()

    def test_asks_for_nothing_and_allows_its_own_script_only(self, slopes):
        html = slopes.explore().html
        policy = re.search(r'Content-Security-Policy" content="([^"]*)"', html)[1]
        script = re.search(r"<script>(.*?)</script>", html, re.S)[1]
        assert f"script-src 'sha256-{digest_of(script)}'" in policy
        assert policy.startswith("default-src 'none'")
        assert not re.search(r"https?://|url\(|@import|<link|src=", html)

    def test_says_what_is_fixed_and_why_cells_are_empty(self, slopes):
        html = slopes.explore().html
        assert "Fixed: mu_static 0.5, mu_coulomb 0.3, mass 0.271 kg" in html
        data, _ = read(html)
        assert data["statuses"]["1"] == Status.SLIDES_BACK.sentence
        folded = ls.sweep("mean_velocity", slope_deg=[0, 10, 80], segments=range(2, 9),
                          over="segments", reduce="max", **SURFACE)  # fmt: skip
        data, _ = read(folded.explore().html)
        code = str(int(Status.NONE_FEASIBLE))
        assert data["statuses"][code] == "no value of segments from 2 to 8 works"
        assert "segments from 2 to 8" in folded.explore().html

    def test_sliders_begin_at_the_highest_value(self, slopes):
        data, ((values, _), _) = read(slopes.explore().html)
        best = np.unravel_index(np.nanargmax(values), slopes.shape)
        assert data["start"] == [int(one) for one in best]

    def test_sliders_begin_where_they_are_asked_to(self, slopes):
        first, *_, last = slopes.axes
        data, _ = read(slopes.explore(**{first: slopes.axes[first][1] * 1.01}).html)
        best, _ = read(slopes.explore().html)
        assert data["start"] == [1, *best["start"][1:]]
        with pytest.raises(InputError, match="unknown axis 'mass'"):
            slopes.explore(mass=1.0)
        with pytest.raises(InputError, match=f"{last} is .* allowed is one number"):
            slopes.explore(**{last: [2, 3]})

    def test_a_notebook_shows_the_whole_page_in_a_frame(self, slopes):
        page = slopes.explore()
        assert page._repr_html_().startswith('<iframe srcdoc="&lt;!DOCTYPE html&gt;')
        assert "</script" not in page._repr_html_()
        assert repr(page).startswith("Explorer: a page of 0.")

    def test_names_that_are_code_stay_text(self, slopes):
        html = explorer(slopes, command="locosweep '<script>alert(1)</script>'").html
        assert "<script>alert" not in html
        assert "</script" not in json_block({"a": "</script><b>"})

    def test_saves_as_html_only(self, slopes, tmp_path):
        page = slopes.explore()
        page.save(tmp_path / "a.html")
        assert (tmp_path / "a.html").read_text(encoding="utf-8") == page.html
        with pytest.raises(InputError, match=r"a page cannot end in '\.png'"):
            page.save(tmp_path / "a.png")
        assert isinstance(page, Explorer)


class TestCommands:
    """What the page gives to copy computes what it shows."""

    @pytest.mark.parametrize(
        ("axis", "name"),
        [(np.linspace(0.1, 1.0, 37), "mu_static"), (np.arange(2.0, 9.0), "segments"),
         (np.array([2.0, 4.0, 8.0]), "segments"), (np.array([0.5, np.inf]), "drive_limit"),
         (np.array([0.1, 0.3, 0.7]), "mu_static"), (np.array([0.3]), "mu_static")],
    )  # fmt: skip
    def test_axes_read_back_to_the_same_values(self, axis, name):
        from locosweep.cli.options import AXIS

        found, values = AXIS.convert(shell_axis(name, axis), None, None)
        given = list(values) if isinstance(values, tuple) else values.values(name).tolist()
        assert (found, given) == (name, axis.tolist())
        assert np.array_equal(np.asarray(eval(python_axis(name, axis)), float), axis)  # noqa: S307

    @pytest.mark.parametrize("fold", [
        {}, {"over": "segments", "reduce": "argmax"},
        {"over": "segments", "reduce": "quantile", "q": 0.25},
    ])  # fmt: skip
    def test_both_run_and_give_the_same(self, fold, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        r = ls.sweep("mean_velocity", slope_deg=[0.0, 5.0, 10.0], mu_static=[0.4, 0.5, 0.7],
                     segments=range(2, 9), mu_coulomb=0.3, mass=0.4, **fold)  # fmt: skip
        r = r if fold else r.sel(segments=4)
        data, _ = read(r.explore().html)
        output, axes = data["outputs"][0], data["axes"]
        axis = {a["name"]: a for a in axes}
        y, x = axis["slope_deg"], axis["mu_static"]
        flags = output["flags"]
        line = f"{output['shell']} {flags[0]} {y['shell']} {flags[1]} {x['shell']} {output['tail']}"
        for part in line.split(" && "):
            assert main(shlex.split(part)[1:]) == 0
        assert (tmp_path / "map.png").stat().st_size > 1000
        call = [f"{a['name']}={a['python']}" for a in (y, x)] + output["more"]
        again = eval(f"{output['python']}{', '.join(call)})", {"ls": ls, "np": np})  # noqa: S307
        assert np.array_equal(again.values, r.values, equal_nan=True)

    def test_simulated_quantities_keep_law_and_drive(self):
        r = ls.sweep("final_position", drive_amplitude=[1.0, 2.0], mu_static=[0.4, 0.5],
                     mu_coulomb=0.3, law="stribeck", drive="sine")  # fmt: skip
        data, _ = read(r.explore().html)
        tail = data["outputs"][0]["tail"]
        assert "--law stribeck --drive sine" in tail
        assert 'law="stribeck"' in data["outputs"][0]["more"]


class TestCommand:
    """locosweep explore."""

    def test_a_sweep_is_computed_at_the_cells_of_the_page_only(self, tmp_path, monkeypatch, capsys):
        monkeypatch.chdir(tmp_path)
        assert main(["explore", "mean_velocity", "--axis", "mu_static=0.1:1:5000",
                     "--axis", "slope_deg=0:20:5000", "--axis", "segments=2:21",
                     "--set", "mu_coulomb=0.3", "--out", "a.html"]) == 0  # fmt: skip
        html = (tmp_path / "a.html").read_text()
        assert 7_000_000 < len(html) < LARGEST
        data, _ = read(html)
        assert len(data["axes"][0]["values"]) < 400
        assert "of 5000 values of mu_static" in html
        assert data["axes"][0]["shell"] == "mu_static=0.1:1.0:5000"
        assert capsys.readouterr().out == "a.html\n"

    def test_a_saved_result_and_a_run_folder_show_the_same(self, slopes, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        slopes.save("r.parquet")
        ls.sweep(["mean_velocity", "best_segments"], out="run", chunk=40,
                 slope_deg=np.linspace(-5, 25, 16), segments=range(2, 9),
                 drive_limit=[0.5, 1.0, float("inf")], **SURFACE)  # fmt: skip
        for source in ("r.parquet", "run"):
            assert main(["explore", source, "--out", "a.html"]) == 0
            (values, codes), _ = read((tmp_path / "a.html").read_text())[1]
            assert np.allclose(values, slopes.values.ravel(), rtol=1e-7, equal_nan=True)
            assert (codes == slopes.status.ravel()).all()

    def test_cells_that_are_missing_are_named(self, tmp_path, monkeypatch, capsys):
        monkeypatch.chdir(tmp_path)
        ls.sweep("mean_velocity", out="run", chunk=70, slope_deg=np.linspace(0, 20, 50),
                 segments=range(2, 9), **SURFACE)  # fmt: skip
        (log,) = (tmp_path / "run" / "log").iterdir()
        log.write_bytes(b"".join(log.read_bytes().splitlines(keepends=True)[:-1]))
        assert main(["explore", "run", "--out", "a.html"]) == 2
        assert "not computed" in capsys.readouterr().err
        assert not (tmp_path / "a.html").exists()
        assert main(["explore", "run", "--allow-missing", "--out", "a.html"]) == 0
        data, ((_, codes),) = read((tmp_path / "a.html").read_text())
        assert NOT_COMPUTED in codes
        assert data["statuses"][str(NOT_COMPUTED)] == "not computed yet"

    @pytest.mark.parametrize(
        ("given", "said"),
        [(["nosuch", "--out", "a.html"], "unknown quantity 'nosuch'"),
         (["nosuch.parquet", "--out", "a.html"], "nosuch.parquet: no such file"),
         (["nosuch/", "--out", "a.html"], "nosuch: no such folder"),
         (["nosuch/", "--set", "mass=1", "--out", "a.html"], "--set is given beside nosuch/"),
         (["a.parquet", "mean_velocity", "--out", "a.html"], "a.parquet is given beside"),
         (["mean_velocity", "--out", "a.pdf"], "ends in '.pdf': allowed are .html"),
         (["--out", "a.html"], "QUANTITY is missing"),
         (["mean_velocity", "--axis", "segments=2:4", "--set", "mu_static=0.5", "--set",
           "mu_coulomb=0.3", "--allow-missing", "--out", "a.html"], "--allow-missing is given"),
         (["mean_velocity", "--set", "mu_static=0.5", "--set", "mu_coulomb=0.3", "--set",
           "segments=3", "--out", "a.html"], "nothing to explore")],
    )  # fmt: skip
    def test_bad_input_is_one_line_and_no_file(self, given, said, tmp_path, monkeypatch, capsys):
        monkeypatch.chdir(tmp_path)
        assert main(["explore", *given]) == 2
        text = capsys.readouterr().err
        assert said in text
        assert text.count("\n") == 1
        assert not (tmp_path / "a.html").exists()
