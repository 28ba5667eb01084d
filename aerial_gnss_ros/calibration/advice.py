# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Advice on the next flight for constants that a flight did not determine."""

from __future__ import annotations

from aerial_gnss_ros.calibration.fit import Fit

ORBIT = "orbit a still robot once, at a distance of one to two heights, looking at it"
_ADVICE = {
    "latency": "fly back and forth past a still robot at 3 m/s or more: a delay shifts positions "
    "in opposite directions on both legs",
    "fix_latency": "fly back and forth past a still robot at 3 m/s or more, near and far",
    "heading": ORBIT,
    "gimbal_pitch": ORBIT,
    "gimbal_roll": ORBIT,
    "height": ORBIT,
    "focal": "hover beside a still robot and tilt the gimbal up and down for half a minute, so "
    "that the robot crosses the image from top to bottom and back",
}
_AGAIN = {
    "gimbal_pitch": "at twice the distance, which separates pitch from height",
    "gimbal_roll": "with the robot first at the left of the image, then at the right",
    "height": "at half the height, which separates height from pitch",
}


def advice(fit: Fit) -> list[str]:
    """Return one sentence for each flight needed; none if all constants are determined."""
    wanted: dict[str, list[str]] = {}
    for name in fit.names:
        if not fit.determined(name):
            wanted.setdefault(_ADVICE[name], []).append(name)
    return [_sentence(what, names) for what, names in wanted.items()]


def _sentence(what: str, names: list[str]) -> str:
    words = [name.replace("_", " ") for name in names]
    listed = " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
    more = [f"once more {_AGAIN[name]}" for name in names if name in _AGAIN]
    return f"for {listed}: {'; then '.join([what, *more])}."
