# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cameras of a bag's images over the water, from its telemetry."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.replay import Replay
from aerial_gnss_ros.calibration.recording import Recording as Telemetry
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.detection.base import Detections, Image
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.teaching.geometry import View


class _Nothing:
    """A detector that finds nothing: only the telemetry is read."""

    name = "none"
    class_names = ("object",)

    def detect(self, _image: Image) -> Detections:
        """Return no boxes."""
        none = np.zeros(0)
        return Detections(np.zeros((0, 4)), none, none.astype(np.int64), self.class_names)


def bag_views(
    bag: Path,
    stamps_ns: Sequence[int],
    config: EstimatorConfig,
    detector: DetectorConfig,
    namespace: str,
) -> list[View | None]:
    """Return the camera at each image's stamp; None where it is unknown.

    Args:
        bag: with telemetry and images or detections.
        stamps_ns: of images.
        config: parameters of the estimator, with the vehicle's topics.
        detector: names the image topic.
        namespace: that relative topics were recorded in.

    Raises:
        InputError: the bag lacks telemetry that the parameters name.
    """
    telemetry = Telemetry(replace(config, state_file=""))
    with open_bag([bag]) as opened:
        replay = Replay(
            opened, config, detector, lambda _config: _Nothing(), namespace=namespace,
            estimator=telemetry,
        )  # fmt: skip
        for _ in replay.results():
            pass
    latency_ns = round(config.camera.latency_s * 1e9)
    views: list[View | None] = []
    for stamp in stamps_ns:
        camera, pose = telemetry.camera(stamp), telemetry.pose(stamp - latency_ns)
        known = camera is not None and pose is not None
        views.append(View(camera, pose.position, pose.optical) if known else None)  # type: ignore[arg-type, union-attr]
    return views
