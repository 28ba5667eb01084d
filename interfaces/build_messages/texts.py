# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Finds the message texts, which the main package holds: it registers them for bags, too."""

from __future__ import annotations

from pathlib import Path

SOURCE = Path("aerial_gnss_ros") / "bags" / "msg"  # in the repository that holds interfaces/


def read(here: Path) -> dict[str, list[Path]]:
    """Return the .msg files of each package, in alphabetical order.

    Args:
        here: The folder interfaces/ of a whole source tree.

    Raises:
        SystemExit: interfaces/ was taken out of its repository.
    """
    folder = here.parent / SOURCE
    packages = {path.name: sorted(path.glob("msg/*.msg")) for path in sorted(folder.glob("*_msgs"))}
    if not packages:
        raise SystemExit(
            f"the message texts are missing: expected {folder}/<package>/msg/*.msg. "
            "Install interfaces/ from a whole copy of the repository."
        )
    return packages
