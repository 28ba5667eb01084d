# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Truth as in the paper: a robot's position while the drone hovers above it.

Straight down, errors of compass and range vanish, and a tilt error of 0.4 deg is 7 cm at 10 m. The
receiver's offset remains. It is the same elsewhere in the flight, so errors against this truth are
relative to the drone's receiver and do not contain its offset. The paper uses the drone's own
position for the robot's; here the ray through the robot's box adds the robot's small distance from
the vertical.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum, State

GAP_NS = 2_000_000_000
"""Least time between two hovers, ns."""
LEAST_NS = 1_000_000_000
"""Least duration of a hover, ns."""


@dataclass(frozen=True)
class Hover:
    """One hover above a robot.

    Attributes:
        robot: label from the single-image method.
        start_ns: first image.
        end_ns: last image.
        latitude: rad, mean.
        longitude: rad, mean.
        spread_m: root mean square distance of the single positions from their mean.
        count: images.
    """

    robot: str
    start_ns: int
    end_ns: int
    latitude: float
    longitude: float
    spread_m: float
    count: int


def find_hovers(results: Iterable[FrameResult], within: float) -> list[Hover]:
    """Return the hovers over robots.

    Args:
        results: of the method `single`, in order.
        within: greatest angle from the vertical, rad.

    Raises:
        InputError: no hover.
    """
    moments, nearest = _from_above(results, within)
    hovers = [h for robot in sorted(moments) for h in _stays(robot, moments[robot])]
    if not hovers:
        raise InputError(_no_hover(nearest))
    return sorted(hovers, key=lambda hover: hover.start_ns)


def seen_from_above(
    results: Iterable[FrameResult], within: float, latency_s: float = 0.0
) -> dict[str, Track]:
    """Return where a drone saw robots straight below it, at these times only.

    Args:
        results: of the method `single`, in order.
        within: greatest angle from the vertical, rad.
        latency_s: of the images of another drone that is to be verified, s: tracks are stamped as
            its images are.

    Raises:
        InputError: no robot was below it for a second.
    """
    shift_ns = round(latency_s * 1e9)
    moments, nearest = _from_above(results, within, shift_ns)
    found = {}
    for robot, seen in sorted(moments.items()):
        if _stays(robot, seen):
            stamps, latitude, longitude = zip(*seen, strict=True)
            found[robot] = Track(
                np.array(stamps, np.int64), np.array(latitude), np.array(longitude)
            )
    if not found:
        raise InputError(_no_hover(nearest))
    return found


_Moments = dict[str, list[tuple[int, float, float]]]


def _from_above(
    results: Iterable[FrameResult], within: float, shift_ns: int | None = None
) -> tuple[_Moments, float]:
    """Return when and where robots were seen from above, and the least angle, rad.

    Args:
        results: in order.
        within: greatest angle from the vertical, rad.
        shift_ns: stamps are the scenes' and so much, ns; None: the images'.
    """
    moments: _Moments = {}
    nearest = math.inf
    for result in results:
        if result.pose is None:
            continue
        pose = result.pose
        below = LocalMap(MapDatum(pose.latitude, pose.longitude, 0.0))
        for robot in result.estimates:
            if robot.state is not State.CONFIRMED:
                continue
            aside = np.linalg.norm(below.positions([robot.latitude], [robot.longitude]))
            off = math.atan2(aside, pose.height)
            nearest = min(nearest, off)
            if off <= within:
                stamp_ns = result.stamp_ns if shift_ns is None else pose.stamp_ns + shift_ns
                moment = stamp_ns, robot.latitude, robot.longitude
                moments.setdefault(robot.robot_id, []).append(moment)
    return moments, nearest


def _no_hover(nearest: float) -> str:
    """Return why there is no truth from hovers; `nearest` is the least angle from above, rad."""
    seen = "it has no robots"
    if math.isfinite(nearest):
        seen = f"the least angle of a robot from the vertical is {math.degrees(nearest):.1f} deg"
    return (
        "the camera never looks straight down at a robot for a second, so there is no truth "
        f"from hovers ({seen}); give --truth, or a wider --nadir-deg."
    )


def _stays(robot: str, moments: Sequence[tuple[int, float, float]]) -> list[Hover]:
    stamps = np.array([moment[0] for moment in moments], dtype=np.int64)
    places = np.array([moment[1:] for moment in moments])
    cuts = np.flatnonzero(np.diff(stamps) > GAP_NS) + 1
    stays = []
    for part in np.split(np.arange(len(stamps)), cuts):
        if stamps[part[-1]] - stamps[part[0]] < LEAST_NS:
            continue
        latitude, longitude = places[part].mean(axis=0)
        around = LocalMap(MapDatum(latitude, longitude, 0.0))
        off = around.positions(places[part, 0], places[part, 1])
        spread = float(np.sqrt(np.mean(np.sum(off**2, axis=1))))
        first, last = int(stamps[part[0]]), int(stamps[part[-1]])
        stays.append(Hover(robot, first, last, latitude, longitude, spread, len(part)))
    return stays


def hover_truth(
    hovers: Sequence[Hover], stamps: NDArray[np.int64], still_s: float | None
) -> dict[str, Track]:
    """Return each robot's track: its position in hovers, while it counts as still.

    Between two hovers over the same robot its position is interpolated.

    Args:
        hovers: of `find_hovers`.
        stamps: (n,) of all images.
        still_s: time before and after a hover for which its position holds, s; None: the whole
            flight.

    Returns:
        Tracks by robot, without the images during hovers, which are not compared.
    """
    robots: dict[str, list[Hover]] = {}
    for hover in hovers:
        robots.setdefault(hover.robot, []).append(hover)
    others = stamps[~during(hovers, stamps)]
    return {name: _still(stays, others, still_s) for name, stays in robots.items()}


def during(hovers: Sequence[Hover], stamps: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return a mask of the stamps (n,) within a hover over any robot."""
    within = [_outside(h, stamps) == 0 for h in hovers]
    return np.any(within, axis=0) if within else np.zeros(len(stamps), dtype=np.bool_)


def _still(stays: Sequence[Hover], stamps: NDArray[np.int64], still_s: float | None) -> Track:
    knots = np.array([stamp for h in stays for stamp in (h.start_ns, h.end_ns)], dtype=np.int64)
    first = knots[0]
    seconds, at = (stamps - first) * 1e-9, (knots - first) * 1e-9
    latitude = np.interp(seconds, at, np.repeat([h.latitude for h in stays], 2))
    longitude = np.interp(seconds, at, np.repeat([h.longitude for h in stays], 2))
    keep = np.ones(len(stamps), dtype=np.bool_)
    if still_s is not None:
        away = np.min([_outside(h, stamps) for h in stays], axis=0)
        keep = away <= still_s * 1e9
    return Track(stamps[keep], latitude[keep], longitude[keep])


def _outside(hover: Hover, stamps: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.maximum(np.maximum(hover.start_ns - stamps, stamps - hover.end_ns), 0)


def away_from(
    hovers: Sequence[Hover], estimates: Mapping[str, EstimatedTrack]
) -> dict[str, EstimatedTrack]:
    """Return the published positions without those during hovers, from which truth was derived.

    Raises:
        InputError: none are left.
    """
    kept = {}
    for name, track in estimates.items():
        mask = ~during(hovers, track.stamps_ns)
        if mask.any():
            kept[name] = replace(
                track,
                stamps_ns=track.stamps_ns[mask],
                latitude=track.latitude[mask],
                longitude=track.longitude[mask],
                covariance=track.covariance[mask],
                measured=track.measured[mask],
            )
    if estimates and not kept:
        raise InputError(
            "all positions were published while the drone hovered over a robot, from which truth "
            "is derived, so nothing is left to compare; record the robots from the side as well, "
            "or give --truth."
        )
    return kept
