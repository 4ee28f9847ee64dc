"""Build the documentation site: pages of docs/, the gallery, and a reference from docstrings.

    python docs/site/build.py --out out/docs [--pages-only]

Pages are those that a code host shows too. They are laid side by side in OUT/source, so that every
link from one to another holds, and get their place in the menu here. A warning is an error.
"""

from __future__ import annotations

import argparse
import re
import shutil
import sys
from pathlib import Path

from sphinx.cmd.build import main as sphinx

import locosweep as ls

SITE = Path(__file__).resolve().parent
ROOT = SITE.parents[1]

# The menu: what stands below a page. Every page has to be in it, which Sphinx checks.
MENU = {
    "index": [
        "Install <install>",
        "size-a-robot",
        "sweep-big",
        "diagnose-runs",
        "Decide <decide-under-uncertainty>",
        "Gallery <gallery/index>",
        "reference",
        "How it works <how-it-works>",
    ],
    "size-a-robot": ["sweeps", "simulation"],
    "sweep-big": ["run-folders", "cluster"],
    "diagnose-runs": [
        "your-data",
        "reading-a-report",
        "diagnosis",
        "friction",
        "pendulum",
        "practice",
    ],
    "reference": [
        "Python <api/index>",
        "command-line",
        "quantities",
        "laws",
        "effects",
        "parameters",
        "Changelog <CHANGELOG>",
        "Third-party licences <THIRD-PARTY>",
    ],
    "how-it-works": [
        "accuracy",
        "speed",
        "blind-check",
        "Benches <benches/README>",
        "Contributing <CONTRIBUTING>",
        "Security <SECURITY>",
    ],
}

# Sections of the reference of the package. A public name that is missing ends the build.
API = {
    "Sweeps": ["sweep", "Grid", "Result", "load", "Spec"],
    "Large sweeps": ["open_run", "Run", "open_grid"],
    "Simulation": ["simulate", "Trajectories", "run_gait", "GaitRun", "GaitSpec"],
    "Diagnosis": [
        *("diagnose", "Diagnosis", "distinguish", "Distinction", "fit_friction", "FrictionFit"),
    ],
    "Robots": ["load_robot", "Robot"],
    "Registry": [
        *("quantities", "parameters", "laws", "drives", "effects", "gaits", "methods"),
        "reductions",
        *("Quantity", "Parameter", "Law", "Drive", "Status"),
    ],
    "Errors and cancelling": [
        *("LocosweepError", "InputError", "DataFileError", "SolveError", "InternalError"),
        *("Cancelled", "CancelToken"),
    ],
}  # fmt: skip
# Public names of rooms, under the paths that scripts import.
MORE = {
    "Pictures": [
        "locosweep.plot.heatmap.Plotter",
        "locosweep.plot.motion",
        "locosweep.plot.characteristic",
        "locosweep.plot.behaviour",
        "locosweep.plot.gait.space_time",
        "locosweep.plot.gait.joint_forces",
        "locosweep.plot.save_figure",
    ],
    "Measured runs": [
        "locosweep.measured.load_runs",
        "locosweep.measured.Run",
        "locosweep.replay.replay_runs",
        "locosweep.diagnosis.screen",
        "locosweep.intake.log.read_log",
    ],
}


def lay_out(source: Path) -> None:
    """Copy all pages, with what they show and link to, into one folder."""
    shutil.rmtree(source, ignore_errors=True)
    source.mkdir(parents=True)
    for page in (ROOT / "docs").glob("*.md"):
        name = "index.md" if page.name == "README.md" else page.name
        # What a page of docs/ finds above itself lies beside it here.
        (source / name).write_text(page.read_text("utf-8").replace("](../", "]("), "utf-8")
    for picture in (ROOT / "docs").glob("*.png"):
        shutil.copy(picture, source)
    for name in (
        *("CONTRIBUTING.md", "CHANGELOG.md", "SECURITY.md", "THIRD-PARTY.md", "LICENSE-APACHE"),
        "benches/README.md",
    ):
        text = (ROOT / name).read_text("utf-8")
        target = source / name
        target.parent.mkdir(exist_ok=True)
        target.write_text(re.sub(r"\]\((\.\./)?docs/", r"](\1", text), "utf-8")
    (source / "examples").mkdir()
    for example in (ROOT / "examples").glob("*.toml"):
        shutil.copy(example, source / "examples")
    shutil.copytree(ROOT / "examples" / "gallery", source / "examples" / "gallery")
    shutil.copy(SITE / "reference.md", source)


def write_menu(source: Path) -> None:
    """Give every page of the menu its entries."""
    for page, entries in MENU.items():
        lines = ["", "```{toctree}", ":hidden:", "", *entries, "```", ""]
        with (source / f"{page}.md").open("a", encoding="utf-8") as file:
            file.write("\n".join(lines))


def write_api(source: Path) -> None:
    """Write the overview of the package; Sphinx fills it from docstrings."""
    listed = [name for names in API.values() for name in names]
    missing = set(ls.__all__) - {"__version__"} ^ set(listed)
    if missing or len(listed) > len(set(listed)):
        raise SystemExit(f"{__file__}: API has to name every public name once: {sorted(missing)}")
    text = "Python package\n==============\n\nAll names of ``import locosweep as ls``.\n"
    groups = {head: [f"locosweep.{name}" for name in names] for head, names in API.items()}
    for head, names in (groups | MORE).items():
        text += f"\n{head}\n{'-' * len(head)}\n\n"
        text += ".. autosummary::\n   :toctree: .\n   :nosignatures:\n\n"
        text += "".join(f"   {name}\n" for name in names)
    (source / "api").mkdir()
    (source / "api" / "index.rst").write_text(text, "utf-8")


def main(words: list[str] | None = None) -> int:
    """Build the site and return the exit code of Sphinx."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument(
        "--out", type=Path, default=ROOT / "out" / "docs", help="folder of the site"
    )
    parser.add_argument(
        "--pages-only", action="store_true", help="do not run the scripts of the gallery"
    )
    given = parser.parse_args(words)
    out = given.out.resolve()
    source = out.parent / f"{out.name}-source"
    lay_out(source)
    write_menu(source)
    write_api(source)
    shutil.rmtree(out, ignore_errors=True)
    extra = ["-D", "plot_gallery=0"] if given.pages_only else []
    strict = ["-W", "--keep-going", "--quiet", *extra]
    code = sphinx(["-b", "html", "-c", str(SITE), *strict, str(source), str(out)])
    if code == 0:
        shutil.rmtree(out / ".doctrees", ignore_errors=True)
        shutil.rmtree(source)
        print(f"the documentation is {out / 'index.html'}")
    return code


if __name__ == "__main__":
    sys.exit(main())
