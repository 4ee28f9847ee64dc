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

import numpy as np
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
    "Uncertainty": ["propagate", "Propagation", "sensitivity", "Sensitivity"],
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
        "locosweep.plot.run_folder.RunPlotter",
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

# The map of the paper's Figure 2 on the first page, with its friction on sliders.
LIVE = "figure-2.html"
LIVE_TEXT = f"""
## The paper's Figure 2, with its friction to choose

Mean velocity over the number of segments and the slope. The paper draws it for static friction 0.5
and Coulomb friction 0.3. With `anchor_weight` 0, anchors need not hold their own weight, which is
closer to its picture. Move the sliders, point at a cell, choose other axes:

```{{raw}} html
<iframe src="{LIVE}" title="Figure 2 of the paper, with sliders" class="live"></iframe>
```
"""


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


def write_live(source: Path) -> Path:
    """Write the page of Figure 2, show it on the first page, and return its folder."""
    axes = {
        "mu_static": np.arange(30, 95, 5) / 100, "mu_coulomb": np.arange(10, 65, 5) / 100,
        "anchor_weight": [1.0, 0.0], "slope_deg": np.arange(0.0, 31.0),
        "segments": np.arange(2.0, 21.0),
    }  # fmt: skip
    page = ls.sweep("mean_velocity", ls.Grid(**axes)).explore(mu_static=0.5, mu_coulomb=0.3)
    folder = source.with_name(f"{source.name}-live")
    folder.mkdir(exist_ok=True)
    page.save(folder / LIVE)
    index = source / "index.md"
    text = index.read_text("utf-8")
    place = text.index("\n## All pages\n")
    index.write_text(text[:place] + LIVE_TEXT + text[place:], "utf-8")
    return folder


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
    live = write_live(source)
    write_menu(source)
    write_api(source)
    shutil.rmtree(out, ignore_errors=True)
    extra = ["-D", "plot_gallery=0"] if given.pages_only else []
    extra += ["-D", f"html_extra_path={live}"]
    strict = ["-W", "--keep-going", "--quiet", *extra]
    code = sphinx(["-b", "html", "-c", str(SITE), *strict, str(source), str(out)])
    if code == 0:
        shutil.rmtree(out / ".doctrees", ignore_errors=True)
        shutil.rmtree(source)
        shutil.rmtree(live)
        print(f"the documentation is {out / 'index.html'}")
    return code


if __name__ == "__main__":
    sys.exit(main())
