# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Statistics of one input's messages: number, rate, delay, and why some were unusable."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np


@dataclass
class InputRecord:
    """Statistics of one input's messages.

    Attributes:
        count: messages.
        bad: number of unusable messages.
        trouble: why the last of them was unusable.
        first_arrival_ns: of the first message, ns.
        last_arrival_ns: of the newest, ns.
        last_stamp_ns: its stamp, ns.
        delays_ns: arrival less stamp of the newest messages with trusted stamps, ns.
    """

    count: int = 0
    bad: int = 0
    trouble: str = ""
    first_arrival_ns: int = 0
    last_arrival_ns: int = 0
    last_stamp_ns: int = 0
    delays_ns: deque[int] = field(default_factory=lambda: deque(maxlen=500))

    def refuse(self, trouble: str) -> None:
        """Count an unusable message; `trouble` says why."""
        self.bad += 1
        self.trouble = trouble

    def undo_refusal(self) -> None:
        """Take back a refusal: the message is usable after all."""
        self.bad -= 1
        self.trouble = self.trouble if self.bad else ""

    @property
    def rate(self) -> float:
        """Messages a second; 0 with fewer than two."""
        span = (self.last_arrival_ns - self.first_arrival_ns) * 1e-9
        return (self.count - 1) / span if self.count > 1 and span > 0.0 else 0.0

    @property
    def delay_s(self) -> float:
        """Median delay from stamp to arrival, s."""
        return float(np.median(self.delays_ns)) * 1e-9 if self.delays_ns else 0.0
