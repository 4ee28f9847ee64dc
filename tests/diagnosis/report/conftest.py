"""Diagnoses that tests of the report share; none may change them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from diagnosis_case import HOSTILE, made

if TYPE_CHECKING:
    from pathlib import Path

    from locosweep.diagnosis import Diagnosis


@pytest.fixture(scope="session")
def found(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    return made(tmp_path_factory.mktemp("case"))


@pytest.fixture(scope="session")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> Diagnosis:
    """A diagnosis of runs with names that a page or a picture might take for code."""
    return made(tmp_path_factory.mktemp("hostile"), labels=HOSTILE)


@pytest.fixture(scope="session")
def saved(found: Diagnosis, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("saved") / "new" / "report"
    found.save(out)
    return out
