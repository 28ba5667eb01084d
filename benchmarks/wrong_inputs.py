# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Ways in which an input may be wrong throughout a flight, as changes of its messages."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from aerial_gnss_ros.core.geometry.frames import (
    matrix_from_quaternion,
    matrix_from_rpy,
    quaternion_from_matrix,
    rpy_from_matrix,
)
from aerial_gnss_ros.core.geometry.gimbal import error_axes
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_matrix

Change = Callable[[Any, float], bool | None]
"""Changes a message, some seconds after the first one; returns whether it is lost."""

METRES_A_DEGREE = 111_200.0
"""Of latitude."""
FOCAL_PX, CENTRE_PX = 1100.0, (960.0, 540.0)
"""Of the flights' camera."""


def higher(by_m: float, by_mps: float = 0.0) -> Change:
    """Return the change of a height that is too large, and ever more so."""

    def change(message: Any, t: float) -> None:
        message.data += by_m + by_mps * t

    return change


def heaving(by_m: float, period_s: float) -> Change:
    """Return the change of a height that rises and falls."""

    def change(message: Any, t: float) -> None:
        message.data += by_m * math.sin(2.0 * math.pi * t / period_s)

    return change


def turned(axis: int, by_deg: Callable[[float, float], float]) -> Change:
    """Return the change of a camera that seems to be turned about one of `error_axes`.

    Args:
        axis: 0 roll, 1 pitch, 2 heading.
        by_deg: the angle by the camera's azimuth, rad, and time, s.
    """

    def change(message: Any, t: float) -> None:
        q = message.quaternion
        camera = matrix_from_quaternion((q.x, q.y, q.z, q.w))
        axes = error_axes(camera)
        angle = math.radians(by_deg(math.atan2(axes[0, 0], axes[1, 0]), t))
        q.x, q.y, q.z, q.w = quaternion_from_matrix(rotation_matrix(angle * axes[:, axis]) @ camera)

    return change


def whole_degrees(message: Any, _t: float) -> None:
    """Round yaw, pitch and roll."""
    q = message.quaternion
    angles = np.degrees(rpy_from_matrix(matrix_from_quaternion((q.x, q.y, q.z, q.w))))
    q.x, q.y, q.z, q.w = quaternion_from_matrix(matrix_from_rpy(*np.radians(np.round(angles))))


def whole_metres(message: Any, _t: float) -> None:
    """Round a height."""
    message.data = float(round(message.data))


def late(by_s: float) -> Change:
    """Return the change of stamps that are later than the measurement."""

    def change(message: Any, _t: float) -> None:
        stamp = message.header.stamp
        at_ns = stamp.sec * 1_000_000_000 + stamp.nanosec + round(by_s * 1e9)
        stamp.sec, stamp.nanosec = divmod(at_ns, 1_000_000_000)

    return change


def wandering(by_m: float, period_s: float) -> Change:
    """Return the change of a fix that goes round in a circle."""

    def change(message: Any, t: float) -> None:
        angle = 2.0 * math.pi * t / period_s
        of_east = METRES_A_DEGREE * math.cos(math.radians(message.latitude))
        message.latitude += by_m * math.sin(angle) / METRES_A_DEGREE
        message.longitude += by_m * math.cos(angle) / of_east

    return change


def displaced(by_m: float, when: Callable[[float], bool]) -> Change:
    """Return the change of a fix that is off to the North at some times."""

    def change(message: Any, t: float) -> None:
        if when(t):
            message.latitude += by_m / METRES_A_DEGREE

    return change


def stuck(every_s: float, for_s: float) -> Change:
    """Return the change of an orientation that repeats itself for some time, again and again."""
    last: list[Any] = []

    def change(message: Any, t: float) -> None:
        if last and t % every_s < for_s:
            message.quaternion = copy.deepcopy(last[0])
        else:
            last[:] = [copy.deepcopy(message.quaternion)]

    return change


def longer(factor: float) -> Change:
    """Return the change of a focal length that is stated too long."""

    def change(message: Any, _t: float) -> None:
        message.k, message.p = message.k.copy(), message.p.copy()
        for places, matrix in (((0, 4), message.k), ((0, 5), message.p)):
            for place in places:
                matrix[place] *= factor

    return change


def distorted(k1: float) -> Change:
    """Return the change of boxes by a radial distortion that is not stated."""

    def change(message: Any, _t: float) -> None:
        for box in message.detections:
            place = box.bbox.center.position
            x, y = place.x - CENTRE_PX[0], place.y - CENTRE_PX[1]
            factor = 1.0 + k1 * (x * x + y * y) / FOCAL_PX**2
            place.x, place.y = CENTRE_PX[0] + factor * x, CENTRE_PX[1] + factor * y

    return change


def coarse(by_px: float) -> Change:
    """Return the change of boxes that a network places on a grid."""

    def change(message: Any, _t: float) -> None:
        for box in message.detections:
            place = box.bbox.center.position
            place.x, place.y = (by_px * round(one / by_px) for one in (place.x, place.y))

    return change


def noisy(by_px: float) -> Change:
    """Return the change of boxes that are more noisy by one sigma, each axis."""

    def change(message: Any, _t: float) -> None:
        by = by_px * _chance(message).standard_normal((len(message.detections), 2))
        for box, (x, y) in zip(message.detections, by.tolist(), strict=True):
            box.bbox.center.position.x += x
            box.bbox.center.position.y += y

    return change


def missed(share: float) -> Change:
    """Return the change of images that miss a share of the robots, each time by chance."""

    def change(message: Any, _t: float) -> None:
        drawn = _chance(message).random(len(message.detections)).tolist()
        kept = zip(message.detections, drawn, strict=True)
        message.detections = [box for box, one in kept if one >= share]

    return change


def dark(every_s: float, for_s: float) -> Change:
    """Return the change of images that show nothing for some time, again and again."""

    def change(message: Any, t: float) -> None:
        if t % every_s < for_s:
            message.detections = []

    return change


def lost(every_s: float, for_s: float) -> Change:
    """Return the change of an input that fails for some time, again and again."""
    return lambda _message, t: t % every_s < for_s


def misclassified(share: float) -> Change:
    """Return the change of a share of the boxes, by chance, to another class."""

    def change(message: Any, _t: float) -> None:
        drawn = _chance(message).random(len(message.detections)).tolist()
        for box, one in zip(message.detections, drawn, strict=True):
            if one < share:
                box.results[0].hypothesis.class_id = "boat"

    return change


def doubled(share: float, by_px: float) -> Change:
    """Return the change of images with a second box on a share of the robots, by chance."""

    def change(message: Any, _t: float) -> None:
        chance, more = _chance(message), []
        for box in message.detections:
            if chance.random() < share:
                second = copy.deepcopy(box)
                x, y = (by_px * chance.standard_normal(2)).tolist()
                second.bbox.center.position.x += x
                second.bbox.center.position.y += y
                more.append(second)
        message.detections = [*message.detections, *more]

    return change


def spot(x_px: float, y_px: float) -> Change:
    """Return the change of images with a false box at one place, as of a drop on the lens."""

    def change(message: Any, _t: float) -> None:
        if message.detections:
            box = copy.deepcopy(message.detections[0])
            box.bbox.center.position.x, box.bbox.center.position.y = x_px, y_px
            message.detections.append(box)

    return change


def _chance(message: Any) -> np.random.Generator:
    """Return random numbers that are the same whenever a message is read."""
    return np.random.default_rng((message.header.stamp.sec, message.header.stamp.nanosec))


CASES: dict[str, tuple[str, Change]] = {
    "nothing": ("/height", higher(0.0)),
    "height 2 m": ("/height", higher(2.0)),
    "height -2 m": ("/height", higher(-2.0)),
    "height 0.03 m/s": ("/height", higher(0.0, 0.03)),
    "height 0.1 m/s": ("/height", higher(0.0, 0.1)),
    "height 0.5 m in 6 s": ("/height", heaving(0.5, 6.0)),
    "height in whole m": ("/height", whole_metres),
    "roll 2 deg": ("/gimbal", turned(0, lambda _azimuth, _t: 2.0)),
    "pitch 2 deg": ("/gimbal", turned(1, lambda _azimuth, _t: 2.0)),
    "pitch -2 deg": ("/gimbal", turned(1, lambda _azimuth, _t: -2.0)),
    "heading 5 deg": ("/gimbal", turned(2, lambda _azimuth, _t: 5.0)),
    "heading 10 deg": ("/gimbal", turned(2, lambda _azimuth, _t: 10.0)),
    "heading 0.1 deg/s": ("/gimbal", turned(2, lambda _azimuth, t: 0.1 * t)),
    "deviation 3 deg": ("/gimbal", turned(2, lambda azimuth, _t: 3.0 * math.sin(azimuth))),
    "deviation 5 deg": ("/gimbal", turned(2, lambda azimuth, _t: 5.0 * math.sin(azimuth + 1.0))),
    "deviation 10 deg": ("/gimbal", turned(2, lambda azimuth, _t: 10.0 * math.sin(azimuth))),
    "angles in whole deg": ("/gimbal", whole_degrees),
    "gimbal 0.3 s late": ("/gimbal", late(0.3)),
    "fix 0.2 s late": ("/fix", late(0.2)),
    "fix 1 m in 40 s": ("/fix", wandering(1.0, 40.0)),
    "fix 50 m off once": ("/fix", displaced(50.0, lambda t: 20.0 <= t < 20.1)),
    "fix 5 m off for 2 s in 15": ("/fix", displaced(5.0, lambda t: t % 15.0 < 2.0)),
    "fix 3 m off from 40 s on": ("/fix", displaced(3.0, lambda t: t >= 40.0)),
    "heading 20 deg off for 1 s in 15": (
        "/gimbal",
        turned(2, lambda _azimuth, t: 20.0 * (t % 15.0 < 1.0)),
    ),
    "gimbal stuck for 5 s in 15": ("/gimbal", stuck(15.0, 5.0)),
    "no fix for 4 s in 15": ("/fix", lost(15.0, 4.0)),
    "focal length +5 %": ("/camera/camera_info", longer(1.05)),
    "focal length +10 %": ("/camera/camera_info", longer(1.1)),
    "focal length -10 %": ("/camera/camera_info", longer(0.9)),
    "distortion -0.1": ("/detections", distorted(-0.1)),
    "boxes on 16 px": ("/detections", coarse(16.0)),
    "boxes noisy by 8 px": ("/detections", noisy(8.0)),
    "half the boxes missed": ("/detections", missed(0.5)),
    "7 of 10 boxes missed": ("/detections", missed(0.7)),
    "no boxes for 5 s in 15": ("/detections", dark(15.0, 5.0)),
    "1 in 10 boxes of another class": ("/detections", misclassified(0.1)),
    "1 in 5 boxes doubled": ("/detections", doubled(0.2, 6.0)),
    "a spot on the lens": ("/detections", spot(400.0, 700.0)),
}
"""Topic and change by name. Deviation: of the compass, by iron on board, at its worst azimuth."""
