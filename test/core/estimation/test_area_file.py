# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The area of operation from a file or the parameter itself; one sentence where it is none."""

from __future__ import annotations

import json

import pytest

from aerial_gnss_ros.core.estimation.area_file import MAX_BYTES, load_area
from aerial_gnss_ros.core.values.errors import ConfigError

TEXT = json.dumps({"type": "Polygon", "coordinates": [[[10, 54], [10.1, 54], [10.1, 54.1]]]})


def test_reads_a_file_or_the_text_itself(tmp_path):
    path = tmp_path / "bay.geojson"
    path.write_bytes(b"\xef\xbb\xbf" + TEXT.encode())
    for area in (str(path), TEXT, f"\n {TEXT}"):
        ((ring,),) = load_area(area)
        assert ring.tolist() == [[10, 54], [10.1, 54], [10.1, 54.1]]
    assert load_area("") == load_area("  ") == ()


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (None, r"cannot be read \(No such file or directory\); give the path of a GeoJSON file"),
        (b"\xff\xfe", r"cannot be read \(it is no text\)"),
        (b" " * (MAX_BYTES + 1), "is larger than 1 MB; simplify it"),
        (b"{}", r"bay\.geojson: The area of operation is not GeoJSON"),
    ],
)
def test_names_the_file_that_is_wrong(tmp_path, content, sentence):
    path = tmp_path / "bay.geojson"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ConfigError, match=sentence) as refused:
        load_area(str(path))
    assert str(refused.value).startswith(f"detections.area {'is ' if content is None else ''}"[:15])
    with pytest.raises(ConfigError, match="cannot be read"):
        load_area(str(tmp_path))
