# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What documentation points at exists: files, headings, modules, commands of the repository."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def _files(*suffixes: str) -> list[Path]:
    """Files of the repository, without what is built or installed."""
    folders = ("aerial_gnss_ros", "benchmarks", "config", "docs", "fuzz", "interfaces", "models")
    found = [path for path in ROOT.iterdir() if path.is_file()]
    for folder in (*folders, "launch", "test", "tools"):
        found += (path for path in (ROOT / folder).rglob("*") if "build" not in path.parts)
    return sorted(path for path in found if path.suffix in suffixes)


PAGES = _files(".md")
GENERATED = {f"docs/reference/{name}.md" for name in ("commands", "files", "parameters", "topics")}
"""`make docs` writes these, and checks links to them."""


@cache
def _anchors(page: Path) -> frozenset[str]:
    """Anchors of a page's headings, named as GitHub and MyST name them."""
    text = page.read_text(encoding="utf-8")
    text = re.sub(r"^(```|~~~).*?^\1", "", text, flags=re.MULTILINE | re.DOTALL)
    heads = re.findall(r"^#+ (.*)$", text, flags=re.MULTILINE)
    slugs = (re.sub(r"[^\w\- ]", "", head.lower()).strip().replace(" ", "-") for head in heads)
    return frozenset(slugs)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_to_a_file_and_a_heading(page: Path) -> None:
    for target in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        goal = (page.parent / path).resolve() if path else page
        if str(goal.relative_to(ROOT)) in GENERATED:
            continue
        assert goal.exists(), f"{page.relative_to(ROOT)}: no {target}"
        assert not anchor or anchor in _anchors(goal), f"{page.relative_to(ROOT)}: no {target}"


def test_every_page_named_in_code_or_configuration_exists() -> None:
    for file in _files(".py", ".yaml", ".xml", ".md", ".html", ".msg"):
        for name in re.findall(r"\bdocs/[\w/]+\.md", file.read_text(encoding="utf-8")):
            assert name in GENERATED or (ROOT / name).is_file(), (
                f"{file.relative_to(ROOT)} names {name}"
            )
