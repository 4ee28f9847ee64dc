"""The command, as people run it: a process of its own."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import locosweep as ls
from locosweep import cli, registry

pytestmark = pytest.mark.whole

ROOT = Path(__file__).parent.parent
ROBOT = ROOT / "examples" / "locosnake.toml"
COMMAND = (sys.executable, "-c", "import sys; from locosweep.cli import main; sys.exit(main())")
FLAT = ("--set", "mu_static=0.5", "--set", "mu_coulomb=0.3")


def run(*arguments, cwd, **options):
    return subprocess.run(
        [*COMMAND, *map(str, arguments)],
        cwd=cwd, capture_output=True, text=True, timeout=60, check=False, **options,
    )  # fmt: skip


def ok(*arguments, cwd, **options):
    done = run(*arguments, cwd=cwd, **options)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return done.stdout


@pytest.mark.parametrize(
    "command",
    [[Path(sys.executable).with_name("locosweep")], [sys.executable, "-m", "locosweep"]],
    ids=["script", "module"],
)
def test_the_command_is_installed(command):
    done = subprocess.run([*command, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout == f"locosweep {ls.__version__}\n"
    wrong = [*command, "heatmap", "speed"]
    refused = subprocess.run(wrong, capture_output=True, text=True, check=False)
    assert refused.returncode == 2
    assert refused.stderr.startswith("locosweep: Invalid value for 'QUANTITY': unknown quantity")


def test_help_loads_neither_numpy_nor_matplotlib():
    code = (
        "import sys; from locosweep.cli import main; main(['--help']); "
        "sys.exit(any(m in sys.modules for m in ('numpy', 'matplotlib', 'polars', 'scipy')))"
    )
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)


def test_a_diagnosis_does_without_the_statistics_that_take_a_second_to_load():
    code = (
        "import sys, locosweep.diagnosis.pipeline; "
        "sys.exit(any(m in sys.modules for m in ('scipy.stats', 'matplotlib')))"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("arguments", [(), ("--help",), ("-h",), ("sweep", "--help")])
def test_help_is_an_answer(tmp_path, arguments):
    assert ok(*arguments, cwd=tmp_path).startswith("Usage: locosweep")


def test_help_of_a_sweep_says_which_commands_list_the_registry(tmp_path):
    text = ok("sweep", "--help", cwd=tmp_path)
    assert [name for name in registry.reductions() if name not in text] == []
    for command, records in (("quantities", registry.quantities()),
                             ("parameters", registry.parameters())):  # fmt: skip
        assert f"locosweep {command}" in text
        listed = ok(command, cwd=tmp_path)
        assert [record.name for record in records if record.name not in listed] == []


class TestLists:
    def test_quantities(self, tmp_path):
        lines = ok("quantities", cwd=tmp_path).splitlines()
        assert [line.split()[0] for line in lines[1:]] == [q.name for q in registry.quantities()]

    def test_quantities_as_json(self, tmp_path):
        records = json.loads(ok("quantities", "--json", cwd=tmp_path))
        assert [r["name"] for r in records] == [q.name for q in registry.quantities()]

    @pytest.mark.parametrize("json_", [(), ("--json",)])
    def test_one_quantity(self, tmp_path, json_):
        text = ok("quantities", "mean_velocity", *json_, cwd=tmp_path)
        record = registry.quantity("mean_velocity")
        words = json.loads(text) if json_ else {"text": " ".join(text.split())}
        if json_:
            assert words["formula"] == record.formula
            assert words["parameters"] == [p.name for p in record.parameters]
        else:
            for part in (record.meaning, record.source, record.unit, "drive_limit"):
                assert part in words["text"]

    @pytest.mark.parametrize("command", ["parameters", "reductions", "reasons"])
    def test_others(self, tmp_path, command):
        lines = ok(command, cwd=tmp_path).splitlines()
        records = json.loads(ok(command, "--json", cwd=tmp_path))
        assert len(lines) == len(records) + 1

    def test_one_parameter_without_a_limit_is_strict_json(self, tmp_path):
        record = json.loads(ok("parameters", "drive_limit", "--json", cwd=tmp_path))
        assert record["range"] == [0, None]


class TestSweep:
    def test_writes_what_the_library_computes(self, tmp_path):
        text = ok(
            "sweep", "mean_velocity", "peak_speed", "--axis", "slope_deg=0:20:5", "--axis",
            "segments=2:6", *FLAT, "--threads", 2, "--out", "r.parquet", cwd=tmp_path,
        )  # fmt: skip
        assert text == "r.parquet\n"
        grid = {"slope_deg": np.linspace(0, 20, 5), "segments": range(2, 7)}
        expected = ls.sweep(["mean_velocity", "peak_speed"], mu_static=0.5, mu_coulomb=0.3, **grid)
        read = ls.load(tmp_path / "r.parquet")
        assert list(read.axes) == ["slope_deg", "segments"]
        for name in ("mean_velocity", "peak_speed"):
            assert read[name].tobytes() == expected[name].tobytes()

    def test_robot_file_gives_defaults(self, tmp_path):
        ok("sweep", "mean_velocity", "--axis", "segments=3,5", "--set", "stroke=0.03", "--robot",
           ROBOT, "--out", "r.parquet", cwd=tmp_path)  # fmt: skip
        robot = ls.load_robot(ROBOT).parameters | {"stroke": 0.03, "segments": [3, 5]}
        read = ls.load(tmp_path / "r.parquet")
        assert read.values.tolist() == ls.sweep("mean_velocity", **robot).values.tolist()
        assert read.fixed["drive_limit"] == 0.85

    def test_spec_gives_the_same_sweep(self, tmp_path):
        arguments = ("sweep", "mean_velocity", "--axis", "mu_static=0.1,0.30000000000000004,1e0",
                     "--axis", "segments=2:64", "--set", "mu_coulomb=0.3", "--over", "segments",
                     "--reduce", "quantile", "--reduce", "argmax", "--q", "0.1")  # fmt: skip
        text = ok(*arguments, "--out", "a.parquet", "--save-spec", "s.toml", cwd=tmp_path)
        assert text.splitlines() == ["a.parquet", "s.toml"]
        ok("sweep", "--spec", "s.toml", "--out", "b.parquet", "--save-spec", "t.toml", cwd=tmp_path)
        assert (tmp_path / "s.toml").read_bytes() == (tmp_path / "t.toml").read_bytes()
        a, b = (ls.load(tmp_path / f"{n}.parquet") for n in "ab")
        assert a.axes["mu_static"].tolist() == [0.1, 0.30000000000000004, 1.0]
        for output in a.outputs:
            assert a[output.name].tobytes() == b[output.name].tobytes()

    def test_spec_takes_settings_and_a_robot(self, tmp_path):
        ok("sweep", "--spec", ROOT / "examples" / "sweep.toml", "--robot", ROBOT, "--set",
           "viscous=0.5", "--out", "r.parquet", cwd=tmp_path)  # fmt: skip
        fixed = ls.load(tmp_path / "r.parquet").fixed
        assert (fixed["viscous"], fixed["drive_limit"]) == (0.5, 0.85)

    def test_save_spec_alone_computes_nothing(self, tmp_path):
        ok("sweep", "mean_velocity", "--axis", "segments=2:9", *FLAT, "--save-spec", "s.toml",
           cwd=tmp_path)  # fmt: skip
        assert [p.name for p in tmp_path.iterdir()] == ["s.toml"]

    def test_json(self, tmp_path):
        text = ok("sweep", "mean_velocity", "--axis", "slope_deg=0:40:5", *FLAT, "--set",
                  "segments=4", "--out", "r.parquet", "--json", cwd=tmp_path)  # fmt: skip
        report = json.loads(text)
        (output,) = report["outputs"]
        assert report["file"] == "r.parquet"
        assert 0 < output["cells_with_value"] < output["cells"] == 5
        assert report["fixed"]["drive_limit"] is None

    def test_replaces_a_file(self, tmp_path):
        (tmp_path / "r.parquet").write_text("old")
        ok("sweep", "resistance", *FLAT, "--axis", "mass=1,2", "--out", "r.parquet", cwd=tmp_path)
        assert ls.load(tmp_path / "r.parquet").shape == (2,)


class TestOptimum:
    def test_table(self, tmp_path):
        lines = ok("optimum", *FLAT, cwd=tmp_path).splitlines()
        assert lines[0].split()[:3] == ["best", "segments", "3"]
        assert sum(line.split()[:1] == [str(n)] for n in range(2, 65) for line in lines) == 63

    def test_json_agrees_with_the_library(self, tmp_path):
        report = json.loads(
            ok("optimum", "--robot", ROBOT, "--set", "drive_limit=inf", "--set", "slope_deg=12",
               "--segments", "2:30", "--json", cwd=tmp_path)
        )  # fmt: skip
        robot = ls.load_robot(ROBOT).parameters
        robot |= {"drive_limit": np.inf, "slope_deg": 12, "segments": range(2, 31)}
        speeds = ls.sweep("mean_velocity", **robot).values
        rivals = report["rivals"]
        assert report["best"] == rivals[int(np.nanargmax(speeds))]["segments"]
        assert [r["velocity"] for r in rivals] == [None if np.isnan(v) else v for v in speeds]
        assert rivals[0]["status"] == "anchors_too_weak"
        assert rivals[0]["why"] == ls.Status.ANCHORS_TOO_WEAK.sentence
        assert report["facts"]["optimal_segments"]["value"] == pytest.approx(report["best"], abs=1)

    def test_ties(self, tmp_path):
        report = json.loads(
            ok(
                "optimum",
                "--set",
                "mu_static=0.5",
                "--set",
                "mu_coulomb=0.5",
                "--json",
                cwd=tmp_path,
            )
        )
        speeds = {r["segments"]: r["velocity"] for r in report["rivals"]}
        best = report["best"]
        expected = [
            n for n, v in speeds.items()
            if n != best and v is not None and abs(v / speeds[best] - 1) < 1e-12
        ]  # fmt: skip
        assert report["ties"] == expected

    def test_nothing_moves(self, tmp_path):
        arguments = ("optimum", *FLAT, "--set", "slope_deg=60")
        report = json.loads(ok(*arguments, "--json", cwd=tmp_path))
        assert report["best"] is None
        assert all(r["velocity"] is None for r in report["rivals"])
        assert "none" in ok(*arguments, cwd=tmp_path).splitlines()[0]


SMALL = ("--x", "slope_deg=0:25:20", "--y", "mu_static=0.1:1:20", "--set", "mu_coulomb=0.3")


class TestPictures:
    @pytest.mark.parametrize(
        ("kind", "start"), [("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")]
    )
    def test_heatmap(self, tmp_path, kind, start):
        text = ok("heatmap", "mean_velocity", *SMALL, "--set", "segments=4", "--out", f"m.{kind}",
                  cwd=tmp_path)  # fmt: skip
        assert text == f"m.{kind}\n"
        assert (tmp_path / f"m.{kind}").read_bytes().startswith(start)

    def test_heatmap_of_the_best(self, tmp_path):
        text = ok("heatmap", "mean_velocity", *SMALL, "--best-over", "segments=2:64", "--data",
                  "d.parquet", "--json", cwd=tmp_path)  # fmt: skip
        report = json.loads(text)
        assert (report["file"], report["data"]) == ("mean_velocity.png", "d.parquet")
        assert sorted(p.name for p in tmp_path.iterdir()) == ["d.parquet", "mean_velocity.png"]
        result = ls.load(tmp_path / "d.parquet")
        expected = ls.sweep(
            "mean_velocity", mu_static=np.linspace(0.1, 1, 20), slope_deg=np.linspace(0, 25, 20),
            segments=range(2, 65), mu_coulomb=0.3, over="segments", reduce=["argmax", "max"],
        )  # fmt: skip
        assert list(result.axes) == ["mu_static", "slope_deg"]
        for output in expected.outputs:
            assert result[output.name].tobytes() == expected[output.name].tobytes()

    def test_heatmap_of_the_least(self, tmp_path):
        text = ok("heatmap", "cost_of_transport", *SMALL, "--best-over", "segments=2:9", "--best",
                  "min", "--json", cwd=tmp_path)  # fmt: skip
        names = [output["name"] for output in json.loads(text)["outputs"]]
        assert names == ["cost_of_transport_argmin", "cost_of_transport_min"]

    def test_same_command_same_bytes(self, tmp_path):
        pictures = []
        for _ in range(2):
            ok("heatmap", "resistance", "--x", "slope_deg=0:9:5", "--y", "mu_coulomb=0:1:5",
               cwd=tmp_path)  # fmt: skip
            pictures.append((tmp_path / "resistance.png").read_bytes())
        assert pictures[0] == pictures[1]

    @pytest.mark.slow
    def test_plot(self, tmp_path):
        ls.sweep(
            "mean_velocity",
            mu_coulomb=0.3,
            mu_static=[0.4, 0.5],
            slope_deg=[0, 5, 10],
            segments=range(2, 9),
        ).save(tmp_path / "r.parquet")
        heat = ok("plot", "r.parquet", "--at", "mu_static=0.5", cwd=tmp_path)
        assert heat == "r.png\n"
        for name, more in {
            "named.svg": ("--x", "slope_deg", "--y", "segments", "--at", "mu_static=0.4"),
            "curves.png": ("--x", "segments", "--by", "slope_deg", "--at", "mu_static=0.4"),
        }.items():
            ok("plot", "r.parquet", *more, "--out", name, cwd=tmp_path)
            assert (tmp_path / name).stat().st_size > 1000

    def test_reproduce(self, tmp_path):
        files = ok("reproduce", "3", "--out", "paper", cwd=tmp_path).splitlines()
        assert "paper/figure3.png" in files
        assert all((tmp_path / file).stat().st_size > 100 for file in files)

    def test_reproduce_names_every_figure(self, tmp_path):
        from locosweep.paper.reproduce import _FIGURES

        named = "|".join([*map(str, _FIGURES), "all", "gap"])
        assert named in "".join(ok("reproduce", "--help", cwd=tmp_path).split())


BAD = {
    "no such command": ("sweeep",),
    "no such option": ("sweep", "--axes", "1"),
    "no such quantity": ("sweep", "mean_velocty", "--out", "r.parquet"),
    "no such quantity to list": ("quantities", "speeed"),
    "no such parameter to list": ("parameters", "slop"),
    "no quantity": ("sweep", "--out", "r.parquet"),
    "no out": ("sweep", "mean_velocity", *FLAT, "--axis", "segments=2:4"),
    "parameter missing": ("sweep", "mean_velocity", "--axis", "segments=2:4", "--out", "r.parquet"),
    "heatmap without y": ("heatmap", "mean_velocity", "--x", "slope_deg=0:1:3"),
    "same quantity twice": ("sweep", "resistance", "resistance", *FLAT, "--out", "r.parquet"),
    "wrong ending": ("sweep", "resistance", *FLAT, "--out", "r.csv"),
    "no ending": ("heatmap", "resistance", *SMALL, "--out", "picture"),
    "no such folder": ("heatmap", "resistance", *SMALL, "--out", "no/such/p.png"),
    "out is a folder": ("heatmap", "resistance", *SMALL, "--out", "folder.png"),
    "no threads": ("heatmap", "resistance", *SMALL, "--threads", "0"),
    "threads no number": ("heatmap", "resistance", *SMALL, "--threads", "many"),
    "best neither": ("heatmap", "resistance", *SMALL, "--best", "most"),
    "x is y": ("heatmap", "resistance", "--x", "mass=1:2:3", "--y", "mass=1:2:3", *FLAT),
    "reduce without over": ("sweep", "resistance", *FLAT, "--reduce", "max", "--out", "r.parquet"),
    "over without reduce": ("sweep", "resistance", *FLAT, "--axis", "mass=1,2", "--over", "mass",
                            "--out", "r.parquet"),
    "over no axis": ("sweep", "resistance", *FLAT, "--over", "mass", "--reduce", "max", "--out",
                     "r.parquet"),
    "no such reduction": ("sweep", "resistance", *FLAT, "--axis", "mass=1,2", "--over", "mass",
                          "--reduce", "maxx", "--out", "r.parquet"),
    "quantile without q": ("sweep", "resistance", *FLAT, "--axis", "mass=1,2", "--over", "mass",
                           "--reduce", "quantile", "--out", "r.parquet"),
    "q is nan": ("sweep", "resistance", *FLAT, "--axis", "mass=1,2", "--over", "mass", "--reduce",
                 "quantile", "--q", "nan", "--out", "r.parquet"),
    "no such type": ("sweep", "resistance", *FLAT, "--dtype", "float16", "--out", "r.parquet"),
    "set twice": ("sweep", "resistance", *FLAT, "--set", "mu_coulomb=0.1", "--out", "r.parquet"),
    "set and axis": ("sweep", "resistance", *FLAT, "--axis", "mu_coulomb=0,1", "--out",
                     "r.parquet"),
    "no such spec": ("sweep", "--spec", "none.toml", "--out", "r.parquet"),
    "spec and quantity": ("sweep", "resistance", "--spec", "bad.toml", "--out", "r.parquet"),
    "spec is no toml": ("sweep", "--spec", "bad.toml", "--out", "r.parquet"),
    "no such robot": ("optimum", "--robot", "none.toml"),
    "robot is no toml": ("optimum", "--robot", "bad.toml"),
    "optimum over one value": ("optimum", *FLAT, "--segments", "3"),
    "optimum from 0": ("optimum", *FLAT, "--segments", "0:5"),
    "optimum sets segments": ("optimum", *FLAT, "--set", "segments=3"),
    "plot of nothing": ("plot", "none.parquet"),
    "plot of no parquet": ("plot", "bad.toml"),
    "reproduce what": ("reproduce", "6", "--out", "paper"),
    "reproduce where": ("reproduce", "3"),
    "too large": ("sweep", "resistance", "--axis", "mu_coulomb=0:1:9000000", "--axis",
                  "mass=1:2:9000000", "--out", "r.parquet"),
}  # fmt: skip


def one_line(done, folder):
    lines = done.stderr.splitlines()
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    assert len(lines) == 1, done.stderr
    assert lines[0].startswith("locosweep: ")
    assert "Traceback" not in done.stderr
    assert sorted(p.name for p in folder.iterdir()) == ["bad.toml", "folder.png"]
    return lines[0]


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "bad.toml").write_text("[robot\nmass = 1")
    (tmp_path / "folder.png").mkdir()
    return tmp_path


@pytest.mark.parametrize("arguments", BAD.values(), ids=BAD)
def test_bad_input_is_one_line(folder, arguments):
    one_line(run(*arguments, cwd=folder), folder)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("sweep", "mean_velocty"), ["mean_velocty", "did you mean 'mean_velocity'"]),
        (("sweep", "resistance", "--set", "mu_colomb=1"), ["--set", "did you mean 'mu_coulomb'"]),
        (("sweep", "resistance", "--set", "mass"), ["--set", "mass", "NAME=VALUE"]),
        (("sweep", "resistance", "--set", "mass="), ["mass", "a number"]),
        (("sweep", "resistance", "--set", "mass=1_000"), ["mass", "1_000", "a number"]),
        (("sweep", "resistance", "--set", "mass=nan"), ["mass", "NaN", "a number from"]),
        (("sweep", "resistance", "--set", "mass=-1"), ["mass", "-1", "a number from"]),
        (("sweep", "resistance", "--set", "segments=2.5"), ["segments", "2.5", "whole number"]),
    ],
)
def test_bad_input_is_named(folder, arguments, words):
    line = one_line(run(*arguments, "--out", "r.parquet", cwd=folder), folder)
    assert [word for word in words if word not in line] == []


def _refused(text):
    import click

    from locosweep.cli.options import AXIS

    with pytest.raises(click.BadParameter) as caught:
        AXIS.convert(text, None, None)
    return caught.value.message


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("slope_deg", "LO:HI:COUNT"),
        ("slope_deg=", "LO:HI:COUNT"),
        ("=1:2:3", "LO:HI:COUNT|unknown"),
        ("slope_deg=0:25", "give a count"),
        ("slope_deg=0:25:", "count"),
        ("slope_deg=0::5", "number"),
        ("slope_deg=0:25:5:1", "LO:HI:COUNT"),
        ("slope_deg=0:25:-3", "count"),
        ("slope_deg=0:25:2.5", "count"),
        ("slope_deg=0:25:0", "values"),
        ("slope_deg=0:25:1", "differ"),
        ("slope_deg=0:25:nan", "count"),
        ("slope_deg=0:25:99999999999999999999", "count"),
        ("slope_deg=0:25:999999999999", "values"),
        ("slope_deg=nan:25:3", "NaN"),
        ("slope_deg=0:inf:3", "-90 to 90"),
        ("drive_limit=0:inf:3", "finite"),
        ("slope_deg=0:91:3", "-90 to 90"),
        ("slope_deg=1,,2", "number"),
        ("slope_deg=1,x", "number"),
        ("slope_deg=1;2", "number"),
        ("segments=64:2", "empty"),
        ("segments=2:64:10", "divisor"),
        ("segments=2.5:4", "whole"),
        ("segments=0:4", "from 1"),
        ("segments=1:1000000000", "values"),
        ("segments=2,2.5", "whole"),
        ("segmets=2:4", "did you mean 'segments'"),
        ("segments=٢:4", "number"),
        ("segments=2:4:³", "count"),
    ],
)
def test_bad_ranges(text, word):
    message = _refused(text)
    assert any(w in message for w in word.split("|")), message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("segments=2:5", [2, 3, 4, 5]),
        ("segments=2:10:3", [2, 6, 10]),
        ("segments=4:4", [4]),
        ("segments=5:2:4", [5, 4, 3, 2]),
        ("slope_deg=0:1:3", [0, 0.5, 1]),
        ("slope_deg=1:1:1", [1]),
        ("slope_deg=1:-1:3", [1, 0, -1]),
        ("mass=1e-3,2", [1e-3, 2]),
        ("mass= 1 ,2", [1, 2]),
    ],
)
def test_good_ranges(text, values):
    from locosweep.cli.options import AXIS

    name, given = AXIS.convert(text, None, None)
    found = given if isinstance(given, tuple) else given.values(name).tolist()
    assert list(found) == values


def test_altered_result_is_refused(folder):
    import polars as pl

    file = folder.parent / f"{folder.name}-altered.parquet"
    ls.sweep("resistance", mu_coulomb=[0.1, 0.2]).save(file)
    metadata = pl.read_parquet_metadata(file)
    frame = pl.read_parquet(file).with_columns(pl.col("resistance") * 2)
    frame.write_parquet(file, metadata={"locosweep": metadata["locosweep"]})
    assert "altered" in one_line(run("plot", file, cwd=folder), folder)


def _python(code, *, cwd, **environment):
    return subprocess.run(
        [sys.executable, "-c", code], cwd=cwd, capture_output=True, text=True, check=False,
        env=os.environ | environment, timeout=60,
    )  # fmt: skip


FAULT = (
    "import sys, locosweep.registry as r\n"
    "def broken(): raise RuntimeError('two\\nlines')\n"
    "from locosweep.cli import main\n"
    "r.reductions = broken\n"
    "sys.exit(main(['reductions']))"
)


def test_internal_error_is_one_line(tmp_path):
    done = _python(FAULT, cwd=tmp_path)
    assert done.returncode == 1
    assert len(done.stderr.splitlines()) == 1
    assert "please report" in done.stderr
    assert "two lines" in done.stderr


def test_internal_error_has_a_traceback_on_request(tmp_path):
    done = _python(FAULT, cwd=tmp_path, LOCOSWEEP_DEBUG="1")
    assert done.returncode == 1
    assert "Traceback" in done.stderr


def test_closed_pipe_is_no_error():
    read, write = os.pipe()
    os.close(read)
    done = subprocess.run(
        [*COMMAND, "quantities"], stdout=write, stderr=subprocess.PIPE, timeout=30, check=False
    )
    os.close(write)
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full here")
def test_full_disk_is_one_line():
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [*COMMAND, "quantities"], stdout=full, stderr=subprocess.PIPE, timeout=30, check=False
        )
    assert done.returncode == 2
    assert done.stderr.startswith(b"locosweep: cannot write the output")
    assert done.stderr.count(b"\n") == 1


@pytest.mark.usefixtures("ctrl_c")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_signals_end_a_long_sweep_quickly(tmp_path, number, code):
    # A small result: what lasts is the sweep, not getting memory.
    arguments = [
        "sweep", "mean_velocity", "--axis", "mu_static=0.31:1:400", "--axis", "slope_deg=0:20:400",
        "--axis", "viscous=0.1:2:40", "--axis", "segments=2:4001", "--over", "segments",
        "--reduce", "mean", "--set", "mu_coulomb=0.3", "--dtype", "float32", "--out", "r.parquet",
    ]  # fmt: skip
    process = subprocess.Popen(
        [*COMMAND, *arguments, "--threads", "1"],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    try:
        time.sleep(1.5)
        assert process.poll() is None, process.communicate()
        begin = time.perf_counter()
        process.send_signal(number)
        out, err = process.communicate(timeout=20)
        assert time.perf_counter() - begin <= 1.0
    finally:
        process.kill()
        process.communicate()
    assert process.returncode == code
    assert out == ""
    assert err == ("locosweep: interrupted\n" if code == 130 else "")
    assert list(tmp_path.iterdir()) == []


def test_progress_only_on_a_terminal(tmp_path):
    pty = pytest.importorskip("pty")
    main, other = pty.openpty()
    done = subprocess.run(
        [*COMMAND, "sweep", "resistance", "--axis", "mu_coulomb=0:1:1000", "--out", "r.parquet"],
        cwd=tmp_path, stdout=subprocess.PIPE, stderr=other, timeout=30, check=True, text=True,
    )  # fmt: skip
    os.close(other)
    shown = os.read(main, 10_000).decode()
    os.close(main)
    assert done.stdout == "r.parquet\n"
    assert "evaluations/s" in shown


@pytest.mark.usefixtures("ctrl_c")
def test_an_error_that_ctrl_c_caused_is_an_interrupt(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Imports that are cut turn it into errors of their own."""

    def cut(*_: object) -> None:
        try:
            signal.raise_signal(signal.SIGINT)
        except KeyboardInterrupt:
            raise RuntimeError("cut") from None

    monkeypatch.setattr(cli.group, "invoke", cut)
    assert cli.main(["laws"]) == 130
    assert capsys.readouterr().err == "locosweep: interrupted\n"
    monkeypatch.setattr(cli.group, "invoke", lambda *_: 1 / 0)
    assert cli.main(["laws"]) == 1
    assert "internal error" in capsys.readouterr().err
