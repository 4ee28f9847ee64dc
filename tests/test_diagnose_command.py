"""The command `diagnose`, with an engine that answers at once."""

import json
from pathlib import Path

import pytest

from diagnosis_case import made
from locosweep.cli import main
from locosweep.diagnosis import Diagnosis


@pytest.fixture(scope="module")
def found(tmp_path_factory) -> Diagnosis:
    return made(tmp_path_factory.mktemp("case"))


class TestCommand:
    @pytest.fixture
    def call(self, tmp_path, monkeypatch, capsys, found):
        """Run the command with an engine that returns the case of these tests."""
        asked = []

        def engine(*arguments, **options):
            asked.append((arguments, options))
            return found

        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr("locosweep.diagnosis.pipeline.diagnose", engine)
        # Pictures have tests of their own.
        monkeypatch.setattr("locosweep.diagnosis.report.figures.FILES", {})

        def run(*arguments):
            code = main(["diagnose", *arguments])
            done = capsys.readouterr()
            return code, done.out, done.err, asked

        return run

    def test_verdict_goes_out_and_notes_beside_it(self, call, tmp_path, found):
        code, out, err, asked = call(
            "r.csv", "--nominal", "n.toml", "--out", "d", "--holdout", "2,3", "--holdout", "4",
            "--runs", "1,2, 3", "--runs", "4",
            "--seed", "5", "--max-effects", "2", "--column", "drive=tau", "--unit", "x=mm",
            "--threads", "1",
        )  # fmt: skip
        assert code == 0
        assert out.splitlines() == [
            "explained: lubricant_buildup (probability 0.97)", found.summary,
            "What to do: give the model lubricant buildup (resistance per distance swept since "
            "the last rest or turn 0.6 N/m).", "d/report.html"
        ]  # fmt: skip
        assert err.splitlines() == [
            "locosweep: diagnose: writing the report", f"locosweep: note: {found.warnings[0]}"
        ]  # fmt: skip
        ((arguments, options),) = asked
        assert callable(options.pop("progress"))
        assert arguments == (Path("r.csv"), Path("n.toml"))
        assert options == {"holdout": ["2", "3", "4"], "labels": ["1", "2", "3", "4"],
                           "max_effects": 2, "seed": 5,
                           "columns": {"drive": "tau"}, "units": {"x": "mm"}, "threads": 1,
                           "separator": None, "decimal": None}  # fmt: skip
        assert (tmp_path / "d" / "report.html").is_file()

    def test_markdown_is_printed_alone_and_stands_in_the_folder(self, call, tmp_path, found):
        given = ("r", "--nominal", "n", "--out", "d", "--format", "md")
        code, out, _, _ = call(*given)
        assert code == 0
        assert out == found.to_markdown() == (tmp_path / "d" / "report.md").read_text()
        code, out, err, _ = call(*given, "--json", "--force")
        assert (code, out) == (2, "")
        assert "--json is given beside --format md" in err

    def test_several_files(self, call):
        given = ("--nominal", "n", "--out", "d")
        code, _, _, asked = call("a.csv", "b.csv", *given)
        assert code == 0
        assert asked[0][0] == ([Path("a.csv"), Path("b.csv")], Path("n"))
        assert call(*given)[0] == 2

    def test_quiet_and_json(self, call, found):
        code, out, err, asked = call("r", "--nominal", "n", "--out", "d", "--quiet")
        assert (code, err, len(out.splitlines())) == (0, "", 2)
        assert asked[0][1]["progress"] is None
        code, out, _, _ = call("r", "--nominal", "n", "--out", "e", "--json")
        assert json.loads(out) == {"verdict": found.report["verdict"], "out": "e"}

    def test_a_full_folder_is_refused_before_the_work(self, call, tmp_path):
        (tmp_path / "d").mkdir()
        (tmp_path / "d" / "x").write_text("")
        code, out, err, asked = call("r", "--nominal", "n", "--out", "d")
        assert (code, out, asked) == (2, "", [])
        assert err.startswith("locosweep: d is not empty")
        assert call("r", "--nominal", "n", "--out", "d", "--force")[0] == 0

    @pytest.mark.parametrize(
        "options",
        [
            ("--max-effects", "0"),
            ("--max-effects", "4"),
            ("--seed", "-1"),
            ("--column", "drive"),
            ("--unit", "x="),
            (),
        ],
    )
    def test_bad_options_cost_one_line(self, call, tmp_path, options):
        given = ("--nominal", "n", "--out", "d") if options else ("--out", "d")
        code, out, err, asked = call("r", *given, *options)
        assert (code, out, asked) == (2, "", [])
        assert err.count("\n") == 1
        assert not (tmp_path / "d").exists()
