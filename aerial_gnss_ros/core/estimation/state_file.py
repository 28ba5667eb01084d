# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Keeps robots' labels in a file over a restart, such as a change of batteries."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from aerial_gnss_ros.core.identity.labels import Labels
from aerial_gnss_ros.core.identity.saved_labels import SavedNames, from_text, to_text
from aerial_gnss_ros.core.values.errors import ConfigError, OutputError
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.core.values.events import Events

SAVE_EVERY_NS, SESSION_EVERY_NS = 10_000_000_000, 1_000_000_000
MOST_BYTES = 10_000_000
"""Size limit of the file: fifty thousand labels."""


class NameKeeper:
    """Saves labels when a robot is new, and periodically; a failure is reported once.

    Args:
        path: of the file; empty: nothing is kept.
        log: receives failures.
        session: file for a restart within this session, used if `path` is empty: it is written more
            often, need not survive a loss of power, and is ignored if damaged.
    """

    def __init__(self, path: str, log: Events, session: Path | None = None) -> None:
        self._path = Path(path) if path else session
        self._session = not path
        self._every_ns = SESSION_EVERY_NS if self._session else SAVE_EVERY_NS
        self._log = log
        self._saved_ids: set[str] = set()
        self._saved_ns: int | None = None

    def load(self) -> SavedNames:
        """Return the saved labels.

        Raises:
            ConfigError: the file is damaged or its folder is missing.
        """
        if self._path is None:
            return SavedNames()
        try:
            return load(self._path)
        except ConfigError as error:
            if not self._session:
                raise
            self._log.warn_once("session", f"Labels from before the restart are lost: {error}")
            return SavedNames()

    def keep(self, result: FrameResult, identity: Labels, shift_ns: int = 0) -> None:
        """Save if a result's robots make it due.

        Args:
            result: of the last image.
            identity: has the labels.
            shift_ns: time less stamps, see `Identity.saved`.
        """
        if self._path is None:
            return
        stamp_ns = result.stamp_ns
        ids = {estimate.robot_id for estimate in result.estimates}
        due = self._saved_ns is None or stamp_ns - self._saved_ns >= self._every_ns
        if ids - self._saved_ids or (ids and due):
            self._saved_ids |= ids
            self._saved_ns = stamp_ns
            self.save(identity, shift_ns)

    def save(self, identity: Labels, shift_ns: int = 0) -> None:
        """Save now (see `keep`)."""
        if self._path is None:
            return
        try:
            save(self._path, identity.saved(shift_ns), durable=not self._session)
        except OutputError as error:
            self._log.warn_once("state_file", str(error))

    def reset(self) -> None:
        """Reset the time of the last save: the clock went backward."""
        self._saved_ns = None


def load(path: Path) -> SavedNames:
    """Return the labels in a file; none if there is no file yet.

    Raises:
        ConfigError: the file is damaged or cannot be read, or its folder does not exist.
    """
    if not path.parent.is_dir():
        raise ConfigError(
            f"state_file is {path}, but the folder {path.parent} does not exist; create it first."
        )
    try:
        with path.open("rb") as stream:
            content = stream.read(MOST_BYTES + 1)
        text = content.decode("utf-8")
    except FileNotFoundError:
        return SavedNames()
    except (OSError, UnicodeDecodeError) as error:
        why = getattr(error, "strerror", None) or "it is no text"
        raise ConfigError(
            f"state_file {path} cannot be read ({why}); check the file, or name another."
        ) from error
    if len(content) > MOST_BYTES:
        raise ConfigError(
            f"state_file {path} is larger than {MOST_BYTES // 1_000_000} MB, so this program did "
            "not write it; name another file."
        )
    return from_text(text, str(path))


def save(path: Path, saved: SavedNames, *, durable: bool = True) -> None:
    """Write the labels atomically: either the old file or the new one is complete.

    Args:
        path: of the file.
        saved: the labels.
        durable: wait for the disk, so that they survive a loss of power.

    Raises:
        OutputError: the file cannot be written; the old one is unchanged.
    """
    partial = path.with_name(f".{path.name}.partial")
    try:
        with partial.open("w", encoding="utf-8") as stream:
            stream.write(to_text(saved))
            stream.flush()
            if durable:
                os.fsync(stream.fileno())  # batteries are removed without a shutdown
        partial.replace(path)
    except OSError as error:
        with contextlib.suppress(OSError):
            partial.unlink()
        raise OutputError(
            f"state_file {path} cannot be written ({error.strerror}); labels will not survive a "
            "restart."
        ) from error
