# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reports an input that never matches the images: it arrives late, or clocks differ."""

from __future__ import annotations

from collections.abc import Mapping

from aerial_gnss_ros.core.estimation.intake import LONG_S
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Input


class UnmatchedTelemetry:
    """Reports, once for each input, that it begins after an image, or ends before all of `LONG_S`.

    Args:
        max_wait: longest wait of images for telemetry, s.
        log: receives the sentences.
    """

    def __init__(self, max_wait: float, log: Events) -> None:
        self._max_wait = max_wait
        self._log = log
        self.reset()

    def reset(self) -> None:
        """Forget earlier images."""
        self._source: Input | None = None
        self._since_ns = 0

    def update(self, scene_ns: int, samples: object, newest_ns: Mapping[Input, int]) -> None:
        """Take in an image that waits no longer.

        Args:
            scene_ns: time of its scene, ns.
            samples: telemetry at that time, or what is missing.
            newest_ns: the newest time of each input when the image arrived, ns.
        """
        source = None
        if isinstance(samples, MissingTelemetry):
            source = _late_input(samples)
            if samples.later_s > self._max_wait:
                self._tell_later(samples)
        if source is None or source is not self._source:
            self._source, self._since_ns = source, scene_ns
        elif scene_ns - self._since_ns >= LONG_S * 1e9 and source in newest_ns:
            self._tell_earlier(source, (scene_ns - newest_ns[source]) * 1e-9)

    def _tell_later(self, samples: MissingTelemetry) -> None:
        name = samples.reason.value.removeprefix("no_")
        self._log.warn_once(
            f"later {name}",
            f"The oldest {name} is {samples.later_s:.1f} s later than an image, which is "
            f"refused ({samples.reason}). If it arrived no later, their clocks differ: "
            f"{name}.stamp selects a message's header or its arrival, and a bag played in a "
            "loop has headers that start again and arrivals that continue.",
        )

    def _tell_earlier(self, source: Input, earlier_s: float) -> None:
        # Measured at the arrival: while an image waits, newer samples hide part of the difference.
        self._log.warn_once(
            f"earlier {source}",
            f"All images of {LONG_S:.0f} s are refused (stale_{source}): when the last one "
            f"arrived, the newest {source} was {earlier_s:.1f} s earlier than it. If {source} "
            f"arrives at once, their clocks differ: {source}.stamp selects a message's header or "
            "its arrival. If it arrives late, raise max_wait. If it arrives no more, check its "
            "source.",
        )


def _late_input(samples: MissingTelemetry) -> Input | None:
    """Return the input that has arrived before, but not for this scene; None: none is late."""
    kind, _, name = samples.reason.value.partition("_")
    return Input(name) if kind == "stale" else None
