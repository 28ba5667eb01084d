# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Atomic results: written under a temporary name beside the final one, then renamed."""

from __future__ import annotations

import errno
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from aerial_gnss_ros.core.values.errors import OutputError


@contextmanager
def partial(final: Path) -> Iterator[Path]:
    """Yield the temporary path of a result that gets its final name when the block succeeds.

    The path is `.NAME.partial/NAME` beside it, on the same disk. The caller creates the file or
    folder. On any error, including an interrupt, it is removed.

    Args:
        final: the result; must not exist.

    Raises:
        OutputError: it exists already, its folder cannot be written, or the disk is full.
    """
    refuse_existing(final)
    hidden = final.parent / f".{final.name}.partial"
    with _disk_errors(final):
        shutil.rmtree(hidden, ignore_errors=True)  # left by a killed run
        hidden.mkdir(parents=True)
    try:
        with _disk_errors(final):
            yield hidden / final.name
            refuse_existing(final)
            (hidden / final.name).rename(final)
    finally:
        shutil.rmtree(hidden, ignore_errors=True)


def refuse_existing(final: Path) -> None:
    """Raise OutputError if a result would overwrite something."""
    if final.exists() or final.is_symlink():
        raise OutputError(f"{final} exists already; choose another name or remove it.")


def _asked_for(final: Path) -> Path:
    """Return the result that the user named: a bag may be inside a partial folder."""
    for folder in final.parents:
        if folder.name.startswith(".") and folder.name.endswith(".partial"):
            return _asked_for(folder.parent / folder.name[1 : -len(".partial")])
    return final


@contextmanager
def _disk_errors(final: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        final = _asked_for(final)
        if error.errno == errno.ENOSPC:
            raise OutputError(
                f"the disk is full: {final} could not be written and was removed; free some space "
                "or choose another folder."
            ) from error
        raise OutputError(f"{final} cannot be written: {error.strerror or error}.") from error
