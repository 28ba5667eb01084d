# SPDX-License-Identifier: Apache-2.0
"""What boxes should be at, given the platform's errors and the robots' places; with derivatives.

Unknowns, in this order: the latency correction (s) and the logarithm of the focal scale, then six
errors of the platform and the places of the robots, each as a line through knots over time. Knots
let what is nearly constant drift as its noise says: a constant that is fitted to a compass that
drifts would claim to be far better than it is. What is reported is the mean over the knots.

Besides, each image has six errors of its own: white noise, and what a drift does between knots.
They are no constants to be found, yet they have to be taken out of the pose before derivatives are
taken there. Derivatives at the measured pose carry the same noise as the residuals, and the product
of the two has a mean: it shortened the focal length by 4 % (regression dilution, or errors in
variables).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from aerial_gnss_ros.calibration.poses import PoseTable
from aerial_gnss_ros.calibration.recording import Sighting
from aerial_gnss_ros.core.camera import CameraModel
from aerial_gnss_ros.core.frames import FLU_FROM_OPTICAL, skew
from aerial_gnss_ros.core.gimbal import error_axes
from aerial_gnss_ros.core.local_map import water_points

Array = NDArray[np.float64]

LATENCY, FOCAL, FIRST = 0, 1, 2
DRIFTING = ("gnss_east", "gnss_north", "height", "gimbal_roll", "gimbal_pitch", "heading")
KNOT_S = 1.0
MOST_KNOTS = 100
ROBOT_KNOT_S = 10.0


class Layout:
    """Where each unknown stands.

    Args:
        sightings: all.
        still: whether robots have one place for the whole flight.

    Attributes:
        knots: of each error of the platform.
        step_s: from one of them to the next.
        robots: ids.
        robot_knots: of each robot's place.
        robot_step_s: from one of them to the next.
        size: number of unknowns.
    """

    def __init__(self, sightings: list[Sighting], still: bool) -> None:
        self.start_ns = sightings[0].stamp_ns
        self._span_s = max((sightings[-1].stamp_ns - self.start_ns) * 1e-9, 1e-3)
        self.knots = int(np.clip(round(self._span_s / KNOT_S) + 1, 2, MOST_KNOTS))
        self.step_s = self._span_s / (self.knots - 1)
        self.robots = tuple(sorted({name for one in sightings for name in one.robots}))
        self.robot_knots = 1 if still else 1 + max(1, round(self._span_s / ROBOT_KNOT_S))
        self.robot_step_s = self._span_s / max(1, self.robot_knots - 1)
        self.first_robot = FIRST + len(DRIFTING) * self.knots
        self.size = self.first_robot + 2 * len(self.robots) * self.robot_knots

    def drift(self, name: str) -> NDArray[np.intp]:
        """Return the columns of one error's knots."""
        first = FIRST + DRIFTING.index(name) * self.knots
        return np.arange(first, first + self.knots)

    def place(self, robot: int) -> NDArray[np.intp]:
        """Return the columns (knots, 2) of one robot's places."""
        first = self.first_robot + 2 * robot * self.robot_knots
        return np.arange(first, first + 2 * self.robot_knots).reshape(-1, 2)

    def weights(self, stamps_ns: NDArray[np.int64], knots: int) -> Array:
        """Return (n, knots): how much each knot counts at each time."""
        if knots == 1:
            return np.ones((len(stamps_ns), 1))
        share = (stamps_ns - self.start_ns) * 1e-9 / self._span_s
        at = np.clip(share, 0.0, 1.0) * (knots - 1)
        tent: Array = np.maximum(0.0, 1.0 - np.abs(at[:, None] - np.arange(knots)[None]))
        return tent


@dataclass(frozen=True)
class Boxes:
    """All boxes of some images, one row each.

    Attributes:
        stamps_ns: (n,) of the images.
        images: (n,) their numbers.
        robots: (n,) numbers of the robots.
        pixels: (n, 2).
        cameras: camera models with the rows (k,) that they took.
    """

    stamps_ns: NDArray[np.int64]
    images: NDArray[np.intp]
    robots: NDArray[np.intp]
    pixels: Array
    cameras: tuple[tuple[CameraModel, NDArray[np.intp]], ...]

    @property
    def image_count(self) -> int:
        """Number of images."""
        return int(self.images[-1]) + 1

    @staticmethod
    def of(sightings: list[Sighting], layout: Layout) -> Boxes:
        """Return the boxes of images."""
        numbers = {name: number for number, name in enumerate(layout.robots)}
        robots = [numbers[name] for one in sightings for name in one.robots]
        counts = [len(one.robots) for one in sightings]
        stamps = np.repeat(np.array([one.stamp_ns for one in sightings], dtype=np.int64), counts)
        models: dict[int, CameraModel] = {id(one.camera): one.camera for one in sightings}
        which = np.repeat([id(one.camera) for one in sightings], counts)
        cameras = tuple((camera, np.flatnonzero(which == key)) for key, camera in models.items())
        pixels = np.concatenate([one.pixels for one in sightings])
        images = np.repeat(np.arange(len(sightings)), counts)
        return Boxes(stamps, images, np.array(robots, dtype=np.intp), pixels, cameras)


@dataclass(frozen=True)
class Residuals:
    """What the model says to some boxes; those without telemetry or out of its view are left out.

    Attributes:
        values: (n, 2) measured less predicted, px.
        jacobian: (n, 2, size) of the prediction by the unknowns.
        by_own: (n, 2, 6) likewise by the image's own errors.
        images: (n,) their numbers.
    """

    values: Array
    jacobian: Array
    by_own: Array
    images: NDArray[np.intp]


def residuals(
    table: PoseTable, boxes: Boxes, layout: Layout, unknowns: Array, own: Array, latency_s: float
) -> Residuals:
    """Return what the boxes say.

    Args:
        table: measured poses.
        boxes: those to use.
        layout: of the unknowns.
        unknowns: (size,).
        own: (images, 6) errors of each image's pose besides the drifts, in their order.
        latency_s: configured, to which the unknown one is added.
    """
    late_ns = round((latency_s + unknowns[LATENCY]) * 1e9)
    poses = table.at(boxes.stamps_ns - late_ns)
    drift = layout.weights(boxes.stamps_ns, layout.knots)
    roam = layout.weights(boxes.stamps_ns, layout.robot_knots)
    errors = np.stack([drift @ unknowns[layout.drift(name)] for name in DRIFTING], axis=1)
    errors += own[boxes.images]
    columns = np.array([layout.place(r) for r in range(len(layout.robots))])[boxes.robots]
    places = np.einsum("nk,nka->na", roam, unknowns[columns])
    axes = _error_axes(poses.rotation)
    turn = Rotation.from_rotvec(np.einsum("nij,nj->ni", axes, errors[:, 3:])).as_matrix()
    optical = turn @ poses.rotation @ FLU_FROM_OPTICAL
    offsets = water_points(places) - poses.position - errors[:, :3]
    pixels, by_offset, seen, by_focal = _project(boxes, offsets, optical, float(unknowns[FOCAL]))
    # turning the camera by w moves what it sees by -w x offset
    by_turn = by_offset @ skew(offsets)
    count = len(boxes.robots)
    jacobian = np.zeros((count, 2, layout.size))
    by_motion = by_offset @ poses.velocity[:, :, None] - by_turn @ poses.turning[:, :, None]
    jacobian[:, :, LATENCY] = by_motion[:, :, 0]
    jacobian[:, :, FOCAL] = by_focal
    by_error = np.concatenate([-by_offset, by_turn @ axes], axis=2)
    for column, name in enumerate(DRIFTING):
        jacobian[:, :, layout.drift(name)] = by_error[:, :, column, None] * drift[:, None, :]
    for axis in range(2):
        share = by_offset[:, :, axis, None] * roam[:, None, :]
        np.put_along_axis(
            jacobian, np.broadcast_to(columns[:, None, :, axis], share.shape), share, axis=2
        )
    values = boxes.pixels - pixels
    good = np.isfinite(values).all(axis=1) & seen & (offsets[:, 2] < 0.0) & poses.known
    return Residuals(values[good], jacobian[good], by_error[good], boxes.images[good])


def _project(
    boxes: Boxes, offsets: Array, optical: Array, focal: float
) -> tuple[Array, Array, NDArray[np.bool_], Array]:
    """Return pixels (n, 2), derivatives by the offsets (n, 2, 3), what is seen, by the focal."""
    pixels, by_focal = np.zeros((2, len(offsets), 2))
    by_offset = np.zeros((len(offsets), 2, 3))
    seen = np.zeros(len(offsets), dtype=np.bool_)
    scale = float(np.exp(focal))
    for camera, rows in boxes.cameras:
        turned = optical[rows]
        points = np.einsum("nj,njk->nk", offsets[rows], turned)
        found, by_point, seen[rows] = camera.project_with_jacobian(points)
        middle = camera.K[:2, 2]
        by_focal[rows] = scale * (found - middle)
        pixels[rows] = middle + by_focal[rows]
        by_offset[rows] = scale * by_point @ turned.swapaxes(1, 2)
    return pixels, by_offset, seen, by_focal


def _error_axes(rotations: Array) -> Array:
    """Return the axes of `gimbal.error_axes` of many cameras, (n, 3, 3)."""
    return np.array([error_axes(rotation) for rotation in rotations])
