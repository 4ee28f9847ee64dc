"""Robot files, sweep files and results: read back exactly, or refused by name."""

import json
import math
import stat
import sys

import numpy as np
import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

import locosweep as ls
from locosweep import registry
from locosweep.files.atomic import replacing
from locosweep.specs.sweep import Span, Spec

GRID = {
    "mu_static": [0.3, 0.5],
    "mu_coulomb": 0.3,
    "segments": range(2, 6),
    "slope_deg": [0, 12, 40],
}


class TestReplacing:
    def test_replaces_in_one_step(self, tmp_path):
        file = tmp_path / "a.txt"
        file.write_text("old")
        with replacing(file) as temporary:
            temporary.write_text("new")
            assert file.read_text() == "old"
        assert file.read_text() == "new"
        assert list(tmp_path.iterdir()) == [file]

    def test_rights_are_those_of_a_new_file(self, tmp_path):
        (tmp_path / "plain").write_text("")
        with replacing(tmp_path / "b.txt") as temporary:
            temporary.write_text("")
        modes = {stat.S_IMODE((tmp_path / n).stat().st_mode) for n in ("plain", "b.txt")}
        assert len(modes) == 1

    @pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
    def test_nothing_is_left_behind(self, tmp_path, error):
        file = tmp_path / "a.txt"
        file.write_text("old")

        def fail():
            with replacing(file) as temporary:
                temporary.write_text("half")
                raise error

        with pytest.raises(error):
            fail()
        assert file.read_text() == "old"
        assert list(tmp_path.iterdir()) == [file]

    def test_places_that_cannot_be(self, tmp_path):
        for place in (tmp_path, tmp_path / "no" / "a.txt", f"{tmp_path}/a\0b"):
            with pytest.raises(ls.InputError), replacing(place):
                pass
        assert list(tmp_path.iterdir()) == []


class TestRobot:
    def read(self, folder, text):
        file = folder / "robot.toml"
        if isinstance(text, bytes):
            file.write_bytes(text)
        else:
            file.write_text(text, encoding="utf-8")
        return ls.load_robot(file)

    def test_example(self):
        robot = ls.load_robot("examples/locosnake.toml")
        assert robot.parameters["drive_limit"] == 0.85
        assert robot.parameters["winding_resistance"] == 20.0

    def test_byte_order_mark_and_infinity(self, tmp_path):
        robot = self.read(tmp_path, b"\xef\xbb\xbf[drive]\nlimit = inf\n")
        assert robot.parameters == {"drive_limit": math.inf}

    def test_empty(self, tmp_path):
        assert self.read(tmp_path, "").parameters == {}

    @pytest.mark.parametrize(
        ("text", "words"),
        [
            ("[robto]\nmass = 1", ["table 'robto'", "did you mean 'robot'"]),
            ("[robot]\nmas = 1", ["[robot]", "'mas'", "did you mean 'mass'"]),
            ("[surface]\nmu_colomb = 1", ["'mu_colomb'", "did you mean 'mu_coulomb'"]),
            ("[robot]\nmass = '1'", ["[robot] mass", "'1'", "a number"]),
            ("[robot]\nmass = true", ["[robot] mass", "True", "a number"]),
            ("[robot]\nmass = [1]", ["[robot] mass", "a number"]),
            (f"[robot]\nmass = 1{'0' * 5000}", ["robot.toml: not TOML", "4300 digits"]),
            (f"[robot]\nmass = 1{'0' * 400}", ["[robot] mass is too large"]),
            ("[robot]\nmass = nan", ["[robot]", "mass", "NaN"]),
            ("[robot]\nmass = -1.0", ["[robot]", "mass", "-1", "a number from"]),
            ("[robot]\nsegments = 2.5", ["[robot]", "segments", "2.5", "whole number"]),
            ("[bench]\nkind = 'square'", ["[bench] kind", "square", "linear, rotary"]),
            ("[bench]\nkind = 1", ["[bench] kind", "linear, rotary"]),
            ("[surface]\nmu_coulomb = 0.3\ncoulomb_force = 1.0", ["mu_coulomb", "coulomb_force"]),
            ("robot = 1", ["robot", "[robot]"]),
            ("[effects.slope_error]", ["[effects.slope_error]", "no d_alpha_deg"]),
            ("[effects.coulomb_error]", ["[effects.coulomb_error]", "no d_mu"]),
            (
                "[effects.transmission_backlash]\nb = 0.001\nm_d = 0.1\n"
                "[effects.transmission_compliance]\nk = 1e3\nd = 1.0\nm_d = 0.1",
                ["transmission_backlash", "transmission_compliance", "the same place: give one"],
            ),
            ("[robot\nmass = 1", ["not TOML"]),
            ("[robot]\nmass = 1\nmass = 2", ["not TOML"]),
            (b"\xff\xfe\x00", ["not TOML"]),
            (b"[robot]\nmass = \x00", ["not TOML"]),
            ("a=" + "[" * 100_000, ["not TOML"]),
        ],
        ids=lambda v: str(v)[:24],
    )
    def test_refused(self, tmp_path, text, words):
        with pytest.raises(ls.DataFileError) as caught:
            self.read(tmp_path, text)
        message = str(caught.value)
        assert [word for word in ["robot.toml", *words] if word not in message] == []

    def test_large_integers(self, tmp_path):
        with pytest.raises(ls.DataFileError, match="mass"):
            self.read(tmp_path, f"[robot]\nmass = {'9' * 400}")

    def test_missing_or_folder(self, tmp_path):
        for place in (tmp_path / "none.toml", tmp_path):
            with pytest.raises(ls.DataFileError, match=r"none\.toml|directory"):
                ls.load_robot(place)


@st.composite
def values_of(draw, record):
    low, high = record.range
    if record.integer:
        return float(draw(st.integers(int(low), int(min(high, 2**53)))))
    sizes = st.floats(low, high, allow_nan=False)
    return draw(sizes.filter(lambda v: v == 0 or math.isinf(v) or 1e-30 <= abs(v) <= 1e30))


@st.composite
def axes_of(draw, record):
    if draw(st.booleans()):
        return tuple(draw(st.lists(values_of(record), min_size=1, max_size=4)))
    low, high = record.range
    high = min(high, 1e6)
    if record.integer:
        first = draw(st.integers(int(low), int(high)))
        last = draw(st.integers(first, min(first + 50, int(high))))
        return Span(float(first), float(last))
    ends = st.floats(low, high, allow_nan=False).map(lambda v: min(high, max(low, round(v, 6))))
    return Span(draw(ends), draw(ends), draw(st.integers(2, 9)))


@st.composite
def specs(draw):
    names = draw(
        st.lists(st.sampled_from(registry.quantities()), min_size=1, max_size=3, unique=True)
    )
    records = draw(st.lists(st.sampled_from(registry.parameters()), max_size=8, unique=True))
    cut = draw(st.integers(0, len(records)))
    axes = tuple((r.name, draw(axes_of(r))) for r in records[:cut])
    fixed = tuple((r.name, draw(values_of(r))) for r in records[cut:])
    over, reduce = None, ()
    if axes and draw(st.booleans()):
        over = draw(st.sampled_from([name for name, _ in axes]))
        known = sorted(registry.reductions())
        reduce = tuple(draw(st.lists(st.sampled_from(known), min_size=1, max_size=3, unique=True)))
    q = draw(st.floats(0, 1)) if "quantile" in reduce else None
    dtype = draw(st.sampled_from(["float64", "float32"]))
    return Spec(tuple(q_.name for q_ in names), axes, fixed, over, reduce, q, dtype)


class TestSpec:
    @given(specs())
    def test_round_trip(self, spec):
        text = spec.to_toml()
        read = Spec.from_toml(text)
        assert read == spec
        # Equality does not tell -0.0 from 0.0, the text does.
        assert read.to_toml() == text

    def test_through_a_file(self, tmp_path):
        spec = Spec.load("examples/sweep.toml")
        spec.save(tmp_path / "s.toml")
        assert Spec.load(tmp_path / "s.toml") == spec
        assert spec.run().shape == (51, 4)

    def test_runs_as_a_sweep_does(self):
        spec = Spec(
            ("mean_velocity",), (("slope_deg", Span(0.0, 20.0, 7)), ("segments", Span(2, 9))),
            (("mu_static", 0.5), ("mu_coulomb", 0.3)), "segments", ("max",),
        )  # fmt: skip
        expected = ls.sweep(
            "mean_velocity", slope_deg=np.linspace(0, 20, 7), segments=range(2, 10), mu_static=0.5,
            mu_coulomb=0.3, over="segments", reduce="max",
        )  # fmt: skip
        assert spec.run(threads=1).values.tobytes() == expected.values.tobytes()

    @pytest.mark.parametrize(
        ("text", "words"),
        [
            ("", ["quantities is missing"]),
            ("quantities = []", ["quantities is empty"]),
            ("quantities = 3", ["quantities", "3", "list"]),
            ("quantities = [3]", ["quantities[0]", "3"]),
            ("quantities = ['mean_velocty']", ["did you mean 'mean_velocity'"]),
            ("quantites = ['mass']", ["key 'quantites'", "did you mean 'quantities'"]),
            ("quantities = ['resistance', 'resistance']", ["quantities", "twice"]),
            ("format = 'locosweep.sweep/9'\nquantities = ['preload']", ["format", "sweep/9"]),
            ("quantities = ['preload']\ndtype = 'float16'", ["dtype", "float16", "float32"]),
            ("quantities = ['preload']\ndtype = 64", ["dtype", "64"]),
            ("quantities = ['preload']\nover = 1", ["over", "1"]),
            ("quantities = ['preload']\nover = 'mass'", ["over and reduce"]),
            ("quantities = ['preload']\nreduce = ['maxx']", ["'maxx'", "did you mean 'max'"]),
            ("quantities = ['preload']\nover = 'mass'\nreduce = ['max']", ["axis 'mass'"]),
            ("quantities = ['preload']\nq = 0.5", ["q is 0.5"]),
            ("quantities = ['preload']\nq = true", ["q is True"]),
            ("quantities = ['preload']\naxes = 3", ["axes is not a table"]),
            ("quantities = ['preload']\n[axes]\nmas = [1]", ["did you mean 'mass'"]),
            ("quantities = ['preload']\n[axes]\nmass = 1", ["[axes] mass", "list"]),
            ("quantities = ['preload']\n[axes]\nmass = []", ["axis mass is empty"]),
            ("quantities = ['preload']\n[axes]\nmass = [1, 'a']", ["[axes] mass[1]", "'a'"]),
            ("quantities = ['preload']\n[axes]\nmass = {from=1, to=2}", ["mass", "count"]),
            ("quantities = ['preload']\n[axes]\nmass = {form=1, to=2}", ["did you mean 'from'"]),
            ("quantities = ['preload']\n[axes]\nmass = {from=1, count=2}", ["mass", "'to'"]),
            (
                "quantities = ['preload']\n[axes]\nmass = {from=1, to=2, count=2.5}",
                ["count is 2.5"],
            ),
            ("quantities = ['preload']\n[axes]\nmass = {from=1, to=nan, count=2}", ["mass", "NaN"]),
            (
                "quantities = ['preload']\n[axes]\nmass = {from=1, to=2, count=0}",
                ["mass", "0 values"],
            ),
            ("quantities = ['preload']\n[fixed]\nmass = 'a'", ["[fixed] mass", "'a'"]),
            ("quantities = ['preload']\n[fixed]\nmass = -1", ["mass is -1"]),
            (f"quantities = ['preload']\n[fixed]\nmass = {'9' * 400}", ["[fixed] mass", "large"]),
            (
                "quantities = ['preload']\n[axes]\nmass=[1]\n[fixed]\nmass=1",
                ["mass is given twice"],
            ),
            ("quantities = ['preload'", ["not TOML"]),
        ],
        ids=lambda v: str(v)[-30:],
    )
    def test_refused(self, text, words):
        with pytest.raises(ls.DataFileError) as caught:
            Spec.from_toml(text, source="s.toml")
        message = str(caught.value)
        assert [word for word in ["s.toml: ", *words] if word not in message] == []

    def test_files_that_are_none(self, tmp_path):
        (tmp_path / "latin.toml").write_bytes(b"quantities = ['\xe4']")
        for name in ("none.toml", "latin.toml", "."):
            with pytest.raises(ls.DataFileError):
                Spec.load(tmp_path / name)


class TestResult:
    @pytest.mark.parametrize("dtype", ["float64", "float32"])
    @pytest.mark.parametrize("names", ["mean_velocity", ["mean_velocity", "best_segments"]])
    @pytest.mark.parametrize("reduce", [None, "argmax", ["max", "count"]])
    def test_round_trip(self, tmp_path, dtype, names, reduce):
        over = None if reduce is None else "segments"
        result = ls.sweep(names, over=over, reduce=reduce, dtype=dtype, **GRID)
        result.save(tmp_path / "r.parquet")
        read = ls.load(tmp_path / "r.parquet")
        assert read.outputs == result.outputs
        assert (read.fixed, read.over) == (result.fixed, result.over)
        assert list(read.axes) == list(result.axes)
        for name, axis in result.axes.items():
            assert read.axes[name].tobytes() == axis.tobytes()
        for output in result.outputs:
            assert read[output.name].dtype == result[output.name].dtype
            assert read[output.name].tobytes() == result[output.name].tobytes()
            assert (read.status_of(output.name) == result.status_of(output.name)).all()

    def test_without_axes(self, tmp_path):
        result = ls.sweep("resistance", mu_coulomb=0.3, drive_limit=math.inf)
        result.save(tmp_path / "r.parquet")
        read = ls.load(tmp_path / "r.parquet")
        assert (read.shape, read.values) == ((), result.values)
        assert read.fixed["drive_limit"] == math.inf

    def test_table(self):
        result = ls.sweep("mean_velocity", **GRID)
        frame = result.to_polars()
        assert frame.columns == ["mu_static", "segments", "slope_deg", "mean_velocity", "status"]
        assert frame.height == result.values.size
        row = frame.row(1 * 4 * 3 + 2 * 3 + 1, named=True)
        assert (row["mu_static"], row["segments"], row["slope_deg"]) == (0.5, 4.0, 12.0)
        assert row["mean_velocity"] == result.values[1, 2, 1]
        assert row["status"] == ls.Status(result.status[1, 2, 1]).name.lower()

    def test_xarray(self):
        pytest.importorskip("xarray")
        data = ls.sweep("mean_velocity", **GRID).to_xarray()
        assert data["mean_velocity"].dims == ("mu_static", "segments", "slope_deg")
        assert data["mean_velocity"].attrs["units"] == "m/s"
        assert data["slope_deg"].attrs["units"] == "deg"
        assert data.attrs["mu_coulomb"] == 0.3

    def test_xarray_missing(self, monkeypatch):
        monkeypatch.setitem(sys.modules, "xarray", None)
        with pytest.raises(ls.InputError, match=r"pip install '\.\[xarray\]'"):
            ls.sweep("resistance", mu_coulomb=0.3).to_xarray()

    def save(self, folder):
        file = folder / "r.parquet"
        ls.sweep("mean_velocity", **GRID).save(file)
        return file, json.loads(pl.read_parquet_metadata(file)["locosweep"]), pl.read_parquet(file)

    @pytest.mark.parametrize(
        "odd", [{"rivals": 5}, {"rivals": ["x"]}, {"q": [1]}, {"how": [1]}, {"outputs": []},
                {"over": {}}, {"outputs": [["resistance"]]}]
    )  # fmt: skip
    def test_odd_headers_are_refused(self, tmp_path, odd):
        file, header, frame = self.save(tmp_path)
        frame.write_parquet(file, metadata={"locosweep": json.dumps({**header, **odd})})
        with pytest.raises(ls.DataFileError, match=r"not a result of locosweep|altered or damaged"):
            ls.load(file)

    def refused(self, file, words):
        with pytest.raises(ls.DataFileError) as caught:
            ls.load(file)
        message = str(caught.value)
        assert [word for word in ["r.parquet", *words] if word not in message] == []
        assert "\n" not in message

    def test_altered_value(self, tmp_path):
        file, header, frame = self.save(tmp_path)
        frame = frame.with_columns(pl.col("mean_velocity") * (1 + 1e-15))
        frame.write_parquet(file, metadata={"locosweep": json.dumps(header)})
        self.refused(file, ["altered"])

    @pytest.mark.parametrize(
        "change",
        [
            {"axes": {}}, {"axes": None}, {"axes": {"segments": ["x"]}}, {"axes": {"nope": ["1"]}},
            {"fixed": None}, {"fixed": {"mass": "x"}}, {"fixed": {"mass": "2.0"}},
            {"axes": {"mu_static": ["0.3", "0.6"], "segments": ["2", "3", "4", "5"],
                      "slope_deg": ["0", "12", "40"]}}, {"outputs": []}, {"outputs": None},
            {"outputs": [["nope", None, "float64"]]}, {"outputs": [["mean_velocity"]]},
            {"outputs": [["mean_velocity", None, "int8"]]}, {"over": 3}, {"sha256": None},
            {"sha256": "0" * 64}, {"format": "locosweep.result/2"}, {"format": None},
        ],
        ids=str,
    )  # fmt: skip
    def test_altered_header(self, tmp_path, change):
        file, header, frame = self.save(tmp_path)
        frame.write_parquet(file, metadata={"locosweep": json.dumps(header | change)})
        self.refused(file, [])

    @pytest.mark.parametrize("key", ["axes", "fixed", "outputs", "over", "sha256", "format"])
    def test_header_without(self, tmp_path, key):
        file, header, frame = self.save(tmp_path)
        del header[key]
        frame.write_parquet(file, metadata={"locosweep": json.dumps(header)})
        self.refused(file, [])

    @pytest.mark.parametrize("text", ["", "{", "3", "[]", "{}", "[" * 100_000, "null"])
    def test_header_that_is_none(self, tmp_path, text):
        file, _, frame = self.save(tmp_path)
        frame.write_parquet(file, metadata={"locosweep": text})
        self.refused(file, ["not a result"])

    def test_columns_missing(self, tmp_path):
        file, header, frame = self.save(tmp_path)
        for columns in (["mean_velocity"], ["status"], []):
            frame.select(columns).write_parquet(file, metadata={"locosweep": json.dumps(header)})
            self.refused(file, [])

    def test_rows_missing(self, tmp_path):
        file, header, frame = self.save(tmp_path)
        frame.head(3).write_parquet(file, metadata={"locosweep": json.dumps(header)})
        self.refused(file, ["3 rows"])

    def test_foreign_parquet(self, tmp_path):
        file = tmp_path / "r.parquet"
        pl.DataFrame({"a": [1]}).write_parquet(file)
        self.refused(file, ["not a result of locosweep"])

    @pytest.mark.parametrize("content", [b"", b"PAR1", b"PAR1" * 9, b"a,b\n1,2\n", bytes(4096)])
    def test_no_parquet(self, tmp_path, content):
        file = tmp_path / "r.parquet"
        file.write_bytes(content)
        self.refused(file, ["not a readable Parquet file"])

    @pytest.mark.parametrize("share", [0.1, 0.5, 0.9, 0.99])
    def test_cut_off(self, tmp_path, share):
        file, _, _ = self.save(tmp_path)
        content = file.read_bytes()
        file.write_bytes(content[: int(share * len(content))])
        self.refused(file, ["not a readable Parquet file"])

    def test_missing(self, tmp_path):
        with pytest.raises(ls.DataFileError, match="no such file"):
            ls.load(tmp_path / "none.parquet")

    def test_saved_in_no_folder(self, tmp_path):
        with pytest.raises(ls.InputError, match="does not exist"):
            ls.sweep("resistance", mu_coulomb=0.3).save(tmp_path / "no" / "r.parquet")
