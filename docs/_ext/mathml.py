# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Renders equations as MathML when the site is built: browsers show it without any script.

Sphinx's own renderers load MathJax from a network or need LaTeX. docutils brings a converter.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from docutils.nodes import SkipNode, math, math_block
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util import logging

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.writers.html5 import HTML5Translator

LOGGER = logging.getLogger(__name__)


def _mathml(node: math | math_block) -> str:
    try:
        return tex2mathml(node.astext(), as_block=isinstance(node, math_block))
    except MathError as error:
        LOGGER.warning("equation: %s", error, location=node)
        return ""


def _inline(translator: HTML5Translator, node: math) -> None:
    translator.body.append(_mathml(node))
    raise SkipNode


def _display(translator: HTML5Translator, node: math_block) -> None:
    translator.body.append(f'<div class="equation">{_mathml(node)}</div>')
    raise SkipNode


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer `mathml`."""
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
