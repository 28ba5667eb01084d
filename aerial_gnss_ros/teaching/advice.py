# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameters that follow from labels and from a taught detector's scores, as YAML."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from aerial_gnss_ros.detection.anomaly import ANOMALY
from aerial_gnss_ros.teaching.session import Session
from aerial_gnss_ros.teaching.tracks import Sight

Lengths = Mapping[str, tuple[float, float]]
"""Shortest and longest length of each class, m."""

FEWEST_LENGTHS, FEWEST_SCORES = 10, 20
"""Boxes of a robot, and scores of robots, below which nothing is said."""
_BORDER_PX = 3.0  # a box so near to the image's border may be cut
_LONG = 90.0  # percentile of a robot's longer sides that counts as its length: it turns
_OTHERS = 0.25  # robots of a class that was not seen may be so much shorter or longer, relative
_LOW_SCORES = 10.0  # percentile of the scores on robots


def lengths(session: Session) -> dict[str, tuple[float, float]]:
    """Return the lengths of the classes of which there are enough whole boxes with a camera.

    A box's longer side is at most the robot's length, and is near it where the robot lies across
    the line of sight: as `apparent_size.py` judges it.

    Args:
        session: with labels.
    """
    found: dict[str, list[float]] = {}
    width, height = session.recording.size
    for robot, of_frame in session.tracks.items():
        own = []
        for frame, track in of_frame.items():
            view = session.recording.views[frame]
            x, y, w, h = track.box
            room = min(x - w / 2.0, y - h / 2.0, width - x - w / 2.0, height - y - h / 2.0)
            if view is not None and track.sight is Sight.SURE and room > _BORDER_PX:
                own.append(view.longer_side(track.box))
        known = np.array(own)[np.isfinite(own)]
        if len(known) >= FEWEST_LENGTHS:
            length = float(np.percentile(known, _LONG))
            found.setdefault(session.project.classes[robot], []).append(length)
    return {
        name: (round(min(of) / (1.0 + _OTHERS), 2), round(max(of) * (1.0 + _OTHERS), 2))
        for name, of in found.items()
    }


def least_score(scores: Sequence[float] | NDArray[np.float64], threshold: float) -> float:
    """Return a `tracks.confirm_score` that nearly all boxes on robots exceed; 0: not known.

    Args:
        scores: of boxes on robots that were kept aside.
        threshold: of boxes.
    """
    if len(scores) < FEWEST_SCORES:
        return 0.0
    low = float(np.floor(100.0 * np.percentile(scores, _LOW_SCORES)) / 100.0)
    return low if low > threshold else 0.0


def parameters(network: Path, threshold: float, confirm_score: float, known: Lengths) -> str:
    """Return what belongs into the parameters of detector and estimator.

    Args:
        network: its file.
        threshold: least score of a box.
        confirm_score: see `least_score`.
        known: lengths of classes.
    """
    lines = [
        "/**/detector:",
        "  ros__parameters:",
        f"    model: {ANOMALY}",
        f"    second_look: {json.dumps(str(network.resolve()), ensure_ascii=False)}",
        f"    score_threshold: {threshold:g}",
    ]
    if known:
        lines += ["/**/estimator:", "  ros__parameters:", "    classes:"]
        lines += [
            f"      {_key(name)}: {{length_m: [{low:g}, {high:g}]}}"
            for name, (low, high) in known.items()
        ]
    if confirm_score:
        lines += [
            "# Where much else floats; on other water your robot may score lower, and be lost:"
        ]
        lines += [] if known else ["# /**/estimator:", "#   ros__parameters:"]
        lines += [f"#     tracks: {{confirm_score: {confirm_score:g}}}"]
    return "\n".join(lines) + "\n"


def _key(name: str) -> str:
    """Return a name as a YAML key, quoted where it reads as something else (no, 1, a: b)."""
    try:
        plain = yaml.safe_load(f"{name}: 0") == {name: 0}
    except yaml.YAMLError:
        plain = False
    return name if plain else json.dumps(name, ensure_ascii=False)
