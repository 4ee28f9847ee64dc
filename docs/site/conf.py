"""Settings of the documentation site. `docs/site/build.py` gathers the pages and calls Sphinx."""

import re
import sys
import tomllib
import warnings
from pathlib import Path

from sphinx.application import Sphinx

SITE = Path(__file__).parent
ROOT = SITE.parents[1]
DOORS = ("size", "sweep", "diagnose", "decide")
sys.path.insert(0, str(SITE))

project = "locosweep"
author = "The locosweep developers"
copyright = "The locosweep developers, Apache-2.0 or MIT"  # noqa: A001
release = version = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"][
    "version"
]

# Two classes are called Run: a sweep in a folder, and a measured run.
suppress_warnings = ["ref.python"]
extensions = [
    "accessible",
    "mathml",
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["examples/**"]
templates_path = [str(SITE / "templates")]

myst_enable_extensions = ["attrs_block", "colon_fence"]
myst_heading_anchors = 4
myst_fence_as_directive = ["math"]

autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
autosummary_generate = True

sphinx_gallery_conf = {
    "examples_dirs": ["examples/gallery"],
    "gallery_dirs": ["gallery"],
    "filename_pattern": r"\.py$",
    "within_subsection_order": "FileNameSortKey",
    "subsection_order": [f"examples/gallery/{name}" for name in DOORS],
    "abort_on_example_error": False,
    "only_warn_on_example_error": True,
    "download_all_examples": True,
    "show_memory": False,
    "show_signature": False,
    "write_computation_times": False,
    "min_reported_time": 0,
    "parallel": False,
    "remove_config_comments": True,
    "notebook_images": False,
    "reference_url": {"locosweep": None},
    "doc_module": ("locosweep",),
    "backreferences_dir": None,
}
# A script of the gallery has no screen, and says so to nobody.
warnings.filterwarnings("ignore", message="FigureCanvasAgg is non-interactive")

html_theme = "pydata_sphinx_theme"
html_title = "locosweep"
html_static_path = [str(SITE / "static")]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
# A summary of a hit is fetched, which pages opened from a disk may not do.
html_show_search_summary = False
html_context = {"default_mode": "auto"}
html_theme_options = {
    "navbar_align": "left",
    "header_links_before_dropdown": 7,
    "navigation_with_keys": False,
    "show_prev_next": False,
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
html_sidebars = {"index": []}


def _join_names(
    _app: object, _what: str, _name: str, _obj: object, _options: object, lines: list[str]
) -> None:
    """Write attributes that share a line without spaces, before which Sphinx looks for a type."""
    for i, line in enumerate(lines):
        if found := re.match(r":(ivar|vartype) (\w+(?:, \w+)+):", line):
            lines[i] = f":{found[1]} {found[2].replace(', ', ',')}:{line[found.end() :]}"


def setup(app: Sphinx) -> None:
    """Register what docstrings need behind napoleon."""
    app.connect("autodoc-process-docstring", _join_names, priority=600)
