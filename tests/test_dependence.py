"""Dependence points down, unsafe code stands in one file, data is never executed."""

from __future__ import annotations

import ast
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
CORE = ROOT / "rust" / "core"
PYTHON = ROOT / "python" / "locosweep"

# Crates of the core, lowest first; those of one row may not use each other. The fits stand
# in the crate of the whole, which also gathers the others under one name.
RUST_ORDER = [
    {"base"},
    {"formulas"},
    {"cells", "physics"},
    {"integrate"},
    {"replay", "simulate"},
    {"sweep"},
    {"friction_fit"},
]
# What a record of a parameter refuses with is an error, and an error says a name's neighbour.
RUST_CIRCLES = {
    ("base", "describe", "error"),
    # A piece of motion is read from the run that it is a part of.
    ("integrate", "robot::flow", "robot::ideal"),
}

# The rooms of the package, lowest first; those in one row may not see each other.
PYTHON_ORDER = [
    {"errors", "_core", "linear_algebra"},
    {"registry"},
    {"grid", "progress", "memory"},
    {"result"},
    {"provenance"},
    {"files"},
    {"request"},
    {"engine"},
    {"simulation"},
    {"specs"},
    {"run_folder"},
    {"virtual_grid", "kept_work"},
    {"plot"},
    {"uncertainty"},
    {"diagnosis.data"},
    {"diagnosis.effects"},
    {"diagnosis.estimate"},
    {"diagnosis.select"},
    {"diagnosis.report"},
    {"diagnosis.design"},
    {"diagnosis.pipeline", "diagnosis.screening"},
    {"diagnosis.batch", "friction_fit", "intake", "validation"},
    {"paper"},
    {"cli"},
]
# Conveniences of a result that reach up, each inside a function or for a type checker.
LAZY = {
    ("result", "plot"),
    ("result", "files"),
    ("run_folder", "plot"),
    ("simulation", "plot"),
    # A sweep into a folder is asked for like one into memory.
    ("engine", "run_folder"),
    ("specs", "run_folder"),
}
# Front doors, which only gather names: of the package, of a room, and old paths of users.
DOOR = {"__init__", "__main__", "diagnosis", "measured", "replay"}

UNSAFE = {Path("base/lane/stream.rs")}


def rank(order: list[set[str]], name: str) -> int:
    """Return the row of a module."""
    for row, names in enumerate(order):
        if name in names:
            return row
    raise AssertionError(f"{name} has no place in the order: give it one in this file")


def without_comments(text: str) -> str:
    """Drop comments and strings, where words are no code."""
    text = re.sub(r'r#"(?s:.)*?"#|r"[^"]*"|"(?:\\.|[^"\\])*"', '""', text)
    return re.sub(r"//[^\n]*|/\*(?s:.)*?\*/", "", text)


def crates() -> dict[str, tuple[Path, dict[str, Any]]]:
    """Folder and manifest of every crate of the core."""
    found = {path.parent.name: path for path in CORE.glob("*/Cargo.toml")}
    manifests = {name: (path.parent, path) for name, path in found.items()}
    manifests["friction_fit"] = (CORE / "friction_fit", ROOT / "Cargo.toml")
    return {n: (folder, tomllib.loads(p.read_text())) for n, (folder, p) in manifests.items()}


def crate_faults(dependencies: dict[str, set[str]]) -> list[str]:
    """Arrows between crates that point up or sideways."""
    return sorted(
        f"{crate} uses {used}"
        for crate, names in dependencies.items()
        for used in names
        if rank(RUST_ORDER, used) >= rank(RUST_ORDER, crate)
    )


def leaves(tree: str) -> list[str]:
    """Paths that the tree of a `use` stands for."""
    head, brace, rest = tree.partition("{")
    if not brace:
        return [tree.strip().partition(" as ")[0]]
    parts, depth, start = [], 0, 0
    for i, char in enumerate(rest):
        depth += {"{": 1, "}": -1}.get(char, 0)
        if depth < 0 or (char == "," and depth == 0):
            parts.append(rest[start:i])
            start = i + 1
        if depth < 0:
            break
    return [head.strip() + leaf for part in parts if part.strip() for leaf in leaves(part)]


Module = tuple[str, ...]


def module_of(path: Path) -> Module:
    """Modules down to a file, without the crate."""
    parts = path.with_suffix("").parts
    return parts[:-1] if parts[-1] in {"mod", "lib"} else parts


def rust_uses(text: str, own: Module, known: set[Module]) -> set[Module]:
    """Modules of the same crate that a source file names."""
    text = without_comments(text).partition("#[cfg(test)]")[0]
    paths = [leaf for use in re.findall(r"\buse\s+([^;]+);", text) for leaf in leaves(use)]
    paths += re.findall(r"\b(?:crate|super|self)(?:::\w+)+", text)
    found = set()
    for path in paths:
        parts = path.split("::")
        if parts[0] == "crate":
            place: Module = ()
        elif parts[0] in {"self", "super"}:
            place = own
        else:
            place, parts = own, ["self", *parts]
        for i, part in enumerate(parts):
            if part == "super":
                place = place[:-1]
            elif i > 0:
                place = (*place, part)
        while place and place not in known:
            place = place[:-1]
        found.add(place)
    return found


def rust_circles(crate: str, sources: dict[Module, str]) -> list[str]:
    """Modules side by side of which each needs the other, directly or through more.

    A module and the one that holds it belong together: between these there is no arrow.
    """
    arrows: dict[Module, set[Module]] = {}
    for own, text in sources.items():
        for used in rust_uses(text, own, set(sources)):
            common = next(
                (i for i, (a, b) in enumerate(zip(own, used, strict=False)) if a != b), None
            )
            if common is not None:
                arrows.setdefault(own[: common + 1], set()).add(used[: common + 1])

    def back(path: list[Module]) -> list[str]:
        found = []
        for used in sorted(arrows.get(path[-1], set())):
            if used == path[0]:
                if (crate, *("::".join(m) for m in path)) not in RUST_CIRCLES:
                    found.append(" -> ".join("::".join(m) for m in [*path, used]))
            elif used > path[0] and used not in path:
                found += back([*path, used])
        return found

    return [circle for module in sorted(arrows) for circle in back([module])]


def rust_sources(folder: Path) -> dict[Module, str]:
    """Texts of a crate by module."""
    return {module_of(p.relative_to(folder)): p.read_text() for p in sorted(folder.rglob("*.rs"))}


def room(module: str) -> str:
    """Return the entry of PYTHON_ORDER, or the front door, that a dotted module belongs to."""
    parts = module.split(".")
    deep = ".".join(parts[:2])
    if deep in set().union(*PYTHON_ORDER):
        return deep
    return parts[0] if parts != ["diagnosis", "__init__"] else "diagnosis"


def python_uses(text: str, module: str, known: set[str]) -> set[tuple[str, bool]]:
    """Modules of the package that a source file imports, and whether lazily.

    `known` are all dotted modules: what is imported from a package may be one of them.
    """
    tree = ast.parse(text)
    parents = {child: node for node in ast.walk(tree) for child in ast.iter_child_nodes(node)}
    package = ["locosweep", *module.split(".")[:-1]]

    def lazy(node: ast.AST) -> bool:
        while node in parents:
            node = parents[node]
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                return True
            # What only a type checker reads is no arrow at run time.
            if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
                return True
        return False

    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) + 1 - node.level] if node.level else []
            base = ".".join([*above, *filter(None, [node.module])])
            names = [f"{base}.{alias.name}" for alias in node.names]
        else:
            continue
        for name in names:
            if name.split(".")[0] != "locosweep":
                continue
            inner = name.removeprefix("locosweep").strip(".")
            while inner and inner not in known:
                inner = inner.rpartition(".")[0]
            found.add((inner or "__init__", lazy(node)))
    return found


def python_faults(sources: dict[str, str]) -> list[str]:
    """Arrows that point up; sources maps dotted module names to texts."""
    known = set(python_sources()) | set(sources)
    known |= {name.rpartition(".")[0] for name in known} - {""} | {"_core"}
    faults = []
    for name, text in sources.items():
        own = room(name)
        if own in DOOR or name.endswith("__init__"):
            continue
        for used, lazy in python_uses(text, name, known):
            other = room(used)
            if other in DOOR:
                faults.append(f"{name} uses the front door {other}")
            elif other != own:
                above = rank(PYTHON_ORDER, other) >= rank(PYTHON_ORDER, own)
                if above and not (lazy and (own, other) in LAZY):
                    faults.append(f"{name} uses {used}")
    return sorted(faults)


def python_sources() -> dict[str, str]:
    """Texts of the package by dotted module name."""
    paths = [path.relative_to(PYTHON) for path in sorted(PYTHON.rglob("*.py"))]
    return {".".join(p.with_suffix("").parts): (PYTHON / p).read_text() for p in paths}


def cycles(sources: dict[str, str]) -> list[str]:
    """Modules that import each other in a circle, what only a type checker reads left out."""
    known = set(sources)
    uses = {
        module: {u for u, lazy in python_uses(text, module, known) if not lazy} & known - {module}
        for module, text in sources.items()
    }
    left = dict(uses)
    while free := [module for module, others in left.items() if not others & set(left)]:
        for module in free:
            del left[module]
    # What only leads into a circle is taken away from the other end.
    while free := [m for m in left if not any(m in others for others in left.values())]:
        for module in free:
            del left[module]
    return sorted(left)


FORBIDDEN_CALLS = {"eval", "exec", "compile", "__import__"}
FORBIDDEN_IMPORTS = {"pickle", "cPickle", "dill", "cloudpickle", "marshal", "shelve", "yaml"}


def executes(text: str) -> list[str]:
    """Calls and imports through which data can become code."""
    faults = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            faults += [node.func.id] if node.func.id in FORBIDDEN_CALLS else []
        elif isinstance(node, ast.Import):
            faults += [a.name for a in node.names if a.name.split(".")[0] in FORBIDDEN_IMPORTS]
        elif isinstance(node, ast.ImportFrom) and node.module:
            faults += [node.module] if node.module.split(".")[0] in FORBIDDEN_IMPORTS else []
        elif isinstance(node, ast.keyword) and node.arg == "allow_pickle":
            allowed = isinstance(node.value, ast.Constant) and node.value.value is False
            faults += [] if allowed else ["allow_pickle"]
    return faults


def has_unsafe(text: str) -> bool:
    """Whether code, not a comment or a lint's name, says unsafe."""
    return re.search(r"\bunsafe\b|allow\(unsafe_code\)", without_comments(text)) is not None


def dependencies(manifest: dict[str, Any]) -> set[str]:
    """Names of everything that a crate depends on."""
    tables = [manifest, *manifest.get("target", {}).values()]
    kinds = ("dependencies", "dev-dependencies", "build-dependencies")
    return {name for table in tables for kind in kinds for name in table.get(kind, {})}


def test_rust_arrows_point_down() -> None:
    found = crates()
    assert set(found) == set().union(*RUST_ORDER)
    uses = {
        crate: {n.removeprefix("locosweep-") for n in dependencies(m) if n.startswith("locosweep-")}
        for crate, (_, m) in found.items()
    }
    assert crate_faults(uses) == []
    for crate, (folder, _) in found.items():
        assert rust_circles(crate, rust_sources(folder)) == []


def test_core_knows_no_python() -> None:
    names = set().union(*(dependencies(manifest) for _, manifest in crates().values()))
    assert "rayon" in names
    assert not names & {"pyo3", "numpy", "pyo3-ffi", "locosweep-python"}
    for path in CORE.rglob("*.rs"):
        assert not re.search(r"\bpyo3\b|\bnumpy::", path.read_text()), path


def test_python_arrows_point_down() -> None:
    assert python_faults(python_sources()) == []
    assert cycles(python_sources()) == []


def test_unsafe_code_stands_in_one_file() -> None:
    found = {p.relative_to(CORE) for p in CORE.rglob("*.rs") if has_unsafe(p.read_text())}
    assert found == UNSAFE
    bindings = ROOT / "rust" / "bindings"
    assert [p for p in bindings.rglob("*.rs") if has_unsafe(p.read_text())] == []
    workspace = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]
    assert workspace["lints"]["rust"]["unsafe_code"] == "deny"
    for manifest in [ROOT / "Cargo.toml", *ROOT.glob("rust/**/Cargo.toml")]:
        assert tomllib.loads(manifest.read_text())["lints"] == {"workspace": True}, manifest


def test_crates_without_tests_have_none() -> None:
    for name, (folder, manifest) in crates().items():
        sources = [] if name == "friction_fit" else folder.rglob("*.rs")
        has_tests = any("#[cfg(test)]" in path.read_text() for path in sources)
        assert not has_tests or manifest["lib"].get("test", True), f"{name}: tests that never run"


def test_nothing_is_executed_from_data() -> None:
    faults = {p.name: executes(p.read_text()) for p in PYTHON.rglob("*.py")}
    assert {name: f for name, f in faults.items() if f} == {}


@pytest.mark.parametrize(
    ("crate", "used"),
    [("base", "physics"), ("physics", "sweep"), ("cells", "physics"), ("sweep", "friction_fit")],
)
def test_planted_arrows_between_crates_are_found(crate: str, used: str) -> None:
    assert crate_faults({crate: {used}}) == [f"{crate} uses {used}"]
    assert crate_faults({used: {crate}}) == [] or crate == "cells"


def test_planted_circles_between_modules_are_found() -> None:
    a = {("a",): "use crate::b::X;", ("b",): "fn f() { super::a::g() }"}
    assert rust_circles("x", a) == ["a -> b -> a"]
    nested = "use crate::{\n    lane::{Lane, Level},\n    b::deep::X,\n};"
    b = {("a",): nested, ("b",): "pub mod deep;", ("b", "deep"): "use super::super::a;"}
    assert rust_circles("x", b) == ["a -> b -> a"]
    c = {("a",): "use crate::b;", ("b",): "use crate::c;", ("c",): "use super::a::{X, Y as Z};"}
    assert rust_circles("x", c) == ["a -> b -> c -> a"]
    # A module and its parts are one; comments and strings are no arrows.
    d = {
        ("a",): "mod b; pub use b::X;",
        ("a", "b"): "use super::Y; // crate::c",
        ("c",): '"crate::a"',
    }
    assert rust_circles("x", d) == []


@pytest.mark.parametrize(
    ("module", "text"),
    [
        ("registry", "from locosweep.grid import Grid"),
        ("errors", "import locosweep.engine"),
        ("grid", "from locosweep import plot"),
        ("files.runs", "from .. import engine"),
        ("memory", "from .engine import sweep"),
        ("grid", "def f():\n    from locosweep.plot.heatmap import Plotter"),
        ("result", "from locosweep.plot.heatmap import Plotter"),
        ("engine", "import locosweep"),
        ("engine", "from locosweep import sweep"),
        ("plot.style", "from locosweep.specs.sweep import Spec\nfrom locosweep.cli import main"),
        ("specs.sweep", "from locosweep.cli.options import fixed"),
        ("diagnosis.data.noise", "from locosweep.diagnosis.estimate.problem import Problem"),
        ("diagnosis.select.search", "from locosweep.diagnosis import diagnose"),
        ("diagnosis.report.page", "from ..pipeline import diagnose"),
        ("diagnosis.select.score", "if TYPE_CHECKING:\n    from ..report.page import page"),
        ("validation.check", "from locosweep.friction_fit.fit import fit_friction"),
    ],
)
def test_planted_python_violations_are_found(module: str, text: str) -> None:
    assert python_faults({module: text}) != []


def test_planted_cycles_are_found() -> None:
    a, b = "from locosweep import memory", "from locosweep.grid import Grid"
    c = "from locosweep.progress import Meter"
    assert cycles({"grid": a, "memory": b}) == ["grid", "memory"]
    assert cycles({"grid": a, "memory": c, "progress": b, "cli.sweep": a}) != []
    assert cycles({"grid": a, "memory": c}) == []


def test_stated_exceptions_are_the_only_ones() -> None:
    plotter = "def f():\n    from locosweep.plot.heatmap import Plotter"
    assert python_faults({"result": plotter}) == []
    assert python_faults({"engine": "from locosweep import _core, memory"}) == []
    own = "from .options import show\nfrom ..specs.sweep import Spec"
    assert python_faults({"cli.main": own}) == []
    with pytest.raises(AssertionError, match="no place"):
        python_faults({"unheard_of": "import locosweep.grid"})


@pytest.mark.parametrize(
    "text",
    ["eval('1')", "import pickle", "from yaml import load", "np.load(f, allow_pickle=True)"],
)
def test_planted_execution_is_found(text: str) -> None:
    assert executes(text) != []


def test_planted_unsafe_code_is_found() -> None:
    assert has_unsafe("fn f() { unsafe { g() } }")
    assert has_unsafe("#![allow(unsafe_code)]")
    assert not has_unsafe("// unsafe\n#![deny(unsafe_code)]")
