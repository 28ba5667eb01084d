# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which robot a name stands for, by the boxes that it is used for.

Not by the nearest robot: receivers' offsets of metres are larger than what lies between robots.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

import numpy as np

from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.simulation.experiment import Experiment
from aerial_gnss_ros.simulation.sensors import START_NS

FIRST_S = 5.0
"""Time that is given to find out which robots are one, s."""

Used = list[tuple[str | None, int]]
"""Names, each with the number of the robot that a box shows; None: nobody's."""


def uses(
    made: Mapping[str, Experiment], told: Iterable[tuple[str, Sighting, Mapping[str, str] | None]]
) -> Used:
    """Return for each box from `FIRST_S` on the name it is used for, and the robot it shows.

    Args:
        made: drones by name.
        told: name of a drone, what it tells, and other names by its own; None: its own count.
    """
    frames = {name: {f.stamp_ns: f for f in one.frames()} for name, one in made.items()}
    used: Used = []
    for drone, seen, names in told:
        if (seen.stamp_ns - START_NS) * 1e-9 < FIRST_S:
            continue
        one = made[drone]
        true = one.projected(frames[drone][seen.stamp_ns])
        for label, pixel in zip(seen.labels, seen.pixels, strict=True):
            if label:
                nearest = int(np.square(true.centers - pixel).sum(axis=1).argmin())
                robot = one.swarm.names.index(true.names[nearest])
                used.append((label if names is None else names.get(label), robot))
    return used


def robots_by_name(used: Used) -> dict[str, int]:
    """Return the robot that each name is used for most often."""
    found = dict[str, int]()
    for (name, robot), _ in Counter(used).most_common():
        if name is not None:
            found.setdefault(name, robot)
    return found


def agreement(used: Used) -> float:
    """Return the share of uses in which the name stands for the robot, and is the robot's.

    A robot has one name: that which is used for it most often.
    """
    of_name, of_robot = robots_by_name(used), dict[int, str]()
    for (name, robot), _ in Counter(used).most_common():
        if name is not None:
            of_robot.setdefault(robot, name)
    right = sum(
        name is not None and of_name[name] == robot and of_robot[robot] == name
        for name, robot in used
    )
    return right / max(len(used), 1)
