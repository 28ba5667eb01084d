# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Track confirmation rule: number of measurements and time window, adapted to the image rate.

If images are so rare that `tracks.confirm_hits` of them do not fit into `tracks.confirm_window_s`,
no robot could be confirmed. Then the window is extended. But gates that have grown for so long also
admit clutter, so one more measurement is required (`test_confirmation_rule` has the effect). At
high image rates, consecutive images show the same glint: measurements are counted by the time
between them, not by images.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass

from aerial_gnss_ros.core.config.processing import TracksConfig


@dataclass(frozen=True)
class ConfirmationRuleTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    median_gaps: int = 5
    """Number of intervals between images whose median is used. Judged."""
    largest_stretch: float = 7.0
    """Greatest extension of the window, as a factor; rarer images confirm nothing. With the default
    rule that is an image every 3.5 s: a robot swims out of its gate between rarer ones. Judged."""
    glint_s: float = 0.04
    """Duration of a glint or a detector error, s: images closer together are no independent
    evidence. Judged."""


TUNING = ConfirmationRuleTuning()


class ConfirmationRule:
    """Adapts the rule to the image rate.

    Args:
        rules: configured rule.

    Attributes:
        hits: measurements that confirm a track.
        window_ns: time within which they must occur, ns.
        images: stamps of the images within that time, ns.
        first_ns: stamp of the first image, ns.
        interval_s: median time between images of late, s; infinite before the second one.
    """

    def __init__(self, rules: TracksConfig) -> None:
        self._stated_hits = self.hits = rules.confirm_hits
        self._stated_ns = self.window_ns = round(rules.confirm_window_s * 1e9)
        self.reset()

    def reset(self) -> None:
        """Forget all images."""
        self._last_ns: int | None = None
        self._gaps_ns: deque[int] = deque(maxlen=TUNING.median_gaps)
        self.hits, self.window_ns = self._stated_hits, self._stated_ns
        self.images: deque[int] = deque()
        self.first_ns = 2**63 - 1
        self.interval_s = math.inf

    def enough(self, hits: Iterable[int]) -> bool:
        """Return whether there are as many measurements as the rule requires.

        Args:
            hits: stamps of a track's measurements, ns, the oldest first; those within
                `TUNING.glint_s` count as one.
        """
        looks, last_ns = 0, -math.inf
        for stamp_ns in hits:
            if stamp_ns - last_ns >= TUNING.glint_s * 1e9:
                looks, last_ns = looks + 1, stamp_ns
        return looks >= self.hits

    def note(self, stamp_ns: int) -> None:
        """Record an image."""
        if self._last_ns is not None:
            self._gaps_ns.append(stamp_ns - self._last_ns)
            interval_ns = sorted(self._gaps_ns)[(len(self._gaps_ns) - 1) // 2]
            self.interval_s = interval_ns * 1e-9
            more = self._stated_hits + 1
            seldom = (self._stated_hits - 1) * interval_ns > self._stated_ns
            if seldom and more * interval_ns <= TUNING.largest_stretch * self._stated_ns:
                self.hits, self.window_ns = more, more * interval_ns
            else:
                self.hits, self.window_ns = self._stated_hits, self._stated_ns
        self._last_ns = stamp_ns
        while self.images and stamp_ns - self.images[0] > self.window_ns:
            self.images.popleft()
        self.images.append(stamp_ns)
        self.first_ns = min(self.first_ns, stamp_ns)
