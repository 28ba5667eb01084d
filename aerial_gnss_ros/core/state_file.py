# SPDX-License-Identifier: Apache-2.0
"""Keeps robots' names in a file over a restart, such as a change of batteries."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from aerial_gnss_ros.core.errors import ConfigError, OutputError
from aerial_gnss_ros.core.saved_names import SavedNames, from_text, to_text


def load(path: Path) -> SavedNames:
    """Return the names in a file; none where there is no file yet.

    Raises:
        ConfigError: the file is damaged or cannot be read, or its folder does not exist.
    """
    if not path.parent.is_dir():
        raise ConfigError(
            f"state_file is {path}, but the folder {path.parent} does not exist; make it first."
        )
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return SavedNames()
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError(f"state_file {path} cannot be read ({error}); see what it is.") from error
    return from_text(text, str(path))


def save(path: Path, saved: SavedNames) -> None:
    """Write the names so that the old file or the new one is whole, whatever happens.

    Raises:
        OutputError: the file cannot be written; the old one is untouched.
    """
    partial = path.with_name(f".{path.name}.partial")
    try:
        with partial.open("w", encoding="utf-8") as stream:
            stream.write(to_text(saved))
            stream.flush()
            os.fsync(stream.fileno())  # batteries are pulled without a shutdown
        partial.replace(path)
    except OSError as error:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise OutputError(
            f"state_file {path} cannot be written ({error.strerror}); names will not outlive "
            "the program."
        ) from error
