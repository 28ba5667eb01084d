# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Every source file says whose it is and under which licence: two lines at its head.

python tools/headers.py            # names files that lack them, status 1
python tools/headers.py --write    # puts them there
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
COPYRIGHT = "# Copyright 2026 aerial_gnss_ros developers\n"
LICENCE = "# SPDX-License-Identifier: Apache-2.0\n"
FOLDERS = (
    "aerial_gnss_ros", "benchmarks", "docs", "fuzz", "interfaces", "launch", "test", "tools",
)  # fmt: skip
MADE = {"build", "install", "log", "__pycache__"}


def sources(root: Path) -> Iterator[Path]:
    """Yield the Python files of the repository, in order."""
    yield root / "setup.py"
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*.py")):
            inside = path.relative_to(root).parts
            if not any(part in MADE or part.endswith(".egg-info") for part in inside):
                yield path


def headed(text: str) -> str:
    """Return a source with both lines at its head."""
    shebang, rest = "", text
    if text.startswith("#!"):
        shebang, _, rest = text.partition("\n")
        shebang += "\n"
    for line in (COPYRIGHT, LICENCE):
        rest = rest.removeprefix(line)
    return shebang + COPYRIGHT + LICENCE + rest


def main() -> int:
    """Check, or write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="put the lines where they are missing")
    given = parser.parse_args()
    missing = 0
    for path in sources(ROOT):
        text = path.read_text(encoding="utf-8")
        wanted = headed(text)
        if text == wanted:
            continue
        missing += 1
        if given.write:
            path.write_text(wanted, encoding="utf-8")
        else:
            print(f"{path.relative_to(ROOT)}: no copyright and licence line at its head")
    if missing and not given.write:
        print("python tools/headers.py --write puts them there")
    return int(missing > 0 and not given.write)


if __name__ == "__main__":
    sys.exit(main())
