# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sphinx configuration: `make docs` builds the site into build/docs/html."""

import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE / "_ext"), str(HERE.parent / "tools"), str(HERE.parent)]

import reference_pages  # noqa: E402

reference_pages.write(HERE / "reference")

project = "aerial_gnss_ros"
author = "aerial_gnss_ros developers"
copyright = f"2026 {author}"  # noqa: A001 - Sphinx's own name
release = re.findall(r"<version>(.*?)</version>", (HERE.parent / "package.xml").read_text())[0]

extensions = ["myst_parser", "mathml"]
exclude_patterns = ["_ext"]
nitpicky = True
myst_enable_extensions = ["dollarmath", "deflist"]
myst_dmath_double_inline = True
myst_heading_anchors = 4
html_math_renderer = "mathml"

html_theme = "furo"
html_title = f"{project} {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_baseurl = ""
