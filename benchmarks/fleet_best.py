# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A fleet's errors beside those of the best estimate of the same telemetry and boxes.

What receivers err by in common no filter can know: it is the same for all, and large. So a few
flights say little about a filter's error, but much about how far it is from the best estimate; see
`evaluation/best_estimate.py`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from fleet_flights import LAST_S, true_drone
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.values.estimates import FrameResult, RobotEstimate
from aerial_gnss_ros.evaluation.best_estimate import MeasuredFrame, best_estimates
from aerial_gnss_ros.evaluation.bound import TrueDrone
from aerial_gnss_ros.simulation.experiment import Experiment
from aerial_gnss_ros.simulation.sensors import START_NS

Array = NDArray[np.float64]

_METRES = ("gnss_east", "gnss_north", "height")
_DEGREES = ("gimbal_roll", "gimbal_pitch", "heading")


@dataclass(frozen=True)
class Beside:
    """Means over a flight's end.

    Attributes:
        best: squared error of the best estimate, m².
        best_nees: its normalised squared error of a degree of freedom, by the bound.
        expected: squared error of the fleet that is expected, given what was measured, m².
        nees: the same of its normalised squared error of a degree of freedom.
        bound: trace of the bound, m².
    """

    best: float
    best_nees: float
    expected: float
    nees: float
    bound: float


def beside_best(
    made: Mapping[str, Experiment],
    configs: Mapping[str, EstimatorConfig],
    results: Mapping[str, Sequence[FrameResult]],
    published: Sequence[tuple[str, int, tuple[RobotEstimate, ...]]],
    share: float,
    robots: Mapping[str, int],
    last_s: float = LAST_S,
) -> Beside:
    """Return how the best estimate and the fleet compare.

    Args:
        made: drones by name.
        configs: of their estimators.
        results: of each drone's own estimator, which have the poses of telemetry.
        published: by the fleet, and after which drone's image: its name and stamp, ns.
        share: true part of the variance of the receivers' offsets that is common.
        robots: number of the robot that a name stands for; other names do not count.
        last_s: length of the end that counts, s.
    """
    lead = next(iter(made.values()))
    local = LocalMap(lead.flight.origin)
    measured = [measured_frames(one, results[name]) for name, one in made.items()]
    drones = [
        with_boxes(true_drone(one, configs[name]), of)
        for (name, one), of in zip(made.items(), measured, strict=True)
    ]
    best = dict(zip(made, best_estimates(drones, measured, local, share), strict=True))
    images = {
        name: {f.stamp_ns: k for k, f in enumerate(one.frames())} for name, one in made.items()
    }
    begin_ns = START_NS + round((lead.flight.duration_s - last_s) * 1e9)
    found = list[list[float]]()
    for name, stamp_ns, estimates in published:
        if not estimates or estimates[0].stamp_ns < begin_ns:
            continue
        true = lead.swarm.positions([(estimates[0].stamp_ns - START_NS) * 1e-9])[:, 0, :2]
        k = images[name][stamp_ns]
        for estimate in estimates:
            robot = robots.get(estimate.robot_id)
            if robot is None:
                continue
            place = local.positions([estimate.latitude], [estimate.longitude])[0]
            error = best[name].positions[k, robot] - true[robot]
            limit = best[name].covariances[k, robot]
            apart = place - best[name].positions[k, robot]
            stated = estimate.covariance[:2, :2]
            found.append([
                float(error @ error),
                0.5 * float(error @ np.linalg.solve(limit, error)),
                float(np.trace(limit) + apart @ apart),
                0.5 * float(np.trace(np.linalg.solve(stated, limit + np.outer(apart, apart)))),
                float(np.trace(limit)),
            ])  # fmt: skip
    return Beside(*np.mean(found, axis=0).tolist())


def with_boxes(drone: TrueDrone, measured: Sequence[MeasuredFrame]) -> TrueDrone:
    """Return a drone that sees only robots with a box: noise puts some outside the image."""
    frames = [
        replace(frame, seen=frame.seen & np.isfinite(one.pixels[:, 0]))
        for frame, one in zip(drone.frames, measured, strict=True)
    ]
    return replace(drone, frames=frames)


def measured_frames(one: Experiment, results: Sequence[FrameResult]) -> list[MeasuredFrame]:
    """Return what a drone measured of each image: its telemetry's pose, true errors and boxes."""
    times = np.array([frame.t for frame in one.frames()])
    metres = np.column_stack([one.sensors.error(name, times) for name in _METRES])
    angles = np.radians(np.column_stack([one.sensors.error(name, times) for name in _DEGREES]))
    errors = -np.column_stack([metres, angles, np.zeros(len(times))])
    poses = {result.stamp_ns: result.pose for result in results}
    found = []
    for k, (frame, boxes, detected) in enumerate(one.detections()):
        pose = poses[frame.stamp_ns]
        pixels = np.full((len(one.swarm.names), 2), np.nan)
        if pose is None:  # no telemetry yet: as if it had no boxes
            found.append(MeasuredFrame(one.true_pose(frame), errors[k], pixels))
            continue
        apart = np.linalg.norm(boxes.centers[:, None] - detected.centers[None], axis=2)
        for row, column in zip(*linear_sum_assignment(apart), strict=True):
            pixels[one.swarm.names.index(boxes.names[row])] = detected.centers[column]
        found.append(MeasuredFrame(pose, errors[k], pixels))
    return found
