"""What the theme leaves out for readers who do not see: names of controls that only show a sign."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sphinx.application import Sphinx

# The switch that opens a part of the menu.
_SWITCH = '<summary><span class="toctree-toggle"'
_NAMED = '<summary aria-label="Pages below"><span class="toctree-toggle"'


def _name_switches(app: Sphinx, fault: Exception | None) -> None:
    if fault is not None or app.builder.format != "html":
        return
    for page in Path(app.outdir).rglob("*.html"):
        text = page.read_text("utf-8")
        if _SWITCH in text:
            page.write_text(text.replace(_SWITCH, _NAMED), "utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the step behind the build."""
    app.connect("build-finished", _name_switches)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
