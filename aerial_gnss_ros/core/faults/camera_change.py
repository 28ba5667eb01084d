# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Changes of the camera model in flight: does the image change with it?

A zoom changes boxes and description (CameraInfo) together. A description that changes alone is
wrong, or corrects a wrong one. Robots in view distinguish them: after a zoom their boxes fit the
new description, otherwise the previous one. A correction contradicts robots that were located with
the wrong description, and is recognised by lasting longer than a fault.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.models.evidence import CLEAR_NATS
from aerial_gnss_ros.core.values.events import Events


@dataclass(frozen=True)
class CameraChangeTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    corrected_s: float = 10.0
    """Time after which a new description counts as a correction, s: that of a height
    (`limits.height_settle_s`). Judged."""


TUNING = CameraChangeTuning()


class CameraChange:
    """Chooses the description for each image."""

    def __init__(self, log: Events) -> None:
        self._log = log
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._known: CameraModel | None = None  # from before a change, if any
        self._since_ns: int | None = None
        self._against = 0.0

    def update(
        self, given: CameraModel, stamp_ns: int, misfit: Callable[[CameraModel], float]
    ) -> CameraModel:
        """Return the description to locate an image's boxes with.

        Args:
            given: the newest one.
            stamp_ns: of the image.
            misfit: returns the negative log likelihood of the image's boxes with a description,
                nats.
        """
        known = self._known
        if known is None or given is known or _alike(given, known):
            return self._use(given)
        self._since_ns = stamp_ns if self._since_ns is None else self._since_ns
        if not 0 <= stamp_ns - self._since_ns < TUNING.corrected_s * 1e9:
            if self._against > CLEAR_NATS:
                self._log.add(
                    f"The camera's description has been different for {TUNING.corrected_s:.0f} s "
                    "and is used from now on, although boxes fitted the previous one."
                )
            return self._use(given)
        against = self._against + misfit(given) - misfit(known)
        # Errors of consecutive images are alike, so that their sum is bounded.
        self._against = min(against, 2.0 * CLEAR_NATS)
        if against < -CLEAR_NATS:
            return self._use(given)
        if against < CLEAR_NATS:
            return given
        self._log.warn_once(
            "camera contradicted",
            "The camera's description (CameraInfo) has changed, but the boxes fit the previous "
            f"one, which stays in use for up to {TUNING.corrected_s:.0f} s. A zoom changes both: "
            "check the camera's driver.",
        )
        return known

    def _use(self, camera: CameraModel) -> CameraModel:
        self._known, self._since_ns, self._against = camera, None, 0.0
        return camera


def _alike(one: CameraModel, other: CameraModel) -> bool:
    """Return whether two descriptions are equal."""
    plain = (one.width, one.height, one.model, one.rectified)
    return plain == (other.width, other.height, other.model, other.rectified) and all(
        np.array_equal(getattr(one, name), getattr(other, name)) for name in ("K", "D", "R")
    )
