"""What the project says of itself: its version, its licences, how to cite it."""

from __future__ import annotations

import importlib
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
CARGO = tomllib.loads((ROOT / "Cargo.toml").read_text("utf-8"))["workspace"]["package"]
THIRD_PARTY = ROOT / "THIRD-PARTY.md"


def third_party(*words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, ROOT / "benches" / "third_party.py", *words]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_citation_agrees_with_the_package() -> None:
    assert CITATION["version"] == CARGO["version"]
    assert " OR ".join(CITATION["license"]) == PROJECT["license"] == CARGO["license"]
    (paper,) = CITATION["references"]
    assert paper["title"] in (ROOT / "README.md").read_text("utf-8").replace("\n", " ")


@pytest.mark.slow
def test_the_citation_is_valid(tmp_path: Path) -> None:
    """The reference checker needs versions of others that fit nothing else here."""
    subprocess.run([sys.executable, "-m", "venv", tmp_path], check=True)
    python = tmp_path / "bin" / "python"
    quiet = ("--quiet", "--disable-pip-version-check")
    subprocess.run([python, "-m", "pip", "install", *quiet, "cffconvert==2.0.0"], check=True)
    check = [tmp_path / "bin" / "cffconvert", "--validate", "-i"]
    assert subprocess.run([*check, ROOT / "CITATION.cff"], check=False).returncode == 0
    wrong = tmp_path / "CITATION.cff"
    wrong.write_text((ROOT / "CITATION.cff").read_text("utf-8").replace("authors:", "writers:"))
    assert subprocess.run([*check, wrong], check=False, capture_output=True).returncode != 0


def test_the_classifiers_name_every_python_that_is_tested() -> None:
    found = {
        line.rpartition(" :: ")[2] for line in PROJECT["classifiers"] if ":: Python ::" in line
    }
    assert {"3.11", "3.12", "3.13"} <= found
    assert len(PROJECT["classifiers"]) == len(set(PROJECT["classifiers"]))


def test_licences_of_third_parties_are_current() -> None:
    done = third_party("--check")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("old", "new", "current"),
    [
        ("| strsim | 0.11.1 |", "| strsim | 0.10.0 |", False),
        ("| polars |", "| polar |", False),
        ("| jinja2 | BSD License |", "| jinja2 | BSD-3-Clause |", True),
        ("Permission is hereby granted", "Permission is hereby sold", False),
    ],
)
def test_planted_old_licences_are_found(
    monkeypatch: pytest.MonkeyPatch, old: str, new: str, current: bool
) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "benches"))
    comparable = importlib.import_module("third_party").comparable
    text = THIRD_PARTY.read_text("utf-8")
    assert old in text
    assert (comparable(text.replace(old, new)) == comparable(text)) is current


def test_every_dependency_has_its_licence() -> None:
    text = THIRD_PARTY.read_text("utf-8")
    for needed in PROJECT["dependencies"]:
        assert f"| {needed.partition('>')[0]} |" in text
    for crate in ("nalgebra", "rayon", "pyo3", "libm"):
        assert f"| {crate} |" in text
    # Licences that a wheel under ours could not keep to.
    assert "GPL" not in text
    assert "not stated" not in text
