# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads the area of operation: GeoJSON in a file or in the parameter itself."""

from __future__ import annotations

from aerial_gnss_ros.core.config.area_of_operation import Polygon, polygons_from_geojson
from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.core.values.paths import typed_path

MAX_BYTES = 1_000_000


def load_area(area: str) -> tuple[Polygon, ...]:
    """Return the polygons of `detections.area`; none if it is empty.

    Args:
        area: a path, or the text itself, which begins with a brace.

    Raises:
        ConfigError: the file is unreadable or has no valid area.
    """
    if not area.strip():
        return ()
    if area.lstrip().startswith("{"):
        return polygons_from_geojson(area)
    path = typed_path(area)
    try:
        with path.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
        text = content.decode("utf-8-sig")
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or "it is no text"
        raise ConfigError(
            f"detections.area is {area}, which cannot be read ({why}); give the path of a "
            "GeoJSON file."
        ) from error
    if len(content) > MAX_BYTES:
        raise ConfigError(
            f"detections.area {area} is larger than {MAX_BYTES // 1_000_000} MB; simplify it."
        )
    try:
        return polygons_from_geojson(text)
    except ConfigError as error:
        raise ConfigError(f"detections.area {area}: {error}") from error
