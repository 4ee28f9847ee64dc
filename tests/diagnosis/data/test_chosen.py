"""Runs by their labels."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import locosweep as ls
from locosweep.diagnosis.data.chosen import as_labels, chosen
from locosweep.errors import InputError
from locosweep.files.runs import Run

T = np.arange(0.0, 1.0, 0.01)
RUNS = [Run(label, T, T, {"x": T}) for label in ("0", "1", "2", "warm-up")]


@pytest.mark.parametrize(
    "asked", [[2, 0], ["2", "0"], (2.0, "0"), np.array([2, 0]), np.array([2.0, 0.0])]
)
def test_numbers_stand_for_the_labels_of_a_file(asked: Any) -> None:
    assert as_labels("holdout", asked) == ["2", "0"]
    assert [run.label for run in chosen(RUNS, as_labels("labels", asked))] == ["0", "2"]


def test_without_labels_all_take_part() -> None:
    assert as_labels("labels", None) is None
    assert chosen(RUNS, None) == RUNS


@pytest.mark.parametrize(
    ("asked", "said"),
    [("12", "labels is '12': allowed is a list"), (2, "labels is 2: allowed is a list"),
     ([3], "labels (--runs): no run 3: there are 0, 1, 2, warm-up"),
     ([], "labels (--runs) is empty: allowed")],
)  # fmt: skip
def test_faults_are_one_line(asked: Any, said: str) -> None:
    with pytest.raises(InputError, match=re.escape(said)):
        chosen(RUNS, as_labels("labels", asked))


def test_a_diagnosis_takes_numbers_and_looks_at_the_runs_asked_for() -> None:
    robot = ls.Robot({"mass": 0.2, "mu_coulomb": 0.3, "gravity": 9.81, "segments": 4.0})
    random = np.random.default_rng(0)
    t = np.linspace(0.0, 1.0, 101)
    drive = np.where(t > 0.1, 0.5, 0.0)
    runs = {"run": np.repeat([0, 1, 2], t.size), "t": np.tile(t, 3), "drive": np.tile(drive, 3),
            "x": random.normal(0.0, 1e-5, 3 * t.size)}  # fmt: skip
    found = ls.diagnose(runs, robot, labels=[0, 2], holdout=[2])
    assert [trace.label for trace in found.traces] == ["0", "2"]
    assert found.gap["held_out"] == ["2"]
    assert found.provenance["options"]["labels"] == ["0", "2"]
