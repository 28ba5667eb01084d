# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the fleet keeps of one drone: its errors' model, its camera's motion, its last image."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.filter.linearization import CameraView
from aerial_gnss_ros.core.filter.predicted_pixels import linearise
from aerial_gnss_ros.core.fleet.agreement import Agreement
from aerial_gnss_ros.core.fleet.fault import Fault
from aerial_gnss_ros.core.fleet.sighting import Sighting
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.georeferencing.measurements import EDGE
from aerial_gnss_ros.core.models.camera_motion import CameraMotion
from aerial_gnss_ros.core.models.measurement_model import POSE_COUNT
from aerial_gnss_ros.core.models.platform_model import COUNT, LATENCY, PlatformModel
from aerial_gnss_ros.core.numerics.normal_law import normal_share

Array = NDArray[np.float64]


class Drone:
    """One drone.

    Args:
        name: of the drone.
        config: of its estimator.
        clock_s: one sigma of its clock's offset to the first drone's, s.

    Attributes:
        name: likewise.
        references: objects of known position that its configuration states.
        model: of its errors.
        stationary: (9, 9) prior covariance of its errors, by its last fix.
        agreement: of its boxes with the other drones.
        fault: what is wrong with it, beyond the errors that it states; None: nothing known.
        suspected: whether it, or another one, is probably wrong, and which is not known.
        assumed: (9,) errors from which the filter begins: where a fault was found.
        last: its last sighting; None at first.
        view: the camera of that.
    """

    def __init__(self, name: str, config: EstimatorConfig, clock_s: float = 0.0) -> None:
        self.name, self.references = name, config.references
        self.model = PlatformModel(config.noise, config.gimbal.reference)
        self._clock_s = clock_s
        self.stationary = self._with_clock(self.model.stationary(None))
        self.agreement = Agreement()
        self.fault: Fault | None = None
        self.suspected = False
        self.assumed = np.zeros(COUNT)
        self.last: Sighting | None = None
        self.view: CameraView | None = None
        self._motion = CameraMotion()

    def state_receiver(self, seen: Sighting) -> None:
        """Take over the covariance that a fix states of itself."""
        stated = self._with_clock(self.model.stationary(seen.pose.fix_covariance))
        self.stationary = stated + np.diag(self.fault.variances) if self.fault else stated

    def _with_clock(self, stationary: Array) -> Array:
        """Return a prior covariance (9, 9) with the clock's variance (see `clocks`)."""
        found = stationary.copy()
        found[LATENCY, LATENCY] = self._clock_s**2
        return found

    def decay(self, seconds: float) -> Array:
        """Return the factors (9,) by which its errors decay until the next scene."""
        return self.model.decay(seconds)

    def jumped(self, seen: Sighting) -> bool:
        """Return whether the drone has come to believe a jump of its receiver."""
        return self.last is not None and not np.array_equal(self.last.believed, seen.believed)

    def look(self, seen: Sighting, local: LocalMap) -> CameraView:
        """Take in the pose of an image; return its camera for the filter.

        Args:
            seen: the image.
            local: the frame `map`.
        """
        passed = 0.0
        if self.last is not None:
            passed = (seen.pose.stamp_ns - self.last.pose.stamp_ns) * 1e-9
            if self.jumped(seen):
                self._motion.shift(np.array([*(seen.believed - self.last.believed), 0.0]))
        measured = MapPose.of(seen.pose, local)
        shown = MapPose(measured.position - seen.jump, measured.rotation)
        foretold = self._motion.update(shown, passed)
        noise = seen.pose.interpolation_noise(passed)
        # A clock that is ahead displaces robots, not the camera against its image.
        still = np.zeros(POSE_COUNT)
        self.view = CameraView.of(seen.camera, shown, still, 0.0, foretold, 0.0, noise)
        self.last = seen
        return self.view

    def recent(self, now_ns: int, patience_s: float) -> bool:
        """Return whether its last image is not older than some time."""
        return self.last is not None and now_ns - self.last.pose.stamp_ns <= patience_s * 1e9

    def shows(self, errors: Array, places: Array, spreads: Array) -> Array:
        """Return the probabilities (m,) that robots are well inside its last image.

        Args:
            errors: (9,) of the drone.
            places: (m, 2) of the robots, East, North, m.
            spreads: (m, 2, 2) covariances of these, m².
        """
        found = np.zeros(len(places))
        if self.view is None or not len(places):
            return found
        camera, linear = self.view.camera, linearise(self.view, errors, places)
        seen, pixels = linear.seen, linear.pixels[linear.seen]
        by_place = linear.by_place[seen]
        pixel = by_place @ spreads[seen] @ by_place.swapaxes(1, 2)
        wide = np.sqrt(np.einsum("maa->ma", pixel)) + 1e-9
        size = np.array([camera.width, camera.height])
        edge = EDGE * float(size.min())
        far, near = (size - edge - pixels) / wide, (edge - pixels) / wide
        inside = normal_share(far) - normal_share(near)
        found[seen] = np.maximum(inside, 0.0).prod(axis=1)
        return found
