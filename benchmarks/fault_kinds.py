# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Faults of inputs: what becomes of their messages while a fault lasts."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from fault_flights import BLACK, NOISY, Item, Lens, Picture, Value, lens_of
from numpy.typing import NDArray

from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion, quaternion_from_matrix
from aerial_gnss_ros.core.geometry.rotation_vectors import rotation_matrix
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar
from aerial_gnss_ros.simulation.experiment import default_camera

Array = NDArray[np.float64]
Change = Callable[[list[Item], np.random.Generator], list[Item]]
"""Makes of an input's messages those that come instead."""

DAY_NS = 86_400_000_000_000
LATE_S, MIXED_S = 1.0, 0.5
METRE = 1.0 / 6_371_000.0
"""A metre on the ground in rad of latitude."""


@dataclass(frozen=True)
class Sizes:
    """How strong the faults of one input are, in its own unit.

    Attributes:
        unit: of the others; a camera's is the factor of its focal length, less 1.
        jump: from the begin to the end of the fault.
        drift: a second.
        noise: one sigma, ten times what the simulation has; for a camera, which has none, 3 %.
        wild: of the one sample.
    """

    unit: str
    jump: float
    drift: float
    noise: float
    wild: float


SIZES = {
    "fix": Sizes("m", 50.0, 1.0, 0.3, 1000.0),
    "attitude": Sizes("deg", 20.0, 2.0, 1.0, 90.0),
    "gimbal": Sizes("deg", 20.0, 2.0, 0.3, 90.0),
    "height": Sizes("m", 5.0, 0.5, 0.3, 50.0),
    "camera_info": Sizes("", 0.3, 0.03, 0.03, 2.0),
    "detections": Sizes("px", 150.0, 20.0, 20.0, 400.0),
}
INPUTS = (*SIZES, "images")


def moved(value: Value, by: float) -> Value:
    """Return a value off by so much (see `Sizes.unit`); an image is one that was taken earlier.

    A body turns about the vertical; a camera tilts and turns at once.
    """
    if isinstance(value, Fix):
        east = by * METRE / math.cos(value.latitude)
        return replace(value, longitude=value.longitude + east)
    if isinstance(value, Orientation):
        matrix = matrix_from_quaternion(value.quaternion)
        turn = rotation_matrix(math.radians(by) * np.array([0.0, 1.0, 1.0]) / math.sqrt(2.0))
        return replace(value, quaternion=quaternion_from_matrix(matrix @ turn))
    if isinstance(value, Scalar):
        return replace(value, value=value.value + by)
    if isinstance(value, Lens):
        return Lens(value.stamp_ns, lens_of(default_camera(1280, 720), 1.0 + by))
    if isinstance(value, DetectionFrame):
        return replace(value, centers=value.centers + by)
    return replace(value, index=max(1, value.index - 50))


def noisy(value: Value, sigma: float, rng: np.random.Generator) -> Value:
    """Return a value with so much more white noise in all that it says."""
    if isinstance(value, Fix):
        east, north = sigma * METRE * rng.standard_normal(2)
        return replace(
            value,
            latitude=value.latitude + north,
            longitude=value.longitude + east / math.cos(value.latitude),
        )
    if isinstance(value, Orientation):
        turn = rotation_matrix(math.radians(sigma) * rng.standard_normal(3))
        matrix = matrix_from_quaternion(value.quaternion) @ turn
        return replace(value, quaternion=quaternion_from_matrix(matrix))
    if isinstance(value, DetectionFrame):
        return replace(
            value, centers=value.centers + sigma * rng.standard_normal(value.centers.shape)
        )
    if isinstance(value, Picture):
        return replace(value, shows=NOISY)
    return moved(value, sigma * float(rng.standard_normal()))


def filled(value: Value, number: float) -> Value | None:
    """Return a value whose every number is the same; None where it has no number."""
    if isinstance(value, Fix):
        return replace(value, latitude=number, longitude=number, altitude=number)
    if isinstance(value, Orientation):
        return replace(value, quaternion=np.full(4, number))
    if isinstance(value, Scalar):
        return replace(value, value=number)
    if isinstance(value, Lens):
        numbers = {name: [number] * len(value.fields[name]) for name in "dkrp"}
        return Lens(value.stamp_ns, value.fields | numbers)
    if isinstance(value, DetectionFrame):
        boxes = np.full_like(value.centers, number)
        return replace(value, centers=boxes, sizes=boxes)
    return replace(value, shows=BLACK) if number == 0.0 else None


def beyond(value: Value) -> Value:
    """Return a value that is finite and outside what can be."""
    if isinstance(value, Fix):
        return replace(value, latitude=math.radians(95.0), longitude=math.radians(500.0))
    if isinstance(value, Orientation):
        return replace(value, quaternion=3.0 * value.quaternion)
    if isinstance(value, Scalar):
        return replace(value, value=1e18)
    if isinstance(value, Lens):
        return Lens(value.stamp_ns, value.fields | {"d": [1e308] * len(value.fields["d"])})
    if isinstance(value, DetectionFrame):
        return replace(value, centers=np.full_like(value.centers, 1e9))
    return replace(value, whole=False)


def lowest(value: Value) -> Value | None:
    """Return the least that an input can say.

    A receiver without a fix, an orientation that is level and faces east, a range finder at its
    stop, a camera of one pixel, boxes without score.
    """
    if isinstance(value, Fix):
        return replace(value, valid=False)
    if isinstance(value, Orientation):
        return replace(value, quaternion=np.array([0.0, 0.0, 0.0, 1.0]))
    if isinstance(value, Scalar):
        return replace(value, value=0.3)
    if isinstance(value, Lens):
        return Lens(value.stamp_ns, value.fields | {"width": 1, "height": 1})
    if isinstance(value, DetectionFrame):
        return replace(value, scores=np.zeros(len(value)))
    return None


def each(change: Callable[[Value], Value | None]) -> Change:
    """Return what changes each message by itself; those that become None do not come."""

    def apply(items: list[Item], _rng: np.random.Generator) -> list[Item]:
        made = ((item, change(item.value)) for item in items)
        return [item.says(value) for item, value in made if value is not None]

    return apply


def stamped(shift_ns: int) -> Change:
    """Return what shifts the stamps; where messages have none (height), nothing changes."""
    return each(lambda value: replace(value, stamp_ns=value.stamp_ns + shift_ns))


def absent(_items: list[Item], _rng: np.random.Generator) -> list[Item]:
    """Return no messages."""
    return []


def late(items: list[Item], _rng: np.random.Generator) -> list[Item]:
    """Return messages that come late."""
    return [replace(item, arrival_ns=item.arrival_ns + round(LATE_S * 1e9)) for item in items]


def duplicated(items: list[Item], _rng: np.random.Generator) -> list[Item]:
    """Return every message twice."""
    return [item for item in items for _ in range(2)]


def mixed(items: list[Item], rng: np.random.Generator) -> list[Item]:
    """Return messages that come in any order within each half second."""
    found: list[Item] = []
    first = items[0].arrival_ns if items else 0
    blocks: dict[int, list[Item]] = {}
    for item in items:
        blocks.setdefault(int((item.arrival_ns - first) / (MIXED_S * 1e9)), []).append(item)
    for block in blocks.values():
        arrivals = [item.arrival_ns for item in block]
        found += [
            replace(block[k], arrival_ns=arrival)
            for k, arrival in zip(rng.permutation(len(block)), arrivals, strict=True)
        ]
    return found


def jumped(items: list[Item], _rng: np.random.Generator) -> list[Item]:
    """Return values that are off by the same all the time."""
    return [item.says(moved(item.value, SIZES[item.source].jump)) if item.source in SIZES
            else item.says(moved(item.value, 0.0)) for item in items]  # fmt: skip


def drifting(items: list[Item], _rng: np.random.Generator) -> list[Item]:
    """Return values that are off by ever more."""
    first = items[0].arrival_ns if items else 0
    return [
        item.says(moved(item.value, SIZES[item.source].drift * (item.arrival_ns - first) * 1e-9))
        for item in items
    ]


def frozen(items: list[Item], _rng: np.random.Generator) -> list[Item]:
    """Return the first value ever again, under new stamps."""
    return [item.says(replace(items[0].value, stamp_ns=item.value.stamp_ns)) for item in items]


def frozen_stamp(items: list[Item], _rng: np.random.Generator) -> list[Item]:
    """Return new values under the first stamp."""
    return [item.says(replace(item.value, stamp_ns=items[0].value.stamp_ns)) for item in items]


def noise_times_ten(items: list[Item], rng: np.random.Generator) -> list[Item]:
    """Return values with ten times the white noise."""
    return [
        item.says(noisy(item.value, SIZES[item.source].noise if item.source in SIZES else 0.0, rng))
        for item in items
    ]


def one_of(change: Change) -> Change:
    """Return what befalls one message only, the one amid the others."""

    def apply(items: list[Item], rng: np.random.Generator) -> list[Item]:
        middle = len(items) // 2
        return items[:middle] + change(items[middle : middle + 1], rng) + items[middle + 1 :]

    return apply


def wild(items: list[Item], _rng: np.random.Generator) -> list[Item]:
    """Return values that can be, and are far off."""
    return [item.says(moved(item.value, SIZES[item.source].wild if item.source in SIZES else 0.0))
            for item in items]  # fmt: skip


KINDS: dict[str, Change] = {
    "absent": absent,
    "late": late,
    "duplicated": duplicated,
    "out of order": mixed,
    "NaN": each(lambda value: filled(value, math.nan)),
    "infinite": each(lambda value: filled(value, math.inf)),
    "zero": each(lambda value: filled(value, 0.0)),
    "out of range": each(beyond),
    "jump": jumped,
    "slow drift": drifting,
    "frozen value": frozen,
    "frozen stamp": frozen_stamp,
    "stamp a day off": stamped(DAY_NS),
    "stuck low": each(lowest),
    "noise times ten": noise_times_ten,
    "one wild sample": one_of(wild),
}

MEANINGLESS = {
    ("height", "frozen stamp"), ("height", "stamp a day off"),  # std_msgs/Float64 has no stamp
    ("images", "NaN"), ("images", "infinite"), ("images", "slow drift"),  # pixels are bytes
    ("images", "stuck low"),  # as zero
}  # fmt: skip
