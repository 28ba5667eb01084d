# SPDX-License-Identifier: Apache-2.0
"""The HTML report: one file, no scripts, nothing loaded from elsewhere."""

from __future__ import annotations

import base64
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.evaluation.errors import RobotErrors, Summary, summarise
from aerial_gnss_ros.evaluation.picture import error_png, map_png


@dataclass(frozen=True)
class Report:
    """What the report shows.

    Attributes:
        title: heading.
        notes: sentences under the heading, such as that the images are simulated.
        estimates: published tracks by robot id.
        truth: true tracks by truth id; empty when unknown.
        drone: the drone's path, or None.
        rejections: rejected detections by reason.
        methods: errors by method name; the first is the one that was published.
        pictures: caption and JPEG or PNG bytes.
        facts: name and value, such as duration and model.
    """

    title: str
    notes: Sequence[str]
    estimates: Mapping[str, EstimatedTrack]
    truth: Mapping[str, Track]
    drone: Track | None
    rejections: Counter[str]
    methods: Mapping[str, list[RobotErrors]]
    pictures: Sequence[tuple[str, bytes]] = ()
    facts: Sequence[tuple[str, str]] = field(default_factory=tuple)


def write_report(path: Path, report: Report) -> None:
    """Write the report as one HTML file that a browser opens without a network."""
    environment = Environment(
        loader=PackageLoader("aerial_gnss_ros.evaluation"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["metres"] = metres
    pictures = [("Map: tracks, last 95 % ellipses, truth dashed.",
                 map_png(report.estimates, report.truth, report.drone))]  # fmt: skip
    if any(len(robot.stamps_ns) for robots in report.methods.values() for robot in robots):
        pictures.append(("Horizontal error over time, by method.", error_png(report.methods)))
    pictures.extend(report.pictures)
    text = environment.get_template("report.html").render(
        report=report,
        last=[_last(name, track) for name, track in report.estimates.items()],
        methods=[(name, _rows(robots)) for name, robots in report.methods.items()],
        pictures=[(caption, _data_url(content)) for caption, content in pictures],
    )
    path.write_text(text, encoding="utf-8")


def _rows(robots: list[RobotErrors]) -> list[tuple[str, str, float, Summary]]:
    rows = [(r.truth_id, r.robot_id, r.coverage, summarise([r])) for r in robots]
    mean = float(np.mean([r.coverage for r in robots])) if robots else math.nan
    return [*rows, ("all", "", mean, summarise(robots))]


def _last(name: str, track: EstimatedTrack) -> dict[str, str]:
    sigma = math.sqrt(float(np.trace(track.covariance[-1])) / 2.0)
    return {
        "name": name,
        "latitude": f"{math.degrees(track.latitude[-1]):.7f}",
        "longitude": f"{math.degrees(track.longitude[-1]):.7f}",
        "sigma": metres(sigma),
        "count": str(int(track.measured.sum())),
        "state": "measured" if track.measured[-1] else "coasting",
    }


def metres(value: float) -> str:
    """Return a length in metres with two decimals, or a dash where there is none."""
    return "–" if math.isnan(value) else f"{value:.2f}"


def _data_url(content: bytes) -> str:
    kind = "png" if content.startswith(b"\x89PNG") else "jpeg"
    return f"data:image/{kind};base64,{base64.b64encode(content).decode('ascii')}"
