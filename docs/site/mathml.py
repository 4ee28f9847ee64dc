"""Formulas as MathML: browsers draw it themselves, without a script, a font or a network."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from docutils import nodes
from latex2mathml.converter import convert

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.writers.html5 import HTML5Translator

# Names of functions, which stand apart from their neighbours as an operator does.
_FUNCTION = re.compile(r"<mi>(sin|cos|tan|tanh|sgn|max|min|exp|ln)</mi>|<mi[^>]*>sgn</mi>")
# What a code host reads as a formula within a line.
_INLINE = re.compile(r"\$`([^`\n]+)`\$")


def mathml(tex: str, *, block: bool) -> str:
    """Return a formula in LaTeX as MathML.

    Raises
    ------
    ValueError
        A command that has no form in MathML.
    """
    found = convert(tex.strip(), display="block" if block else "inline")
    if "\\" in re.sub(r"<annotation.*?</annotation>", "", found):
        raise ValueError(f"no MathML for {tex!r}")
    return _FUNCTION.sub(
        lambda m: f'<mo lspace="0.17em" rspace="0.17em">{m[1] or "sgn"}</mo>', found
    )


def _inline(self: HTML5Translator, node: nodes.math) -> None:
    self.body.append(mathml(node.astext(), block=False))
    raise nodes.SkipNode


def _block(self: HTML5Translator, node: nodes.math_block) -> None:
    # A long formula scrolls within its own box, by keyboard too.
    formula = mathml(node.astext(), block=True)
    self.body.append(f'<div class="formula" tabindex="0" role="math">{formula}</div>\n')
    raise nodes.SkipNode


def _roles(_app: Sphinx, _name: str, source: list[str]) -> None:
    """Turn the formulas of a code host into those of MyST."""
    source[0] = _INLINE.sub(r"{math}`\1`", source[0])


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    app.config.html_math_renderer = "mathml"  # type: ignore[attr-defined]
    app.connect("source-read", _roles)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
