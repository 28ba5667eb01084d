# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads users' text files: bounded in size and UTF-8, else reported in one sentence."""

from __future__ import annotations

from pathlib import Path

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.text.sentences import cut

_MEGABYTE = 1_000_000


def read_text(path: Path, most_bytes: int) -> str:
    """Return a text file; a byte order mark at its start is left out.

    Args:
        path: the file.
        most_bytes: size limit; a larger file is refused.

    Raises:
        InputError: the file cannot be read, is larger, or is not UTF-8; the line is named.
    """
    try:
        with path.open("rb") as file:
            content = file.read(most_bytes + 1)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}.") from error
    except ValueError as error:  # a NUL in its name
        raise InputError(f"{cut(str(path))}: cannot be read: {error}.") from error
    if len(content) > most_bytes:
        raise InputError(
            f"{path}: is larger than {most_bytes / _MEGABYTE:g} MB, the limit for such a file; "
            "check that it is the right one."
        )
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(f"{path}: is not text in UTF-8 (line {line}); save it as such.") from error
