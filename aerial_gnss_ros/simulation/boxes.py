# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulated detections without images: projected robots with a detector's errors."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.simulation.robot_models import AQUA, robot_model
from aerial_gnss_ros.simulation.view import ViewPose, project_points

Array = NDArray[np.float64]

DEEPEST_SEEN_M = 0.6
"""Depth below which robots have no box, m: in most waters they are hardly visible from above."""

_CORNERS = 0.5 * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])


@dataclass(frozen=True)
class Boxes:
    """True boxes of the robots visible in one image.

    Attributes:
        names: n robots.
        class_names: n names of their classes.
        centers: (n, 2) px; here of the projected bodies, in rendered images of the boxes.
        sizes: (n, 2) width and height, px.
    """

    names: tuple[str, ...]
    class_names: tuple[str, ...]
    centers: Array
    sizes: Array


@dataclass(frozen=True)
class DetectorPlan:
    """Errors of a simulated detector.

    Attributes:
        center_px: one sigma of a box's centre, each axis, px.
        missed: probability that a robot in view is not detected.
        false_per_image: mean number of false boxes.
    """

    center_px: float = 2.0
    missed: float = 0.0
    false_per_image: float = 0.0


def projected_boxes(
    camera: CameraModel,
    pose: ViewPose,
    names: tuple[str, ...],
    class_names: tuple[str, ...],
    positions: Array,
    courses: Array,
    models: Sequence[str] | None = None,
) -> Boxes:
    """Return the boxes of the robots whose centre is in the image and not too deep.

    Args:
        camera: lens and image size.
        pose: of the camera.
        names: n robots.
        class_names: n names of their classes.
        positions: (n, 3) middles, East, North, up, m.
        courses: (n,) yaws, rad.
        models: n shapes; None: the hexapod.
    """
    middles, _ = project_points(camera, pose, positions)
    index = np.flatnonzero(camera.inside(middles) & (positions[:, 2] >= -DEEPEST_SEEN_M))
    c, s = np.cos(courses[index]), np.sin(courses[index])
    shapes = [robot_model(AQUA if models is None else models[int(i)]).size for i in index]
    local = _CORNERS * np.array(shapes).reshape(-1, 1, 3)
    corners = np.repeat(positions[index, None, :], len(_CORNERS), axis=1)
    corners[..., 0] += c[:, None] * local[..., 0] - s[:, None] * local[..., 1]
    corners[..., 1] += s[:, None] * local[..., 0] + c[:, None] * local[..., 1]
    corners[..., 2] += local[..., 2]
    pixels, _ = project_points(camera, pose, corners.reshape(-1, 3))
    pixels = pixels.reshape(len(index), len(_CORNERS), 2)
    # A corner beyond the lens model is replaced by the centre: the box is truncated there.
    pixels = np.where(np.isfinite(pixels), pixels, middles[index, None, :])
    return Boxes(
        tuple(names[i] for i in index),
        tuple(class_names[i] for i in index),
        middles[index],
        np.ptp(pixels, axis=1).reshape(-1, 2),
    )


def detected(
    boxes: Boxes,
    plan: DetectorPlan,
    camera: CameraModel,
    class_name: str,
    stamp_ns: int,
    frame_id: str,
    rng: np.random.Generator,
) -> DetectionFrame:
    """Return the boxes of a detector with stated errors in an image, best score first."""
    count, size = len(boxes.names), np.array([camera.width, camera.height], dtype=np.float64)
    noise = plan.center_px * rng.standard_normal((count, 2))
    found = rng.random(count) >= plan.missed
    scores = rng.uniform(0.6, 0.95, count)
    wrong = int(rng.poisson(plan.false_per_image))
    centers = np.concatenate([(boxes.centers + noise)[found], size * rng.random((wrong, 2))])
    sizes = np.concatenate([boxes.sizes[found], rng.uniform(12.0, 60.0, (wrong, 2))])
    scores = np.concatenate([scores[found], rng.uniform(0.3, 0.7, wrong)])
    names = [name for name, is_found in zip(boxes.class_names, found, strict=True) if is_found]
    names += [class_name] * wrong
    inside = camera.inside(centers)
    order = np.argsort(-scores, kind="stable")
    order = order[inside[order]]
    return DetectionFrame(
        stamp_ns, frame_id, centers[order], sizes[order], scores[order],
        tuple(names[i] for i in order),
    )  # fmt: skip
