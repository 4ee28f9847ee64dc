"""Commands that simulate, and that list, explain and draw friction laws."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import locosweep as ls
from locosweep import registry
from locosweep.cli import main
from locosweep.cli.law_pages import markdown
from locosweep.specs.simulation import Simulation, read_drive
from locosweep.specs.sweep import Span, Spec

pytestmark = pytest.mark.whole

ROOT = Path(__file__).parent.parent
MU = ("--set", "mu_static=0.4", "--set", "mu_coulomb=0.3")
SINE = ("--drive", "sine", "--set", "drive_amplitude=2", "--set", "duration=0.5")


@pytest.fixture
def call(tmp_path, monkeypatch, capsys):
    """Run the command here: code, standard output, standard error."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        code = main([str(part) for part in arguments])
        done = capsys.readouterr()
        return code, done.out, done.err

    return run


@pytest.fixture
def ok(call):
    def run(*arguments):
        code, out, err = call(*arguments)
        assert (code, err) == (0, "")
        return out

    return run


@pytest.fixture
def refused(call, tmp_path):
    """Run what must fail: its one line; nothing may have been written."""

    def run(*arguments):
        before = sorted(tmp_path.rglob("*"))
        code, out, err = call(*arguments)
        assert (code, out) == (2, ""), err
        assert err.startswith("locosweep: ")
        assert err.count("\n") == 1
        assert sorted(tmp_path.rglob("*")) == before
        return err

    return run


def samples(folder, text, name="drive.csv"):
    file = folder / name
    file.write_text(text)
    return file


class TestLists:
    def test_laws(self, ok):
        lines = ok("laws").split("\n\n")[0].splitlines()
        assert [line.split()[0] for line in lines[1:]] == [law.name for law in ls.laws()]
        assert all(law.kind in line for law, line in zip(ls.laws(), lines[1:], strict=True))

    def test_laws_as_json(self, ok):
        records = json.loads(ok("laws", "--json"))
        assert [r["name"] for r in records] == [law.name for law in ls.laws()]
        assert {*records[0]} >= {
            "kind", "formula", "parameters", "source", "limits", "meaning", "exact"
        }  # fmt: skip

    @pytest.mark.parametrize("name", [law.name for law in ls.laws()])
    def test_one_law(self, ok, name):
        law = registry.law(name)
        words = " ".join(ok("laws", name).split())
        for text in (law.meaning, law.source, law.limits, law.kind):
            assert " ".join(text.split()) in words
        for p in law.parameters:
            assert p.name in words

    def test_one_law_as_json(self, ok):
        record = json.loads(ok("laws", "lugre", "--json"))
        damping = next(p for p in record["parameters"] if p["name"] == "damping_speed")
        assert (damping["unit"], damping["default"]) == ("m/s", None)

    def test_drives(self, ok):
        lines = ok("drives").splitlines()[1:]
        assert [line.split()[0] for line in lines] == [drive.name for drive in ls.drives()]
        record = json.loads(ok("drives", "ramp", "--json"))
        assert record["formula"] == registry.drive("ramp").formula
        assert "drive_rate" in ok("drives", "ramp")

    def test_methods(self, ok):
        assert json.loads(ok("methods", "--json")) == ls.methods()
        assert len(ok("methods").splitlines()) == len(ls.methods()) + 1

    def test_simulated_quantities_say_so(self, ok):
        assert json.loads(ok("quantities", "final_position", "--json"))["simulated"]
        assert "friction law" in ok("quantities", "final_position")

    def test_help_lists_laws_drives_and_methods(self, ok):
        words = ok("simulate", "--help").replace(",", " ").split()
        names = [r.name for r in (*ls.laws(), *ls.drives())]
        assert [n for n in (*names, *ls.methods()) if n not in words] == []


class TestLawPictures:
    def test_documentation_is_what_the_command_writes(self):
        written = (ROOT / "docs" / "laws.md").read_text(encoding="utf-8")
        assert written == markdown(ls.laws()), "run: locosweep laws --out DIR"

    def test_rows_of_its_tables_have_the_columns_of_their_heads(self):
        wide = None
        for line in markdown(ls.laws()).splitlines():
            cells = line.count("|") if line.startswith("|") else None
            assert wide is None or cells in (None, wide), line
            wide = cells

    def test_one_law(self, ok, tmp_path):
        assert ok("laws", "dahl", "--out", "new/pictures") == "new/pictures/dahl.png\n"
        data = (tmp_path / "new/pictures/dahl.png").read_bytes()
        assert data.startswith(b"\x89PNG")
        assert b"locosweep laws dahl --out new/pictures" in data

    def test_all_laws(self, ok, tmp_path, monkeypatch):
        # Three stand for all: one of each kind.
        some = [registry.law(name) for name in ("stribeck", "tanh", "lugre")]
        monkeypatch.setattr(registry, "laws", lambda: some)
        files = ok("laws", "--out", "d").splitlines()
        names = ["laws.png", "laws.md", "stribeck.png", "tanh.png", "lugre.png"]
        assert files == [f"d/{name}" for name in names]
        assert sorted(p.name for p in (tmp_path / "d").iterdir()) == sorted(names)
        assert (tmp_path / "d/laws.md").read_text() == markdown(some)

    def test_the_folder_is_a_file(self, refused, tmp_path):
        samples(tmp_path, "", "d")
        assert "d" in refused("laws", "--out", "d")

    def test_the_folder_cannot_be_made(self, refused, tmp_path):
        samples(tmp_path, "", "file")
        assert "cannot make this folder" in refused("laws", "dahl", "--out", "file/d")

    def test_values_without_pictures(self, refused):
        assert "--out" in refused("laws", "--set", "mu_coulomb=0.2")


class TestSimulate:
    def test_csv_holds_what_the_library_simulates(self, ok, tmp_path):
        text = ok("simulate", "--law", "stribeck", *SINE, *MU, "--samples", 101, "--out", "a.csv")
        assert text == "a.csv\n"
        run = ls.simulate(law="stribeck", drive="sine", drive_amplitude=2, duration=0.5,
                          mu_static=0.4, mu_coulomb=0.3, samples=101)  # fmt: skip
        frame = pl.read_csv(tmp_path / "a.csv")
        assert frame.columns == ["t", "x", "v", "force", "way"]
        for name in frame.columns:
            assert frame[name].to_numpy().tolist() == getattr(run, name).tolist()

    def test_several_values_are_several_curves(self, ok, tmp_path):
        ok("simulate", "--law", "coulomb", *SINE, "--set", "mu_coulomb=0.1,0.2,0.3", "--samples",
           11, "--out", "a.parquet", "--plot", "a.png")  # fmt: skip
        frame = pl.read_parquet(tmp_path / "a.parquet")
        assert frame.columns[0] == "mu_coulomb"
        assert frame["mu_coulomb"].unique(maintain_order=True).to_list() == [0.1, 0.2, 0.3]
        assert frame.height == 33
        about = json.loads(pl.read_parquet_metadata(tmp_path / "a.parquet")["locosweep.motion"])
        assert (about["law"], about["drive"]) == ("coulomb", "sine")
        assert about["fixed"]["drive_amplitude"] == 2

    def test_robot_and_json(self, ok):
        robot = ROOT / "examples" / "locosnake.toml"
        text = ok("simulate", "--law", "stribeck", "--robot", robot, "--set", "drive_force=2",
                  "--set", "drive_limit=inf", "--out", "a.csv", "--json")  # fmt: skip
        report = json.loads(text)
        assert report["files"] == ["a.csv"]
        assert report["fixed"]["mu_coulomb"] == 0.3
        assert report["fixed"]["drive_limit"] is None
        assert report["energy_residual"] < 1e-3

    def test_picture_alone(self, ok, tmp_path):
        assert ok("simulate", "--law", "coulomb", *SINE, "--set", "mu_coulomb=0.3", "--plot",
                  "a.svg") == "a.svg\n"  # fmt: skip
        assert [p.name for p in tmp_path.iterdir()] == ["a.svg"]

    def test_an_open_energy_ledger_is_told(self, call):
        code, out, err = call("simulate", "--law", "lugre", *MU, "--drive", "sine", "--set",
                              "drive_amplitude=2", "--set", "tolerance=0.1", "--out",
                              "a.csv")  # fmt: skip
        assert (code, out) == (0, "a.csv\n")
        assert "energy ledger" in err
        assert err.count("\n") == 1

    def test_samples_of_a_drive(self, ok, tmp_path):
        samples(tmp_path, "\ufefft, drive ,note\n0,0,a\n0.2,2,\n\n0.6,-1.5,b\n")
        ok("simulate", "--law", "coulomb", "--set", "mu_coulomb=0.3", "--drive-file", "drive.csv",
           "--samples", 6, "--out", "a.csv")  # fmt: skip
        force = pl.read_csv(tmp_path / "a.csv")["force"].to_list()
        assert force == [0, 2, 2, -1.5, -1.5, -1.5]

    def test_gain_of_the_robot_scales_samples(self, ok, tmp_path):
        samples(tmp_path, "t,drive\n0,2\n")
        samples(tmp_path, "[surface]\nmu_coulomb = 0.3\n[drive]\ngain = 3.0\n", "robot.toml")
        for more, force in (((), 6.0), (("--set", "gain=0.5"), 1.0)):
            ok("simulate", "--law", "coulomb", "--robot", "robot.toml", "--drive-file",
               "drive.csv", *more, "--samples", 2, "--out", "a.csv")  # fmt: skip
            assert pl.read_csv(tmp_path / "a.csv")["force"].to_list() == [force, force]


OUT = ("--out", "a.csv")
BAD = {
    "law": (("--law", "stribek", *OUT), "did you mean 'stribeck'"),
    "drive": (("--drive", "sin", *OUT), "did you mean 'sine'"),
    "method": (("--method", "runge", *OUT), "runge_kutta"),
    "method of another law": (("--law", "lugre", "--method", "exact", *MU, *OUT), "rosenbrock"),
    "out of range": (("--set", "mu_coulomb=-1", *OUT), "mu_coulomb is -1.0: allowed is a number"),
    "one of several": (("--set", "mu_coulomb=0.1,x", *OUT), "mu_coulomb is 'x'"),
    "no mu": (("--law", "coulomb", *OUT), "mu_coulomb is needed"),
    "no mu_static": (("--law", "lugre", "--set", "mu_coulomb=0.3", *OUT), "mu_static"),
    "set twice": (("--set", "mass=1,2", "--set", "mass=1", *OUT), "mass twice"),
    "no effect": (("--law", "coulomb", "--set", "mu_coulomb=0.3", "--set", "buildup=1,2", *OUT),
                  "law buildup"),
    "table without a file": (("--drive", "table", *MU, *OUT), "--drive-file"),
    "file with another drive": (("--drive", "sine", "--drive-file", "d.csv", *OUT), "--drive sine"),
    "no such drive file": (("--drive-file", "none.csv", *MU, *OUT), "none.csv: no such file"),
    "no out": (("--law", "coulomb", *MU), "--out is missing"),
    "ending": (("--law", "coulomb", *MU, "--out", "a.txt"), ".csv, .parquet"),
    "folder": (("--law", "coulomb", *MU, "--out", "no/a.csv"), "does not exist"),
    "one place for both": (("--law", "coulomb", *MU, "--out", "a.csv", "--plot", "a.csv"), ".png"),
    "too many curves": (("--set", "mu_coulomb=0.1:0.9:9", "--plot", "a.png"), "9 curves"),
    "one sample": (("--samples", "1", *MU, *OUT), "--samples"),
    "runs": (("--runs", "r.csv", *OUT), "--model is missing"),
    "model": (("--model", "m.toml", *OUT), "--runs is missing"),
    "two forms": (("--model", "m.toml", "--runs", "r.csv", "--law", "dahl", *OUT),
                  "--law is given beside --model and --runs"),
    "unit without runs": (("--unit", "x=mm", *MU, *OUT), "--column and --unit"),
    "too much": (("--set", "mu_coulomb=0:1:9000000", "--samples", "900000", *OUT), "GB"),
}  # fmt: skip


@pytest.mark.parametrize(("arguments", "word"), BAD.values(), ids=BAD)
def test_bad_input_of_simulate_is_one_line(refused, arguments, word):
    assert word in refused("simulate", *arguments)


@pytest.mark.parametrize(
    ("command", "name", "said"),
    [("laws", "stribek", "did you mean 'stribeck' ("), ("drives", "ramps", "Known are"),
     ("effects", "lag", "the nearest are drive_lag, "),
     ("quantities", "qqqqqq", "known are, of ")],
)  # fmt: skip
def test_unknown_names_to_list(refused, command, name, said):
    line = refused(command, name)
    assert said in line
    assert len(line) < 330
    if "Known" not in said:
        assert f"locosweep {command} lists all" in line


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="no folder here that nobody can write")
@pytest.mark.parametrize("option", ["--out", "--plot"])
def test_shut_folder(refused, option):
    name = {"--out": "/proc/a.csv", "--plot": "/proc/a.png"}[option]
    assert f"{name}: cannot write" in refused("simulate", *MU, option, name)


DRIVES = {
    "text": ("t,drive\n0,1\n1,x\n", ["row 2", "column drive", "'x'"]),
    "nan": ("t,drive\n0,1\n1,nan\n", ["row 2", "column drive", "missing"]),
    "infinite": ("t,drive\ninf,1\n", ["row 1", "column t", "infinite"]),
    "missing": ("t,drive\n0,\n", ["row 1", "column drive", "missing"]),
    "short row": ("t,drive\n0\n", ["row 1 has 1 values, there are 2 names"]),
    "grouped": ("t,drive\n0,1_000\n", ["row 1", "column drive", "1_000"]),
    "two commas": ('t,drive\n0,"1,5,5"\n', ["row 1", "column drive", "1,5,5"]),
    "backwards": ("t,drive\n0,1\n2,1\n1,1\n", ["row 3", "column t", "1 s after 2 s"]),
    "again": ("t,drive\n0,1\n0,2\n", ["row 2", "column t", "0 s after 0 s"]),
    "no column": ("time,drive\n0,1\n", ["no column t", "time, drive"]),
    "column twice": ("t,drive,t\n0,1,2\n", ["column t is there twice"]),
    "no rows": ("t,drive\n", ["no rows"]),
    "empty": ("", ["empty", "a line of names"]),
    "no csv": ('t,drive\n0,"1\n', ["row 1", "unexpected end of data"]),
}


@pytest.mark.parametrize(("text", "words"), DRIVES.values(), ids=DRIVES)
def test_bad_drive_file_is_one_line(refused, tmp_path, text, words):
    samples(tmp_path, text)
    line = refused("simulate", "--drive-file", "drive.csv", *MU, *OUT)
    assert [word for word in ["drive.csv", *words] if word not in line] == []


def test_drive_file_of_bytes(refused, tmp_path):
    (tmp_path / "drive.csv").write_bytes(b"t,drive\n0,\xff\n")
    line = refused("simulate", "--drive-file", "drive.csv", *MU, *OUT)
    assert "drive.csv: row 1, column drive: '\xff' is not a number" in line


SIMULATED = [q.name for q in registry.quantities() if q.simulated]
SEGMENT = [name for name in SIMULATED if not name.startswith("gait_")]


class TestSweeps:
    @pytest.mark.parametrize("quantity", SEGMENT)
    def test_heatmap_of_every_simulated_quantity(self, ok, tmp_path, quantity):
        ok("heatmap", quantity, "--law", "tustin", "--drive", "sine", "--x",
           "drive_amplitude=0.5:3:5", "--y", "mu_static=0.3:0.6:4", "--set", "mu_coulomb=0.3",
           "--data", "d.parquet")  # fmt: skip
        assert (tmp_path / f"{quantity}.png").stat().st_size > 1000
        expected = ls.sweep(
            quantity, mu_static=np.linspace(0.3, 0.6, 4), drive_amplitude=np.linspace(0.5, 3, 5),
            mu_coulomb=0.3, law="tustin", drive="sine",
        )  # fmt: skip
        assert ls.load(tmp_path / "d.parquet").values.tobytes() == expected.values.tobytes()

    @pytest.mark.parametrize("quantity", sorted(set(SIMULATED) - set(SEGMENT)))
    def test_heatmap_of_every_quantity_of_a_gait(self, ok, tmp_path, quantity):
        ok("heatmap", quantity, "--gait", "block", "--x", "mu_coulomb=0.05:0.2:4", "--y",
           "slope_deg=0:8:3", "--set", "segments=4", "--set", "mu_static=0.5", "--set",
           "joint_stiffness=2000", "--set", "joint_damping=20", "--set", "speed_limit=0.1",
           "--set", "cycles=2", "--data", "d.parquet")  # fmt: skip
        expected = ls.sweep(
            quantity, slope_deg=np.linspace(0, 8, 3), mu_coulomb=np.linspace(0.05, 0.2, 4),
            segments=4, mu_static=0.5, joint_stiffness=2000, joint_damping=20, speed_limit=0.1,
            cycles=2, gait="block",
        )  # fmt: skip
        assert np.isfinite(expected.values).any()
        assert ls.load(tmp_path / "d.parquet").values.tobytes() == expected.values.tobytes()

    def test_spec_gives_the_same_sweep(self, ok, tmp_path):
        samples(tmp_path, "t,drive\n0,2\n0.3,-2\n")
        ok("sweep", "final_position", "stroke_time", "--law", "patch", "--method", "runge_kutta",
           "--drive-file", "drive.csv", "--axis", "patch_ratio=0.5:2:4", *MU, "--out", "a.parquet",
           "--save-spec", "s.toml")  # fmt: skip
        ok("sweep", "--spec", "s.toml", "--out", "b.parquet", "--save-spec", "t.toml")
        assert (tmp_path / "s.toml").read_bytes() == (tmp_path / "t.toml").read_bytes()
        a, b = (ls.load(tmp_path / f"{n}.parquet") for n in "ab")
        for output in a.outputs:
            assert a[output.name].tobytes() == b[output.name].tobytes()
        assert a.fixed["gain"] == 1
        ok("plot", "a.parquet", "--value", "final_position", "--out", "a.png")

    def test_drive_file_counts_from_its_sweep_file(self, ok, tmp_path):
        (tmp_path / "sub").mkdir()
        samples(tmp_path, "t,drive\n0,2\n")
        ok("sweep", "final_position", "--law", "coulomb", "--drive-file", "drive.csv", "--axis",
           "mu_coulomb=0.1,0.2", "--save-spec", "sub/s.toml")  # fmt: skip
        assert 'drive_file = "../drive.csv"' in (tmp_path / "sub/s.toml").read_text()
        ok("sweep", "--spec", "sub/s.toml", "--out", "a.parquet")
        expected = ls.sweep("final_position", mu_coulomb=[0.1, 0.2], law="coulomb",
                            drive="table", drive_amplitude=1, table=([0], [2]))  # fmt: skip
        assert ls.load(tmp_path / "a.parquet").values.tolist() == expected.values.tolist()

    @pytest.mark.parametrize("name", ["dynamics", "surfaces"])
    def test_examples(self, ok, name):
        ok("sweep", "--spec", ROOT / "examples" / f"{name}.toml", "--out", "a.parquet")

    @pytest.mark.parametrize(
        ("arguments", "word"),
        [
            (("mean_velocity", "--law", "lugre"), "not simulated"),
            (("final_position", "--axis", "buildup=1,2"), "law buildup"),
            (("final_position", "--axis", "ripple_phase_deg=1,2"), "law ripple"),
            (("final_position", "--axis", "segments=1,2"), "does not depend on it"),
            (("final_position", "--law", "lugr"), "did you mean 'lugre'"),
            (("final_position", "--drive", "table"), "--drive-file"),
            (("final_position", "--drive-file", "none.csv"), "none.csv"),
        ],
    )
    def test_bad_input_is_one_line(self, refused, arguments, word):
        assert word in refused("sweep", *arguments, *MU, "--out", "a.parquet")

    def test_law_beside_a_spec(self, refused):
        spec = ROOT / "examples" / "dynamics.toml"
        assert "--law" in refused("sweep", "--spec", spec, "--law", "dahl", "--out", "a.parquet")

    def test_heatmap_over_what_has_no_effect(self, refused):
        assert "law buildup" in refused("heatmap", "final_position", "--x", "buildup=0:1:3", "--y",
                                        "mu_coulomb=0.1:1:3")  # fmt: skip


class TestSpec:
    SPEC = Spec(
        ("final_position",), (("drive_amplitude", Span(0.1, 3.0, 4)),), (("mu_coulomb", 0.3),),
        simulation=Simulation("dahl", "table", "rosenbrock", 'a "b".csv'),
    )  # fmt: skip

    def test_reads_back_exactly(self):
        assert Spec.from_toml(self.SPEC.to_toml()) == self.SPEC

    def test_without_simulation_nothing_is_written(self):
        assert "simulation" not in Spec(("final_position",)).to_toml()

    def test_run_is_the_sweep(self):
        spec = Spec(("final_position",), (("drive_amplitude", (1.0, 2.0)),), (("mu_coulomb", 0.3),),
                    simulation=Simulation("dahl", "sine"))  # fmt: skip
        expected = ls.sweep("final_position", drive_amplitude=[1, 2], mu_coulomb=0.3, law="dahl",
                            drive="sine")  # fmt: skip
        assert spec.run().values.tolist() == expected.values.tolist()

    @pytest.mark.parametrize(
        ("table", "word"),
        [
            ("[simulation]\nlav = 'dahl'", "did you mean 'law'"),
            ("[simulation]\nlaw = 'dal'", "did you mean 'dahl'"),
            ("[simulation]\nlaw = 3", "a word in quotes"),
            ("[simulation]\ndrive = 'table'", "drive file"),
            ("[simulation]\ndrive_file = 'd.csv'", "drive file"),
            ("[simulation]\nmethod = 'euler'", "unknown method"),
            ("simulation = 'dahl'", "write [simulation]"),
        ],
    )
    def test_bad_table_is_named(self, table, word):
        text = f"quantities = ['final_position']\n{table}\n"
        with pytest.raises(ls.DataFileError) as caught:
            Spec.from_toml(text)
        assert word in str(caught.value)
        assert "\n" not in str(caught.value)

    def test_read_drive(self, tmp_path):
        times, values = read_drive(samples(tmp_path, "drive,t\n5,0\n6,1e-1\n"))
        assert (times.tolist(), values.tolist()) == ([0, 0.1], [5, 6])


def test_listing_loads_neither_numpy_nor_matplotlib():
    code = (
        "import sys; from locosweep.cli import main; main(['laws']); main(['laws', 'lugre']); "
        "main(['simulate', '--help']); "
        "sys.exit(any(m in sys.modules for m in ('numpy', 'matplotlib', 'polars', 'scipy')))"
    )
    subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.DEVNULL)


def test_progress_of_a_simulation_only_on_a_terminal(tmp_path):
    pty = pytest.importorskip("pty")
    main_end, other = pty.openpty()
    code = "import sys; from locosweep.cli import main; sys.exit(main())"
    arguments = ("simulate", "--law", "coulomb", *SINE, "--set", "mu_coulomb=0.3", *OUT)
    subprocess.run([sys.executable, "-c", code, *arguments], cwd=tmp_path, stderr=other,
                   stdout=subprocess.PIPE, timeout=30, check=True)  # fmt: skip
    os.close(other)
    shown = os.read(main_end, 10_000).decode()
    os.close(main_end)
    assert "simulate" in shown
