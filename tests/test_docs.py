"""The documentation: links and paths exist, tables are current, code blocks run."""

from __future__ import annotations

import importlib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from locosweep.cli.commands import COMMANDS, command

ROOT = Path(__file__).parents[1]
PAGES = [
    *(
        ROOT / f"{name}.md"
        for name in ("README", "CONTRIBUTING", "CHANGELOG", "SECURITY", "THIRD-PARTY")
    ),
    ROOT / "benches" / "README.md",
    *sorted((ROOT / "docs").glob("*.md")),
]
IDS = [str(page.relative_to(ROOT)) for page in PAGES]
# Folders whose paths the documentation may name; all else in backticks belongs to a user.
FOLDERS = (".ci", "benches", "docs", "examples", "python", "rust", "tests")
FILES = [
    p for folder in FOLDERS for p in (ROOT / folder).rglob("*") if "__pycache__" not in p.parts
]
README_LINES = 120


def anchors(text: str) -> set[str]:
    """Return what the headings of a page can be linked by."""
    heads = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head).strip().lower().replace(" ", "-") for head in heads}


def dead_links(page: Path, text: str) -> list[str]:
    """Return relative links to files or headings that are not there."""
    dead = []
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        file, _, anchor = link.partition("#")
        if re.match(r"\w+:", link):
            continue
        target = page.parent / file if file else page
        if anchor and target.exists():
            fits = anchor in anchors(text if target == page else target.read_text())
        else:
            fits = target.exists()
        dead += [] if fits else [link]
    return dead


def is_there(path: str) -> bool:
    """Whether a path, from the root of the project or the end of one, fits a file."""
    if any(ROOT.glob(path.rstrip("/"))):
        return True
    return any(file.match(path) for file in FILES)


def resolves(name: str) -> bool:
    """Whether a dotted name of the package is a module or something in one."""
    parts = name.split(".")
    for cut in range(len(parts), 0, -1):
        try:
            found: object = importlib.import_module(".".join(parts[:cut]))
        except ModuleNotFoundError:
            continue
        for part in parts[cut:]:
            if not hasattr(found, part):
                return False
            found = getattr(found, part)
        return True
    return False


def dead_names(text: str) -> list[str]:
    """Return paths and dotted names in backticks that are not there."""
    text = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    dead = []
    for quoted in re.findall(r"`([^`\n]+)`", text):
        for word in quoted.split():
            word = word.split("(")[0]
            source = re.fullmatch(r"[\w./*-]+\.(py|rs|sh|jinja)", word)
            if source or re.match(rf"({'|'.join(map(re.escape, FOLDERS))})/", word):
                dead += [] if is_there(word) else [word]
            elif re.fullmatch(r"(locosweep|ls)(\.\w+)+", word):
                name = re.sub(r"^ls\.", "locosweep.", word)
                # Formats of files are named like modules: locosweep.sweep/1.
                dead += [] if resolves(name) else [word]
    return dead


def blocks(text: str, language: str) -> list[str]:
    """Return the code blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


def wrong_commands(text: str) -> list[str]:
    """Return commands in console blocks that `locosweep` would not take."""
    wrong = []
    for block in blocks(text, "console"):
        for line in re.findall(r"^\$ (.*)$", block.replace("\\\n", " "), re.MULTILINE):
            program, *words = shlex.split(line, comments=True)
            if program != "locosweep":
                continue
            if not words or words[0] not in COMMANDS:
                wrong.append(line)
                continue
            options = {
                name for p in command(words[0]).params for name in (*p.opts, *p.secondary_opts)
            }
            given = {word for word in words[1:] if word.startswith("--")}
            wrong += [line] if given - options - {"--help"} else []
    return wrong


def tables(docs: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Write or check the tables of a folder of pages."""
    command = [sys.executable, str(ROOT / "benches" / "tables.py"), "--docs", str(docs), *words]
    paths = [str(ROOT / "python"), *filter(None, [os.environ.get("PYTHONPATH")])]
    return subprocess.run(
        command,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("page", PAGES, ids=IDS)
def test_links_and_paths_exist(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    assert dead_links(page, text) == []
    assert dead_names(text) == []
    assert wrong_commands(text) == []


@pytest.mark.parametrize(
    ("text", "dead"),
    [
        ("[a](docs/no_such_page.md)", ["docs/no_such_page.md"]),
        ("[a](docs/blind-check.md#no-such-heading)", ["docs/blind-check.md#no-such-heading"]),
        ("[a](#no-heading)", ["#no-heading"]),
        ("[a](docs/blind-check.md#sizes) [b](https://example.org/x) # c", []),
    ],
)
def test_planted_dead_links_are_found(text: str, dead: list[str]) -> None:
    assert dead_links(ROOT / "README.md", text) == dead


@pytest.mark.parametrize(
    "text",
    [
        "`tests/registry.rs`",
        "`rust/core/no_such_room/`",
        "see `closed_form/no_such.rs` there",
        "`python/locosweep/plot*.py`",
        "`locosweep.diagnosis.pictures`",
        "`ls.no_such_function(x)`",
    ],
)
def test_planted_dead_paths_are_found(text: str) -> None:
    assert len(dead_names(text)) == 1


def test_paths_of_users_are_no_dead_paths() -> None:
    text = (
        "`report.html`, `sealed/NAME/truth.json`, `ls.sweep(q)`, `closed_form/mod.rs`, `sweep.rs`"
    )
    assert dead_names(text) == []


def test_planted_wrong_commands_are_found() -> None:
    good = "```console\n$ locosweep sweep q --axis a=1:2 \\\n    --out f.parquet\n```\n"
    assert wrong_commands(good) == []
    assert len(wrong_commands(good.replace("--axis", "--axes"))) == 1
    assert len(wrong_commands(good.replace("sweep q", "swoop q"))) == 1


def test_tables_are_current() -> None:
    done = tables(ROOT / "docs", "--check")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("page", "old", "new", "said"),
    [
        ("blind-check.md", "| 0.991 |", "| 0.998 |", "blind-check.md"),
        ("effects.md", "`back_emf`", "`back_mf`", "effects.md"),
        ("speed.md", "<!-- end peers -->\n", "", "no partner"),
        ("speed.md", "begin peers -->", "begin beers -->", "no partner"),
    ],
)
def test_planted_old_tables_are_found(
    tmp_path: Path, page: str, old: str, new: str, said: str
) -> None:
    docs = tmp_path / "docs"
    shutil.copytree(ROOT / "docs", docs)
    text = (docs / page).read_text(encoding="utf-8")
    assert old in text
    (docs / page).write_text(text.replace(old, new), encoding="utf-8")
    done = tables(docs, "--check")
    assert done.returncode != 0
    assert said in done.stderr


def test_a_stored_result_fills_its_table(tmp_path: Path) -> None:
    page = tmp_path / "speed.md"
    page.write_text("<!-- begin border -->\n<!-- end border -->\n", encoding="utf-8")
    assert tables(tmp_path).returncode == 0
    assert "Not measured yet" in page.read_text(encoding="utf-8")
    line = {"what": "one point", "median": 3.14e-5, "fastest": None, "target": 5e-5}
    known = {
        "machine": {"simd": "avx2"},
        "command": "locosweep x --json /home/f.json --out /home/o",
    }
    result = tmp_path / "border.json"
    result.write_text(json.dumps(known | {"lines": [line]}))
    done = tables(tmp_path, "--store", "border", str(result))
    assert done.returncode == 0, done.stderr
    text = page.read_text(encoding="utf-8")
    assert "| one point | 31.4 us | - | at most 50 us |" in text
    assert "simd avx2: `locosweep x --out DIR`." in text


def test_printed_precision_fills_its_table(tmp_path: Path) -> None:
    page = tmp_path / "accuracy.md"
    page.write_text("<!-- begin accuracy -->\n<!-- end accuracy -->\n", encoding="utf-8")
    printed = tmp_path / "accuracy.txt"
    printed.write_text(
        "worst\nnet_force 3.4e-14 1.1e-15 3.5e-16     732 values\n"
        ".slope_limit_deg: worst error 2.2e-15 relative\n"
        "..best_velocity: worst error 1.8e-16; 100 ties\n"
    )
    assert tables(tmp_path, "--store", "accuracy", str(printed)).returncode == 0
    text = page.read_text(encoding="utf-8")
    assert "| `net_force` | 732 | 3.4e-14 | 1.1e-15 | 3.5e-16 |" in text
    assert "| `slope_limit_deg` | - | - | - | 2.2e-15 |" in text
    assert "| `best_velocity` | - | - | - | 1.8e-16 |" in text


def test_the_readme_is_short_and_starts_with_the_two_commands() -> None:
    lines = (ROOT / "README.md").read_text(encoding="utf-8").splitlines()
    assert len(lines) < README_LINES
    first = blocks("\n".join(lines), "console")[0].splitlines()
    assert [line.split("#")[0].strip() for line in first] == ["$ make run", "$ make test"]


@pytest.mark.parametrize(
    "page",
    [
        "README.md",
        *(
            f"docs/{name}.md"
            for name in (
                *("README", "sweeps", "simulation", "friction", "your-data", "size-a-robot"),
                *("sweep-big", "decide-under-uncertainty"),
            )
        ),
    ],
)
def test_python_blocks_run(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    code = "\n".join(blocks((ROOT / page).read_text(encoding="utf-8"), "python"))
    assert code
    exec(compile(code, page, "exec"), {})  # noqa: S102


def test_readme_tells_of_diagnosis_and_of_what_a_build_costs_on_its_first_screen():
    first = (ROOT / "README.md").read_text().splitlines()[:36]
    assert any("measured runs" in line for line in first[:10])
    assert any(re.search(r"\d+ minutes on 2 cores", line) for line in first)
    assert any(re.search(r"[\d.]+ GB", line) for line in first)
