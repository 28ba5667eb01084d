# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images are kept once telemetry of their scene is there."""

from __future__ import annotations

from dataclasses import replace

from aerial_gnss_ros.preflight.posed_boxes import PosedImages


def test_images_wait_for_telemetry_and_are_thinned_out(sea):
    world, kept = sea.World(robots={"a": lambda _t: (0.0, 17.0)}), PosedImages(100_000_000)
    for t in (0.0, 0.1, 0.2, 0.4):
        kept.add(world.frame(t))
    kept.add(sea.boxes(0.6, []))
    asked = []

    def pose_at(stamp_ns):
        asked.append(stamp_ns)
        if stamp_ns > sea.stamp(0.2):
            return True  # may still come
        return stamp_ns < sea.stamp(0.0) and replace(world.pose(0.0), stamp_ns=stamp_ns)

    kept.settle(None, pose_at)  # the camera is unknown
    assert not asked
    kept.settle(world.camera, pose_at)
    assert asked == [sea.stamp(t - 0.1) for t in (0.0, 0.2, 0.4)]
    (image,) = kept.images
    assert (image.pose.stamp_ns, image.centers.shape) == (sea.stamp(-0.1), (1, 2))
    kept.clear()
    kept.settle(world.camera, lambda _ns: world.pose(0.0))
    assert not kept.images
