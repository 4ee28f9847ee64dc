"""Write THIRD-PARTY.md: what the package is built from, and under which licences.

    python benches/third_party.py           write it anew
    python benches/third_party.py --check   fail if it is not current

Crates and their licences come from `cargo metadata`, Python packages from pyproject.toml and from
what is installed.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

from common.table import rows

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "THIRD-PARTY.md"
PLATFORM = "x86_64-unknown-linux-gnu"
# Ours, whose text every wheel holds. What is offered under it is taken under it.
OURS = "Apache-2.0"

HEAD = """# Third-party licences

Written by `python benches/third_party.py`; do not edit.

## Compiled into the package

Rust crates that the core of the wheel holds (on {platform}). Those that are offered under
Apache-2.0 are taken under it, whose text is in [LICENSE-APACHE](LICENSE-APACHE).

{crates}
## Installed beside it

Python packages that `pip` installs with it. None of them is part of the wheel.

{packages}
## Texts

"""


def linked_crates() -> list[dict[str, Any]]:
    """Return the crates of others that are part of the compiled core, by name."""
    command = [
        "cargo",
        "metadata",
        "--locked",
        "--format-version=1",
        f"--filter-platform={PLATFORM}",
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, check=True)
    known = json.loads(done.stdout)
    packages = {p["id"]: p for p in known["packages"]}
    nodes = {n["id"]: n for n in known["resolve"]["nodes"]}
    (root,) = (i for i, p in packages.items() if p["name"] == "locosweep-python")
    found, left = set(), [root]
    while left:
        one = left.pop()
        # What a macro needs runs in the compiler.
        macro = any("proc-macro" in t["kind"] for t in packages[one]["targets"])
        if one in found or macro:
            continue
        found.add(one)
        left += [
            d["pkg"] for d in nodes[one]["deps"] if any(k["kind"] is None for k in d["dep_kinds"])
        ]
    others = [packages[i] for i in found if packages[i]["source"]]
    return sorted(others, key=lambda p: (p["name"], p["version"]))


def texts(crates: list[dict[str, Any]]) -> list[str]:
    """Return the licence of every crate that is not offered under ours."""
    found = []
    for crate in crates:
        if OURS in crate["license"]:
            continue
        files = sorted(Path(crate["manifest_path"]).parent.glob("LICENSE*"))
        if not files:
            raise SystemExit(f"{crate['name']} has no text of its licence {crate['license']}")
        text = files[0].read_text("utf-8").strip()
        found.append(f"### {crate['name']}\n\n```text\n{text}\n```\n")
    return found


def licence_of(package: str) -> str:
    """Return what an installed package says of its licence."""
    said = importlib.metadata.metadata(package)
    if expression := said.get("License-Expression"):
        return str(expression)
    named = [c.split(" :: ")[-1] for c in said.get_all("Classifier", []) if "License ::" in c]
    return ", ".join(named) or str(said.get("License", "not stated")).split("\n")[0]


def page() -> str:
    """Return the whole page."""
    crates = linked_crates()
    lines = [["crate", "version", "licence"]]
    lines += [[c["name"], c["version"], c["license"].replace("/", " OR ")] for c in crates]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    names = [re.split(r"[<>=!~\[ ;]", needed)[0] for needed in project["dependencies"]]
    packages = [["package", "licence"], *([name, licence_of(name)] for name in names)]
    head = HEAD.format(platform=PLATFORM, crates=rows(lines), packages=rows(packages))
    return head + "\n".join(texts(crates))


def comparable(text: str) -> str:
    """Return a page without what other versions of the same Python packages say otherwise."""
    before, head, rest = text.partition("## Installed beside it")
    packages, texts_of, after = rest.partition("## Texts")
    names = re.sub(r"^(\| [\w-]+ \|).*$", r"\1", packages, flags=re.MULTILINE)
    return before + head + names + texts_of + after


def main() -> None:
    """Write or check the page."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing, fail if not current")
    check = parser.parse_args().check
    text = page()
    if check:
        if not PAGE.exists() or comparable(PAGE.read_text("utf-8")) != comparable(text):
            sys.exit("THIRD-PARTY.md is not current: run python benches/third_party.py")
    else:
        PAGE.write_text(text, "utf-8", newline="\n")


if __name__ == "__main__":
    main()
