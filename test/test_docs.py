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


UNTRACKED = ROOT / "docs" / "reference" / "commands.md"
"""`make docs` writes it; a checkout does not have it."""
PAGES = [page for page in _files(".md") if page != UNTRACKED]


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
        there = goal.exists() and goal != UNTRACKED
        assert there, f"{page.relative_to(ROOT)}: no {target}"
        assert not anchor or anchor in _anchors(goal), f"{page.relative_to(ROOT)}: no {target}"


def test_every_page_named_in_code_or_configuration_exists() -> None:
    for file in _files(".py", ".yaml", ".xml", ".md", ".html", ".msg"):
        for name in re.findall(r"\bdocs/[\w/]+\.md", file.read_text(encoding="utf-8")):
            exists = Path(name).stem.isupper() or (ROOT / name).is_file()
            assert exists, f"{file.relative_to(ROOT)} names {name}"


DOCS = [page for page in PAGES if (ROOT / "docs") in page.parents or page.parent == ROOT]
FOLDERS = "aerial_gnss_ros|benchmarks|config|docs|fuzz|launch|models|test|tools"
PARTS = "|".join(path.name for path in (ROOT / "aerial_gnss_ros").iterdir() if path.is_dir())


def _ids(page: Path) -> str:
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", DOCS, ids=_ids)
def test_every_file_that_a_page_names_exists(page: Path) -> None:
    """Paths from the root of the repository, or from that of the package."""
    text = page.read_text(encoding="utf-8")
    for name in re.findall(
        rf"(?<![\w/.])((?:{FOLDERS}|{PARTS})/[\w/]+\.(?:py|md|yaml|xml))\b", text
    ):
        places = (ROOT / name, ROOT / "aerial_gnss_ros" / name, page.parent / name)
        placeholder = Path(name).stem.isupper()  # PAGE.md stands for any page
        assert placeholder or any(place.is_file() for place in places), name
    for name in re.findall(r"python3? (?:-m )?(benchmarks/\w+\.py|aerial_gnss_ros[\w.]+)", text):
        path = name if name.endswith(".py") else name.replace(".", "/") + ".py"
        assert (ROOT / path).is_file(), name


@pytest.mark.parametrize("page", DOCS, ids=_ids)
def test_lines_are_short_enough_to_read(page: Path) -> None:
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), start=1):
        assert len(line) <= 120 or line.lstrip().startswith("|"), f"line {number}: {len(line)}"


@pytest.mark.parametrize("page", DOCS, ids=_ids)
def test_pages_say_what_is_and_not_what_was(page: Path) -> None:
    """Hashes of commits and comparisons with an earlier state belong into the changelog."""
    text = page.read_text(encoding="utf-8")
    found = re.findall(r"\b(?=[0-9a-f]*[a-f])(?=[0-9a-f]*[0-9])[0-9a-f]{7,12}\b", text)
    assert not found, found
    assert not re.findall(r"\bcommit [0-9a-f]{7}", text)


def test_every_measured_place_has_date_version_and_command() -> None:
    places = 0
    for page in (ROOT / "docs" / "results").glob("*.md"):
        text = page.read_text(encoding="utf-8")
        for name in re.findall(r"^<!-- (?!end of )(.*?) -->$", text, flags=re.MULTILINE):
            begin, end = text.index(f"<!-- {name} -->"), text.index(f"<!-- end of {name} -->")
            measured = text[begin:end]
            assert re.search(r"Measured \d{4}-\d\d-\d\d\b", measured), f"{page.name}: {name}"
            assert re.search(r"version \d+\.\d+\.\d+", measured), f"{page.name}: {name}"
            assert name.split()[0] in measured, f"{page.name}: {name}"
            places += 1
    assert places > 8


EQUATIONS = ("filter", "geometry", "association", "identity", "latency", "failures")


@pytest.mark.parametrize(
    "page", [*(f"explanation/{name}" for name in EQUATIONS), "reference/glossary"]
)
def test_equations_use_the_names_of_the_code(page: str) -> None:
    """A name in backticks is one of the code, of its parameters or of its file formats."""
    sources = _files(".py", ".yaml")
    words = {word for path in sources for word in re.findall(r"\w+", path.read_text("utf-8"))}
    text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
    for name in re.findall(r"`([A-Za-z_][\w.]*)`", text):
        unknown = [word for word in name.split(".") if word and word not in words]
        assert not unknown, f"{name}: nothing is called {unknown[0]}"
