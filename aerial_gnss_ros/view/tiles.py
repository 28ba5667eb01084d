# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Map tiles of an MBTiles file (version 1.3), which the user brings along."""

from __future__ import annotations

import sqlite3
from pathlib import Path
from typing import Any

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.text.sentences import cut

TYPES = {"png": "image/png", "jpg": "image/jpeg", "jpeg": "image/jpeg", "webp": "image/webp"}
DEEPEST = 24
_LONGEST = 200


class Tiles:
    """An MBTiles file with pictures, open for reading.

    Args:
        path: of the file.

    Attributes:
        type: MIME type of a tile.

    Raises:
        InputError: missing, no such file, or its tiles are no pictures.
    """

    def __init__(self, path: Path) -> None:
        if not path.is_file():
            raise InputError(f"there is no {path}; --tiles takes an MBTiles file.")
        try:
            self._file = sqlite3.connect(
                f"{path.resolve().as_uri()}?mode=ro", uri=True, check_same_thread=False
            )
            about = dict(self._file.execute("select name, value from metadata"))
            low, high = self._file.execute(
                "select min(zoom_level), max(zoom_level) from tiles"
            ).fetchone()
        except sqlite3.Error as error:
            raise InputError(
                f"{path} is no MBTiles file ({cut(str(error))}); --tiles takes raster tiles as "
                "QGIS or gdal_translate write them."
            ) from error
        kind = str(about.get("format", "")).lower()
        if kind not in TYPES:
            raise InputError(
                f"{path} holds tiles of format {cut(kind) or 'unknown'}; the page draws "
                f"{', '.join(TYPES)}."
            )
        if low is None:
            raise InputError(f"{path} holds no tiles.")
        if not (isinstance(low, int) and isinstance(high, int) and 0 <= low <= high <= DEEPEST):
            raise InputError(f"{path} has zoom levels {low} to {high}, not 0 to {DEEPEST}.")
        self.type = TYPES[kind]
        self._about, self._levels = about, (low, high)

    def description(self) -> dict[str, Any]:
        """Return what the page must know: levels, and whom to name."""
        return {
            "lowest": self._levels[0],
            "highest": self._levels[1],
            "attribution": str(self._about.get("attribution", ""))[:_LONGEST],
        }

    def tile(self, zoom: int, column: int, row: int) -> bytes | None:
        """Return a tile's picture, None if the file lacks it.

        Args:
            zoom: level.
            column: from the date line to the east.
            row: from the north, as web pages count; the file counts from the south.
        """
        if not (0 <= zoom <= DEEPEST and 0 <= row < 2**zoom):
            return None
        try:
            found = self._file.execute(
                "select tile_data from tiles where zoom_level = ? and tile_column = ? and "
                "tile_row = ?",
                (zoom, column, 2**zoom - 1 - row),
            ).fetchone()
        except sqlite3.Error:  # damaged: as if it were not there
            return None
        return found[0] if found and isinstance(found[0], bytes) else None

    def close(self) -> None:
        """Close the file."""
        self._file.close()
