"""The report as a whole: what its sections are made of, with a named effect and without."""

from __future__ import annotations

import hashlib
from dataclasses import replace

import numpy as np
import pytest

from diagnosis_search import search_for
from diagnosis_small import ROBOT
from locosweep.diagnosis.report.assemble import Findings, Source, assemble
from locosweep.diagnosis.select.verdict import choose

DRAG = 0.6
NO_RUN = {"separates": [], "suggestion": None}


def findings(effects: dict[str, dict[str, float]]) -> Findings:
    """Return what a search among two effects finds on runs of a reality with `effects`."""
    search = search_for(effects, "viscous_friction", "drive_gain_error")
    choice = choose(search, 1)
    return Findings(
        search,
        choice,
        search.problem,
        None,
        None,
        False,
        NO_RUN,
        {"anchor_slip": "no body"},
        ("first",),
    )


@pytest.fixture(scope="module")
def dragged() -> Findings:
    return findings({"viscous_friction": {"c": DRAG}})


def test_a_named_effect_is_in_the_augmented_model_and_nowhere_in_the_nominal_one(
    dragged: Findings,
) -> None:
    assert dragged.named
    assert dragged.nominal.names == ()
    assert dragged.augmented.names == ("viscous_friction",)
    found = assemble(dragged, Source(ROBOT, ROBOT, "0" * 64, 0))
    assert found.effects == ["viscous_friction"]
    assert found.augmented.effects["viscous_friction"]["c"] == pytest.approx(DRAG, rel=0.01)
    assert found.nominal is ROBOT
    assert found.report["where"]["site"] == "friction"


def test_sections_carry_what_was_handed_in(dragged: Findings) -> None:
    report = assemble(dragged, Source(ROBOT, ROBOT, "a" * 64, 7)).report
    assert report["warnings"][0] == "first"
    assert {"effect": "anchor_slip", "why": "no body"} in report["not_visible"]
    assert report["next_experiment"] == NO_RUN
    assert report["provenance"]["runs_sha256"] == "a" * 64
    assert report["provenance"]["seed"] == 7
    assert report["verdict"]["equivalent"][0][0] == "viscous_friction"
    weights = [row["probability"] for row in report["candidates"]]
    assert all(0.0 <= weight <= 1.0 for weight in weights)


def test_curves_are_the_measured_runs_and_replays_of_both_models(dragged: Findings) -> None:
    found = assemble(dragged, Source(ROBOT, ROBOT, "0" * 64, 0))
    noise = dragged.search.problem.noise["x"].sd
    for trace, run in zip(found.traces, dragged.whole.runs, strict=True):
        np.testing.assert_array_equal(trace.measured["x"], run.channels["x"])
        assert np.abs(trace.augmented["x"] - trace.measured["x"]).max() < 8.0 * noise
        assert np.abs(trace.nominal["x"] - trace.measured["x"]).max() > 100.0 * noise


def test_a_set_of_effects_stands_once_and_in_one_order(dragged: Findings) -> None:
    (fit, weight), *rest = dragged.choice.ranked
    turned = [(one, w) for one, w in [(fit, weight), *rest] for _ in range(2)]
    twice = replace(dragged, choice=replace(dragged.choice, ranked=turned))
    report = assemble(twice, Source(ROBOT, ROBOT, "0" * 64, 0)).report
    sets = [frozenset(row["effects"]) for row in report["candidates"]]
    assert len(set(sets)) == len(sets)
    assert all(row["effects"] == sorted(row["effects"], key=lambda n: (n != "viscous_friction", n))
               for row in report["candidates"])  # fmt: skip


def test_errors_of_free_runs_fall_with_the_cause(dragged: Findings) -> None:
    found = assemble(dragged, Source(ROBOT, ROBOT, "0" * 64, 0)).details["free_runs"]
    assert list(found["errors"]) == ["nominal model", "viscous_friction"]
    before, after = found["errors"].values()
    assert found["seconds"] == sorted(found["seconds"])
    assert before[-1] > before[0]
    assert after[-1] < 0.1 * before[-1]


def test_files_and_options_are_named(tmp_path) -> None:
    source = Source(ROBOT, tmp_path / "rig.toml", "0" * 64, 0, tmp_path / "log.csv", {"seed": 1})
    quiet = findings({})
    (tmp_path / "rig.toml").write_text("[robot]\n")
    known = assemble(quiet, source).provenance
    assert (known["runs_file"], known["nominal_file"]) == ("log.csv", "rig.toml")
    assert known["options"] == {"seed": 1}
    assert assemble(quiet, Source(ROBOT, ROBOT, "0" * 64, 0)).provenance["runs_file"] is None


def test_without_a_gap_both_models_are_the_nominal_one() -> None:
    quiet = findings({})
    found = assemble(quiet, Source(ROBOT, ROBOT, "0" * 64, 0))
    assert found.status == "none"
    assert found.report["where"]["site"] is None
    assert found.augmented.effects == {}
    assert quiet.augmented.names == ()


def test_a_nominal_file_is_known_by_its_bytes(tmp_path) -> None:
    path = tmp_path / "nominal.toml"
    path.write_bytes(b"[robot]\nmass = 1.0\n")
    source = Source(ROBOT, path, "", 0)
    assert source.nominal_sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    other = replace(ROBOT, other={})
    assert Source(other, other, "", 0).nominal_sha256 != Source(ROBOT, ROBOT, "", 0).nominal_sha256
