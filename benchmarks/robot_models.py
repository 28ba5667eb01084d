# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Renders the robot models side by side with their labels, for the documentation.

python benchmarks/robot_models.py docs/images/robot_models.jpg
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np

from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy
from aerial_gnss_ros.detection.images import write_jpeg
from aerial_gnss_ros.simulation.experiment import default_camera
from aerial_gnss_ros.simulation.hexapod import RobotState
from aerial_gnss_ros.simulation.renderer import Renderer
from aerial_gnss_ros.simulation.robot_models import MODELS
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.view import ViewPose

LIVERIES = {"aqua": "yellow", "torpedo": "yellow", "box": "orange", "catamaran": "red"}
HEIGHT_M = 6.0
SIZE, ROWS = (1280, 720), slice(150, 560)


def main() -> None:
    """Write the image."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("output", type=Path, nargs="?", default=Path("robot_models.jpg"))
    args = parser.parse_args()
    camera, renderer = default_camera(*SIZE), Renderer(Scene())
    rows = []
    for down_deg in (90.0, 50.0):
        back = HEIGHT_M / np.tan(np.radians(down_deg))
        rotation = np.asarray(matrix_from_rpy(0.0, np.radians(down_deg), 0.0))
        pose = ViewPose(np.array([-back, 0.0, HEIGHT_M]), rotation)
        robots = [
            RobotState(f"{name}_1", 0.0, 3.0 - 2.0 * i, 0.5 + 0.3 * i, class_name=name, model=name,
                       livery=LIVERIES[name]) for i, name in enumerate(MODELS)
        ]  # fmt: skip
        image, labels = renderer.render(camera, pose, 1.0, robots)
        for label in labels:
            corners = np.round([label.left, label.top, label.right, label.bottom]).astype(int)
            low, high = corners[:2].tolist(), corners[2:].tolist()
            cv2.rectangle(image, low, high, (0, 255, 0), 1)
            place = (low[0], low[1] - 6)
            text = f"{label.class_name} {label.long_px:.0f} px"
            cv2.putText(image, text, place, cv2.FONT_HERSHEY_SIMPLEX, 0.5, (0, 255, 0), 1)
        rows.append(image[ROWS])
    write_jpeg(args.output, np.vstack(rows), 85)


if __name__ == "__main__":
    main()
