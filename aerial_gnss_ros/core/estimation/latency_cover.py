# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""By how much positions are less certain while the latency may be another one.

What was tracked with the wrong latency is where the box would be seen from the camera of another
time. The cameras of the last seconds say where that is for each larger latency, exactly, however
the drone moves: no derivative is used. A negative latency's camera is still to come: it is taken to
move on as it has within as long before now, on a line or around a circle. Each counts by its
probability, given what images have said so far: the second moment of the mixture about what is
published. Where things of known position correct all robots, what displaces these as well is
corrected.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.geometry.geodesy import on_water_surface
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.values.estimates import RobotEstimate

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LatencyCoverTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    apart_s: float = 0.1
    """Least time between the cameras that are kept, s: the step of candidate latencies."""
    least_past_s: float = 0.5
    """Time from which on past cameras say how those before them moved, s. Judged."""
    least_depression: float = 0.05
    """Sine of the angle below the horizon from which another camera is taken to see the water: a
    box nearer to the horizon says nothing of how far it is. Judged."""


TUNING = LatencyCoverTuning()


class LatencyCover:
    """Remembers cameras, and says what other latencies make of positions.

    Args:
        corrections: (h,) candidate latencies less the configured one, ascending, s.
        elsewhere: probability before any image that the latency is another one than configured.
    """

    def __init__(self, corrections: Array, elsewhere: float) -> None:
        self._early, self._late, self._elsewhere = corrections < 0.0, np.abs(corrections), elsewhere
        self.weigh(np.zeros(len(corrections)))
        self.forget()

    def weigh(self, gains: Array) -> None:
        """Take over how likely latencies are.

        Args:
            gains: (h,) log likelihood of each over the configured one, whose own is 0.
        """
        weights = self._elsewhere / (len(gains) - 1) * np.exp(gains)
        weights[int(np.argmin(self._late))] = 1.0 - self._elsewhere
        self._probabilities: Array = weights / weights.sum()

    def forget(self) -> None:
        """Forget the cameras so far: `map` or telemetry are others now."""
        self._cameras: deque[tuple[float, MapPose]] = deque()
        self._now_s, self._camera = 0.0, MapPose(np.zeros(3), np.eye(3))
        self._corrects: frozenset[str] = frozenset()

    def note(self, scene: PosedFrame, corrects: Mapping[str, str]) -> None:
        """Note the camera of an image.

        Args:
            scene: the image.
            corrects: label of the robot that each reference is which corrects its positions.
        """
        labels = frozenset(corrects.values())
        self.add(1e-9 * scene.detections.stamp_ns, scene.in_map, labels)

    def add(self, time_s: float, camera: MapPose, corrects: frozenset[str] = frozenset()) -> None:
        """Note the camera of an image's scene, with the configured latency.

        Args:
            time_s: of the scene, s.
            camera: measured.
            corrects: labels of the things of known position that correct robots.
        """
        self._now_s, self._camera, self._corrects = time_s, camera, corrects
        kept = self._cameras
        if kept and time_s < kept[-1][0]:
            kept.clear()
        if not kept or time_s - kept[-1][0] >= TUNING.apart_s:
            kept.append((time_s, camera))
        while len(kept) > 1 and time_s - kept[1][0] > self._late.max():
            kept.popleft()

    def widened(self, estimates: Sequence[RobotEstimate]) -> list[RobotEstimate]:
        """Return robots with covariances that contain what other latencies make of positions."""
        found = []
        fixed = [i for i, one in enumerate(estimates) if one.robot_id in self._corrects]
        more = self._spread(estimates, fixed)
        for one, wider in zip(estimates, more, strict=True):
            covariance = one.covariance.copy()
            covariance[:2, :2] += wider
            found.append(replace(one, covariance=covariance))
        return found

    def _spread(self, estimates: Sequence[RobotEstimate], fixed: list[int]) -> Array:
        """Return second moments (n, 2, 2) of other latencies' positions about some, m².

        Args:
            estimates: n robots.
            fixed: which of them correct the others.
        """
        if not self._cameras or self._now_s - self._cameras[0][0] < TUNING.least_past_s:
            return np.zeros((len(estimates), 2, 2))
        off = self._displacements(estimates)
        if fixed:
            off = off - off[:, fixed].mean(axis=1, keepdims=True)
        return np.asarray(np.einsum("h,hni,hnj->nij", self._probabilities, off, off))

    def _displacements(self, estimates: Sequence[RobotEstimate]) -> Array:
        """Return how far (h, n, 2) from where they are latencies show n robots, m."""
        points = on_water_surface(np.array([one.position for one in estimates]).reshape(-1, 2))
        now = self._camera
        places, turns, later, turned = self._other_cameras()
        before, after = (
            _displaced(points, now, *cameras) for cameras in ((places, turns), (later, turned))
        )
        return self._at_latencies(before, after)

    def _other_cameras(self) -> tuple[Array, Array, Array, Array]:
        """Return places (m, 3), m, and axes (m, 3, 3) of past cameras, and of as many to come."""
        places = np.array([one.position for _, one in self._cameras])
        turns = np.array([one.rotation for _, one in self._cameras])
        now = self._camera
        # What moved the camera from there to here moves it on from here.
        onward = turns.swapaxes(1, 2) @ (now.position - places)[..., None]
        later = now.position + (now.rotation @ onward)[..., 0]
        return places, turns, later, now.rotation @ turns.swapaxes(1, 2) @ now.rotation

    def _at_latencies(self, before: Array, after: Array) -> Array:
        """Return (h, n, 2) at all latencies what is known (m, n, 2) of other cameras, m.

        Args:
            before: of the past ones.
            after: of as many to come.
        """
        past_s = np.array([self._now_s - time_s for time_s, _ in self._cameras])
        late, early = (self._interpolated(past_s, apart) for apart in (before, after))
        return np.where(self._early[:, None, None], early, late)

    def _interpolated(self, past_s: Array, apart: Array) -> Array:
        """Return (h, n, 2) at all latencies what is known at times (m,) before now, m."""
        if past_s[-1] > 0.0:
            past_s = np.append(past_s, 0.0)
            apart = np.concatenate([apart, np.zeros((1, *apart.shape[1:]))])
        past_s, apart = past_s[::-1], apart[::-1]
        # Before the first camera it moved on as from there to now.
        known = np.minimum(self._late, past_s[-1])
        beyond = self._late / np.maximum(known, TUNING.apart_s)
        after = np.clip(np.searchsorted(past_s, known), 1, len(past_s) - 1)
        part = (known - past_s[after - 1]) / (past_s[after] - past_s[after - 1])
        part, beyond = part[:, None, None], np.maximum(beyond, 1.0)[:, None, None]
        return np.asarray(beyond * ((1.0 - part) * apart[after - 1] + part * apart[after]))


def _displaced(points: Array, camera: MapPose, places: Array, turns: Array) -> Array:
    """Return how far (m, n, 2) other cameras show points (n, 3) from where a camera does, m.

    Args:
        points: on the water, in `map`, m.
        camera: that one.
        places: (m, 3) of the others, m.
        turns: (m, 3, 3) of the others, camera FLU in `map`.
    """
    turn = turns @ camera.rotation.T
    rays = np.einsum("mij,nj->mni", turn, points - camera.position)
    length = np.linalg.norm(rays, axis=2)
    down = np.maximum(-rays[..., 2], TUNING.least_depression * length)
    reach = (places[:, None, 2] - points[:, 2]) / down
    shown = places[:, None, :2] + rays[..., :2] * reach[..., None]
    return np.asarray(shown - points[:, :2])
