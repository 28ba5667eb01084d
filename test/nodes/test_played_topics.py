# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What of a recording goes into live nodes, and where."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.nodes.played_topics import inputs, moved

IMAGE, ARRAY, FIX = "sensor_msgs/msg/Image", "vision_msgs/msg/Detection2DArray", "x/msg/Fix"
RECORDED = {
    "/d/fix": FIX, "/d/detections": ARRAY, "/d/robots/aqua_1/fix": FIX, "/d/robots/markers": FIX,
    "/d/map_datum": FIX, "/d/truth/robots/aqua_1/fix": FIX, "/clock": FIX, "/tf": FIX,
    "/robots_of_others/fix": FIX, "/d/current": FIX,
}  # fmt: skip


def test_what_the_nodes_publish_themselves_is_left_out():
    kept = ["/d/fix", "/d/detections", "/d/truth/robots/aqua_1/fix", "/tf", "/robots_of_others/fix"]
    assert inputs(RECORDED) == kept
    with_images = {**RECORDED, "/d/camera/image_raw": IMAGE}
    assert set(inputs(with_images)) == {*kept, "/d/camera/image_raw"} - {"/d/detections"}


@pytest.mark.parametrize(
    ("name", "namespace", "where"),
    [
        ("/fix", "", "/fix"),
        ("/fix", "drone1", "/drone1/fix"),
        ("/fix", "/drone1/", "/drone1/fix"),
        ("/drone1/fix", "drone1", "/drone1/fix"),
        ("/drone10/fix", "drone1", "/drone1/drone10/fix"),
        ("/tf", "drone1", "/tf"),
    ],
)
def test_a_namespace_moves_what_is_not_in_it(name, namespace, where):
    assert moved(name, namespace) == where
