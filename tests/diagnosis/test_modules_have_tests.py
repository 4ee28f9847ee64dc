"""Every module of the diagnosis and of its validation is imported by a test file, by name."""

from __future__ import annotations

import ast
from pathlib import Path

TESTS = Path(__file__).parents[1]
PACKAGE = TESTS.parent / "python" / "locosweep"
ROOMS = ("diagnosis", "validation")


def imported(text: str) -> set[str]:
    """Dotted names that a test file imports, from packages too."""
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return found


def modules() -> set[str]:
    """Modules of both rooms; front doors only gather names."""
    files = (path for room in ROOMS for path in (PACKAGE / room).rglob("*.py"))
    paths = (path.relative_to(PACKAGE.parent) for path in files)
    return {".".join(p.with_suffix("").parts) for p in paths if p.name != "__init__.py"}


def test_every_module_has_a_test_file() -> None:
    known = set().union(*(imported(path.read_text()) for path in TESTS.rglob("test_*.py")))
    assert sorted(modules() - known) == []


def test_imports_are_found_in_every_form() -> None:
    text = "import a.b\nfrom c import d as e\ndef f():\n    from g.h import i"
    assert imported(text) >= {"a.b", "c.d", "g.h"}
    assert len(modules()) > 30
