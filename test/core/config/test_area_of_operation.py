# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""GeoJSON as other programs write it, and one sentence for each thing that is wrong in it."""

from __future__ import annotations

import json

import numpy as np
import pytest

from aerial_gnss_ros.core.config.area_of_operation import polygons_from_geojson
from aerial_gnss_ros.core.values.errors import ConfigError

SQUARE = [[10.0, 54.0], [10.1, 54.0], [10.1, 54.1], [10.0, 54.1], [10.0, 54.0]]
HOLE = [[10.02, 54.02], [10.02, 54.04], [10.04, 54.04], [10.02, 54.02]]


def polygon(*rings):
    return {"type": "Polygon", "coordinates": list(rings)}


def feature(geometry):
    return {"type": "Feature", "properties": {}, "geometry": geometry}


@pytest.mark.parametrize(
    ("document", "rings"),
    [
        (polygon(SQUARE), [1]),
        (polygon(SQUARE[:-1]), [1]),  # not closed, as some write it by hand
        (feature(polygon(SQUARE, HOLE)), [2]),
        ({"type": "FeatureCollection", "features": [feature(polygon(SQUARE)), feature(None)]}, [1]),
        ({"type": "MultiPolygon", "coordinates": [[SQUARE], [SQUARE, HOLE]]}, [1, 2]),
        ({"type": "GeometryCollection", "geometries": [polygon([[*p, 7.0] for p in SQUARE])]}, [1]),
    ],
)
def test_reads_polygons_wherever_they_stand(document, rings):
    found = polygons_from_geojson(json.dumps(document))
    assert [len(one) for one in found] == rings
    for one in found:
        assert one[0].tolist() == SQUARE[:-1]


def test_goes_on_across_the_antimeridian():
    ring = [[179.99, -17.0], [-179.99, -17.0], [-179.99, -16.99], [179.99, -16.99]]
    (found,) = polygons_from_geojson(json.dumps(polygon(ring)))
    assert np.ptp(found[0][:, 0]) == pytest.approx(0.02)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("{", r"is not JSON \("),
        ("[" * 100_000, r"is not JSON \("),
        ("{}", r"\{\} has no type"),
        ('{"type": "Point", "coordinates": [10, 54]}', r"holds a Point; only polygons count"),
        (json.dumps(feature(None)), "holds no polygon; draw one"),
        (json.dumps(polygon()), r"\[\] stands where a list with content belongs"),
        (json.dumps(polygon(SQUARE[:2])), "with 2 different corners; it needs at least 3"),
        (json.dumps(polygon([["a", 1], *SQUARE])), r"corner \['a', 1\]; give \[longitude, lati"),
        (json.dumps(polygon([[float("nan"), 1], *SQUARE])), r"corner \[nan, 1\]"),
        (json.dumps(polygon([[10**400, 1], *SQUARE])), r"corner \["),
        (
            json.dumps(polygon([[13.19, -159.6], [13.2, -159.6], [13.2, -159.5]])),
            "latitude and longitude are swapped: GeoJSON has longitude first",
        ),
        (
            json.dumps(polygon([[512345.0, 5987654.0], [512445.0, 5987654.0], [512445.0, 5.9e6]])),
            r"not in degrees; export it in WGS84 \(EPSG:4326\)",
        ),
        (
            json.dumps(polygon([SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]])),
            r"crosses itself, beside longitude 10, latitude 54;",
        ),
        (
            json.dumps(polygon(SQUARE, [[p[0] + 0.05, p[1] + 0.05] for p in SQUARE])),
            "crosses itself",
        ),
        (json.dumps(polygon([[10, 54], [14, 54], [14, 55]])), "over 4 degrees of longitude"),
        (json.dumps(polygon([[10, 54], [10.1, 54], [10.1, 57]])), "and 3 of latitude"),
        (
            json.dumps(polygon([[10 + 1e-6 * i, 54 + 1e-6 * (i % 2)] for i in range(2001)])),
            "has 2001 corners, more than 2000; simplify it",
        ),
    ],
)
def test_says_what_is_wrong_in_a_sentence(text, sentence):
    with pytest.raises(ConfigError, match=sentence) as refused:
        polygons_from_geojson(text)
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < 400
