"""Tables that are written come back as they were."""

import numpy as np
import polars as pl
import pytest

from locosweep.files.atomic import write_frame
from locosweep.files.runs import load_runs

T = np.arange(25) * 0.01


@pytest.mark.parametrize("label", ["#1", "%a", "//b", "7", "a,b", 'say "x"', "-1", "1e3", "nan"])
def test_labels_come_back(tmp_path, label):
    frame = pl.DataFrame({"run": ["0"] * 25 + [label] * 25, "t": [*T, *T], "drive": 0.5, "x": 0.25})
    write_frame(tmp_path / "r.csv", frame)
    runs, notices = load_runs(tmp_path / "r.csv")
    assert notices == []
    assert [run.label for run in runs] == ["0", label]
    np.testing.assert_array_equal(runs[1].t, T)


def test_rows_that_are_taken_for_comments_are_counted(tmp_path):
    rows = [f"{run},{t},0,1" for run in ("a", "#1") for t in T]
    (tmp_path / "r.csv").write_text("\n".join(["run,t,drive,x", *rows]))
    runs, notices = load_runs(tmp_path / "r.csv")
    assert [run.label for run in runs] == ["a"]
    assert notices == [
        f"{tmp_path / 'r.csv'}: lines left out as comments: 25 (begin with # or % or //)"
    ]
