# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
from pathlib import Path

import pytest

from aerial_gnss_ros.core.values.paths import typed_path


@pytest.mark.parametrize(
    ("text", "path"),
    [
        ("~/areas/bay.geojson", Path.home() / "areas" / "bay.geojson"),
        ("~nobody_of_that_name/bay.geojson", Path("~nobody_of_that_name/bay.geojson")),
        ("bay.geojson", Path("bay.geojson")),
    ],
)
def test_a_tilde_is_the_home_folder_of_a_user_who_exists(text, path):
    assert typed_path(text) == path
