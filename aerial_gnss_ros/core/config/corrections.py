# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters that correct measurements: calibration of the platform, depth of the robots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.schema import key
from aerial_gnss_ros.core.values.errors import ConfigError


@dataclass(frozen=True)
class CalibrationConfig:
    """Constant errors, as `aerial-gnss calibrate` finds them: true = measured + correction."""

    heading_deg: float = key(
        0.0,
        "Added to the measured heading of body and camera, counter-clockwise seen from above. 1 "
        "deg is 0.5 m at 30 m.",
        unit="deg",
        low=-180.0,
        high=180.0,
        dynamic=True,
    )
    gimbal_pitch_deg: float = key(
        0.0,
        "Added to the camera's pitch; positive looks farther down. 1 deg is 1.2 m at 30 m range "
        "and 45 deg.",
        unit="deg",
        low=-45.0,
        high=45.0,
        dynamic=True,
    )
    gimbal_roll_deg: float = key(
        0.0,
        "Added to the camera's roll about its level direction of view; positive lowers the right.",
        unit="deg",
        low=-45.0,
        high=45.0,
        dynamic=True,
    )
    height_m: float = key(
        0.0,
        "Added to the measured height above the water.",
        unit="m",
        low=-100.0,
        high=100.0,
        dynamic=True,
    )
    focal_scale: float = key(
        1.0,
        "Ratio of the true focal length to the stated one. 0.01 more is 1 % of a robot's distance "
        "from the image centre.",
        low=0.5,
        high=2.0,
        dynamic=True,
    )


@dataclass(frozen=True)
class DepthConfig:
    """Robots below the surface; refraction by Snell's law. 1 m ignored is 0.85 m wrong at 60 deg.

    The published position is that of the robot, its altitude that of the water above it.
    """

    robots_m: float = key(
        0.0, "Depth of the robots' visible middle below the surface.", unit="m", low=0.0, high=20.0
    )
    classes: tuple[str, ...] = key(
        (), "Depth of single classes in m instead, such as [aqua=0.8, boat=0]."
    )
    topics: tuple[str, ...] = key(
        (),
        "std_msgs/Float64 topics with depths in m, 0 or more, from robots that send them: [depth] "
        "for all robots, or of single classes [aqua_red=aqua_red/depth].",
    )
    max_age: float = key(
        10.0,
        "A depth from a topic is used for this long, then those above apply again. A larger value "
        "bridges gaps, but keeps the depth of a robot that has surfaced.",
        unit="s",
        low=0.1,
        high=3600.0,
    )
    sigma_m: float = key(
        0.0,
        "One sigma of the depth, an error that lasts for minutes. It enters the published "
        "covariance along the line of sight: 0.85 of it at 60 deg off the vertical.",
        unit="m",
        low=0.0,
        high=10.0,
    )

    def of(self, class_ids: Sequence[str]) -> NDArray[np.float64]:
        """Return the depths (n,) of robots by their class names, m.

        Raises:
            ConfigError: an entry of `classes` is not name=metres.
        """
        by_class = self.by_class()
        return np.array([by_class.get(name, self.robots_m) for name in class_ids], np.float64)

    def by_topic(self) -> dict[str, str]:
        """Return the topics of depths by class name; an empty name stands for all classes.

        Raises:
            ConfigError: an entry of `topics` has no topic, or two are for one class.
        """
        found: dict[str, str] = {}
        for entry in self.topics:
            name, _, topic = (part.strip() for part in entry.rpartition("="))
            if not topic or name in found:
                raise ConfigError(
                    "depth.topics must hold one topic for all robots, such as depth, or one a "
                    f"class, such as aqua_red=aqua_red/depth, not {list(self.topics)}."
                )
            found[name] = topic
        return found

    def by_class(self) -> dict[str, float]:
        """Return the depths of single classes by name, m.

        Raises:
            ConfigError: an entry of `classes` is not name=metres within 0 to 20.
        """
        found = {}
        for entry in self.classes:
            name, _, text = entry.rpartition("=")
            try:
                metres = float(text)
            except ValueError:
                metres = -1.0
            if not name or not 0.0 <= metres <= 20.0:
                raise ConfigError(
                    f"depth.classes must hold entries such as aqua=0.8, 0 to 20 m, not {entry!r}."
                )
            found[name.strip()] = metres
        return found
