"""The report in short: complete for who has read nothing else, and harmless."""

import copy
import re
from dataclasses import replace

import pytest

from locosweep.diagnosis.report.markdown import markdown


@pytest.fixture
def own(found):
    return replace(found, report=copy.deepcopy(found.report))


def tables(text):
    """Cells of each table, by row."""
    blocks = re.findall(r"(?:^\|.*\|$\n?)+", text, re.M)
    return [[[c.strip() for c in re.split(r"(?<!\\)\|", line)[1:-1]]
             for line in block.strip().split("\n")] for block in blocks]  # fmt: skip


def test_says_what_was_found_and_what_to_do(found):
    text = found.to_markdown()
    assert text.startswith("## Cause found: lubricant buildup\n\n")
    for part in ("In run 3 the head stops short", "**What to do: give the model lubricant",
                 "### How large the gap is", "| nominal model |", "### What makes it",
                 "`k_b` = 0.600 ± 0.012 N/m", "### Warnings", found.provenance["runs_sha256"][:16],
                 "root mean square of measured minus simulated"):  # fmt: skip
        assert part in text, part
    for rows in tables(text):
        assert len({len(row) for row in rows}) == 1


def test_the_same_diagnosis_gives_the_same_text(found):
    assert found.to_markdown() == markdown(found)
    assert "2026" not in found.to_markdown()


def test_down_to_the_noise_nothing_is_left_to_explain(own):
    assert "| left, as noise |" in markdown(own)
    own.report["verdict"]["law_mismatch"] = True
    assert "| left by the nearest formula |" in markdown(own)
    own.report["verdict"] |= {"law_mismatch": False, "status": "partial"}
    assert "| nobody has explained |" in markdown(own)


def test_a_class_is_not_given_as_one_cause(own):
    row = own.report["verdict"]["contributions"][0]
    row["effects"] = ["lubricant_buildup", "quadratic_drag"]
    text = markdown(own)
    assert "| **lubricant buildup** or quadratic drag |" in text
    assert "cannot be told apart" in text


@pytest.mark.parametrize("status", ["none", "unexplained"])
def test_nothing_named(own, status):
    verdict = own.report["verdict"]
    verdict |= {"status": status, "effects": [], "equivalent": [], "contributions": []}
    own.report["gap"] |= {"before": None}
    text = markdown(own)
    assert "What makes it" not in text
    assert "is not known" in text
    assert ("is no cause" in text) == (status == "unexplained")


def test_names_from_files_stay_text(hostile, own):
    own.report["warnings"] = ["run <b>|x|</b> @someone [a](http://b) `c` # d", "two\nlines"]
    text = markdown(own)
    assert ("- run &lt;b>\\|x\\|&lt;/b> &#64;someone \\[a\\](http://b) \\`c\\` \\# d\n- two lines"
            in text)  # fmt: skip
    assert "<script" not in markdown(hostile)
    assert "\u202e" not in markdown(hostile)
