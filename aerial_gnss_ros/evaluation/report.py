# Copyright 2026 aerial_gnss_ros developers
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

from aerial_gnss_ros.bags.drone_tables import DroneFlight
from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.core.values.rejection import Cause, Reason
from aerial_gnss_ros.evaluation.errors import RobotErrors, Summary, summarise
from aerial_gnss_ros.evaluation.identity import Identities
from aerial_gnss_ros.evaluation.platform import PlatformError, platform_png
from aerial_gnss_ros.evaluation.unseen import unseen
from aerial_gnss_ros.text.sentences import counted


@dataclass(frozen=True)
class Report:
    """Content of a report.

    Attributes:
        title: heading.
        notes: sentences under the heading, such as that the images are simulated.
        estimates: published tracks by robot id.
        truth: true tracks by truth id; empty when unknown.
        drone: the drone's path, or None.
        rejections: rejected detections by reason.
        drones: of a fleet, in place of `drone`.
        causes: `unconfirmed` detections by the reason why their tracks were not confirmed.
        methods: errors by method name; the first is the published one.
        pictures: caption and JPEG or PNG bytes.
        facts: name and value, such as duration and model.
        identity: scores of the first method, or None.
        platform: errors that the filter estimated, by name; may be empty.
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
    identity: Identities | None = None
    platform: Mapping[str, PlatformError] = field(default_factory=dict)
    causes: Counter[Cause] = field(default_factory=Counter)
    drones: Mapping[str, DroneFlight] = field(default_factory=dict)


@dataclass(frozen=True)
class Picture:
    """A picture of the report: name of a file, caption, PNG or JPEG."""

    name: str
    caption: str
    content: bytes


def write_report(path: Path, report: Report, drawn: Sequence[Picture] | None = None) -> None:
    """Write the report as one HTML file that a browser opens without a network.

    Args:
        path: the file.
        report: what it shows.
        drawn: its figures, if `draw` has already been called.
    """
    environment = Environment(
        loader=PackageLoader("aerial_gnss_ros.evaluation"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["metres"] = metres
    pictures = draw(report) if drawn is None else drawn
    methods = [(name, _rows(robots)) for name, robots in report.methods.items()]
    text = environment.get_template("report.html").render(
        report=report,
        meanings={str(reason): reason.meaning for reason in Reason},
        last=[_last(name, track) for name, track in report.estimates.items()],
        methods=methods,
        by_method=[(name, *rows[-1][1:]) for name, rows in methods],
        figures=[] if not methods else key_figures(methods[0][1][-1], report.identity),
        pictures=[(p.caption, _data_url(p.content)) for p in pictures],
        extra=[(caption, _data_url(content)) for caption, content in report.pictures],
    )
    path.write_text(text, encoding="utf-8", errors="replace")  # file names may be invalid Unicode


def draw(report: Report) -> list[Picture]:
    """Return the report's own pictures; the first is the map."""
    # Matplotlib takes long to import, and a report may have no pictures.
    from aerial_gnss_ros.evaluation.figures import (
        axes_png,
        frames_png,
        methods_png,
        range_png,
        unseen_png,
    )
    from aerial_gnss_ros.evaluation.picture import colours
    from aerial_gnss_ros.evaluation.seen_by import seen_by_png
    from aerial_gnss_ros.evaluation.track_map import map_png

    found = [
        Picture(
            "map.png",
            "Map. Each ellipse contains its robot with a probability of 95 %. A coasting robot may "
            "leave the map."
            + (" Dotted lines: robots in a drone's last image." if report.drones else ""),
            map_png(report.estimates, report.truth, report.drone, report.drones),
        )
    ]
    seen_by = seen_by_png(report.drones, colours(report.estimates))
    if seen_by is not None:
        caption = "Which drone saw which robot."
        found.append(Picture("seen_by.png", caption, seen_by))
    compared = {
        name: robots
        for name, robots in report.methods.items()
        if any(len(robot.stamps_ns) for robot in robots)
    }
    if compared:
        robots, shades = next(iter(compared.values())), _shades(report)
        found += [
            Picture(
                "error_over_frames.png", "Haversine error over frames.", frames_png(robots, shades)
            ),
            Picture(
                "latitude_longitude_error.png",
                "Latitude and longitude error over frames. With consistent covariances 95 % are "
                "between the dashed lines, over many flights.",
                axes_png(robots, shades),
            ),
        ]
        by_range = range_png(robots, shades)
        if by_range is not None:
            caption = "Error against the distance from the drone."
            found.append(Picture("error_against_range.png", caption, by_range))
        by_time = unseen_png(unseen(robots, report.estimates, report.truth), shades)
        if by_time is not None:
            caption = "Error of predicted positions against the time since their robot was seen."
            found.append(Picture("error_unseen.png", caption, by_time))
    if len(compared) > 1:
        caption = "Horizontal error over time, by method."
        found.append(Picture("error_by_method.png", caption, methods_png(compared, shades)))
    if report.platform:
        caption = (
            "The platform's errors as the filter estimates them, with one and two sigma: "
            "corrections to be added to measured values."
        )
        found.append(Picture("platform_errors.png", caption, platform_png(report.platform)))
    return found


def _shades(report: Report) -> dict[str, str]:
    """Return colours by true robot: those of its published label on the map."""
    from aerial_gnss_ros.evaluation.picture import GREY, colours

    published = colours(report.estimates)
    robots = next(iter(report.methods.values()), [])
    return {robot.truth_id: published.get(robot.robot_id, GREY) for robot in robots}


def key_figures(
    row: tuple[str, str, float, Summary], identity: Identities | None
) -> list[tuple[str, str, str]]:
    """Return value, name and meaning of the key figures."""
    _, _, coverage, s = row
    if not s.count:
        return []
    found = [
        (f"{s.median:.2f} m", "CEP", "half of the positions are closer to truth"),
        (f"{s.ce90:.2f} m", "CE90", "nine in ten are closer"),
        (f"{s.rmse:.2f} m", "RMSE", "root mean square of the distance"),
        (f"{s.nees:.2f}", "NEES", "about 2 over many flights; a single one says little"),
        (
            f"{100 * coverage:.0f} %",
            "availability",
            "share of the time with a position within 0.5 s",
        ),
    ]
    if identity is not None and identity.idf1 is not None:
        found.append(
            (f"{identity.idf1:.3f}", "IDF1", counted(identity.switches or 0, "identity switch"))
        )
    elif identity is not None:
        found.append((f"{identity.hota:.3f}", "HOTA", "1: every robot keeps one label"))
    return found


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
    """Return a length in metres with two decimals, or a dash for NaN."""
    return "–" if math.isnan(value) else f"{value:.2f}"


def _data_url(content: bytes) -> str:
    kind = "png" if content.startswith(b"\x89PNG") else "jpeg"
    return f"data:image/{kind};base64,{base64.b64encode(content).decode('ascii')}"
