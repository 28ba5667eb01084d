# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The result of a calibration: constants, their covariance, and whether they are determined."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.calibration.excitation import Excitation

Array = NDArray[np.float64]

STAYS_MPS = 0.02
"""Speed below which a robot counts as one that stays, m/s."""


@dataclass(frozen=True)
class Unknown:
    """A constant that is estimated.

    Attributes:
        name: latency, fix_latency, heading, gimbal_pitch, gimbal_roll, height or focal.
        unit: s, deg, m or %.
        scale: factor from SI to the unit.
        enough: greatest sigma that counts as determined, in the unit.
    """

    name: str
    unit: str
    scale: float
    enough: float


UNKNOWNS = (
    Unknown("latency", "s", 1.0, 0.025),
    Unknown("fix_latency", "s", 1.0, 0.025),
    Unknown("heading", "deg", math.degrees(1.0), 0.75),
    Unknown("gimbal_pitch", "deg", math.degrees(1.0), 0.3),
    Unknown("gimbal_roll", "deg", math.degrees(1.0), 0.5),
    Unknown("height", "m", 1.0, 0.25),
    Unknown("focal", "%", 100.0, 1.0),
)


@dataclass(frozen=True)
class Fit:
    """Result of a calibration.

    Attributes:
        names: of the constants, in the order of `mean`.
        mean: corrections in SI units (rad, m, s; logarithm of the focal scale).
        covariance: of `mean`.
        residual_px: one sigma of the boxes' white noise, px.
        boxes: used.
        outliers: number of boxes far from the fit, which have less weight.
        images: used.
        robots: class and number, the most frequently seen first.
        flown: excitation of the flight.
        speeds_mps: root mean square of each robot's velocity.
        ambiguities: why a constant is undetermined whatever its sigma, by its name.
        misfit: sentences on why the boxes do not fit; then nothing may be used.
    """

    names: tuple[str, ...]
    mean: Array
    covariance: Array
    residual_px: float
    boxes: int
    outliers: int
    images: int
    robots: tuple[str, ...]
    flown: Excitation
    speeds_mps: tuple[float, ...] = ()
    ambiguities: dict[str, str] = field(default_factory=dict)
    misfit: tuple[str, ...] = ()

    def value(self, name: str) -> tuple[float, float]:
        """Return correction and one sigma in the unit of `UNKNOWNS`."""
        at = self.names.index(name)
        scale = unknown(name).scale
        return float(self.mean[at]) * scale, math.sqrt(float(self.covariance[at, at])) * scale

    def determined(self, name: str) -> bool:
        """Whether a constant is known well enough to be used."""
        if self.misfit or name in self.ambiguities:
            return False
        if "latency" in self.ambiguities:
            return False  # all other constants were estimated at that latency
        if name == "fix_latency" and not self.determined("latency"):
            return False  # it is relative to the latency
        return self.value(name)[1] <= unknown(name).enough

    def moved(self) -> str:
        """Return which robots stayed and how fast the others swam, as text."""
        robots = [
            f"{name} {'stayed' if speed < STAYS_MPS else f'swam at {speed:.2f} m/s'}"
            for name, speed in zip(self.robots, self.speeds_mps, strict=True)
        ]
        return ", ".join(robots)

    def correlation(self, name: str) -> tuple[str, float]:
        """Return the constant most correlated with this one, and the correlation."""
        sigma = np.sqrt(np.diag(self.covariance))
        at = self.names.index(name)
        row = self.covariance[at] / (sigma * sigma[at])
        row[at] = 0.0
        other = int(np.argmax(np.abs(row)))
        return self.names[other], float(row[other])


def unknown(name: str) -> Unknown:
    """Return the description of a constant."""
    return next(one for one in UNKNOWNS if one.name == name)
