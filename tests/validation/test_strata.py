"""Strata of the blind check: what is drawn, and what is refused."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import pytest

from locosweep.cli import main
from locosweep.errors import InputError
from locosweep.validation.case_files import SEAL, read_truth
from locosweep.validation.laws import KEPT_OUT, OUTSIDE
from locosweep.validation.strata import STRATA, chosen_families, draw_stratum

if TYPE_CHECKING:
    from pathlib import Path


def test_no_two_strata_share_a_seed() -> None:
    numbers = [stratum.number for stratum in STRATA.values()]
    assert len(set(numbers)) == len(numbers)
    # Second numbers of the seeds of the mixture and of bad readings.
    assert not set(numbers) & {0, 1, 2, 3}


def test_help_names_every_stratum(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["blind-check", "--help"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    for name in STRATA:
        assert name in said


def test_families_are_those_of_the_stratum() -> None:
    outside = STRATA["outside"]
    assert chosen_families(outside, ()) == (*OUTSIDE, *KEPT_OUT)
    assert chosen_families(outside, ("dust_ridge",)) == ("dust_ridge",)
    with pytest.raises(InputError, match="--families: viscous is no disturbance"):
        chosen_families(outside, ("viscous",))
    with pytest.raises(InputError, match="only with --only outside"):
        chosen_families(STRATA["pairs"], ("tether",))


@pytest.mark.slow
def test_cases_of_chosen_families_are_sealed_and_kept(tmp_path: Path) -> None:
    drawn = {"families": ["sagging_rail"], "processes": 1}
    (name,) = draw_stratum(tmp_path, STRATA["outside"], 1, 3, **drawn)  # type: ignore[arg-type]
    truth = read_truth(tmp_path, name)
    assert truth["outside"]["name"] == "sagging_rail"
    runs = (tmp_path / name / "runs.csv").read_bytes()
    before, seal = (tmp_path / name / "runs.csv").stat().st_mtime_ns, (tmp_path / SEAL).read_text()
    draw_stratum(tmp_path, STRATA["outside"], 1, 3, **drawn)  # type: ignore[arg-type]
    assert (tmp_path / name / "runs.csv").stat().st_mtime_ns == before
    assert (tmp_path / SEAL).read_text() == seal
    draw_stratum(tmp_path, STRATA["outside"], 1, 4, **drawn)  # type: ignore[arg-type]
    assert (tmp_path / name / "runs.csv").read_bytes() != runs


@pytest.mark.slow
@pytest.mark.parametrize("name", ["background", "another-law", "pairs", "bad-readings"])
def test_a_stratum_is_of_one_kind(name: str, tmp_path: Path) -> None:
    (folder,) = draw_stratum(tmp_path, STRATA[name], 1, 3)
    truth = read_truth(tmp_path, folder)
    if name == "background":
        (effect,) = truth["effects"]
        assert 2.4 <= effect["d"] / truth["background"]["d"] <= 37.5
        assert effect["name"] in effect["accepted"]
        assert len(truth["world"]) == 2
        # Twelve fresh runs; beside the background the true effect leaves a part of the gap.
        assert len(truth["check_starts"]) == 12
        for runs in ("runs", "check"):
            assert list(truth["reached"][runs]) == truth["channels"]
            assert all(share < 1.0 for share in truth["reached"][runs].values())
        assert truth["reached"]["runs"]["x"] > 0.5
    elif name == "another-law":
        assert truth["mismatch"]
        assert truth["effects"][0]["form"] not in ("law", "force")
    elif name == "pairs":
        assert len(truth["effects"]) == 2
    else:
        assert truth["fault"]["name"] == "spikes"


@pytest.mark.slow
def test_a_stratum_from_end_to_end(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = [
        "blind-check", "--only", "outside", "--families", "sagging_rail", "--cases", "1",
        "--seed", "3", "--quiet", "--threads", "1", "--out", str(tmp_path / "check"),
    ]  # fmt: skip
    assert main(command) == 0
    assert "a wrong name" in capsys.readouterr().out
    found = json.loads((tmp_path / "check" / "metrics.json").read_text())
    assert found["stratum"] == "outside"
    assert [case["family"] for case in found["cases"]] == ["sagging_rail"]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--only", "inside"], "--only is inside: allowed are outside, another-law"),
        (["--families", "tether"], "--only is missing"),
        (["--only", "outside", "--families", "wind"], "wind is no disturbance"),
        (["--only", "pairs", "--gap-free", "3"], "--gap-free: allowed not beside --only"),
        (["--only", "pairs", "--experiments", "3"], "--experiments: allowed not beside --only"),
        (["--only", "pairs", "--cases", "0"], "--cases is 0"),
    ],
)
def test_what_makes_no_stratum_is_refused(
    options: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "check"
    assert main(["blind-check", *options, "--out", str(out)]) == 2
    assert said in capsys.readouterr().err
    assert not out.exists()
