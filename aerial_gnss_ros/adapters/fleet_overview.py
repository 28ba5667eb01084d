# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a fleet says of its drones, as JSON: topic `drones`, and `overview` for the page."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters.overview import DroneInFleet, Light, overview_text
from aerial_gnss_ros.core.fleet.shore import Link
from aerial_gnss_ros.core.georeferencing.footprint import outline
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.core.values.overview import Overview

DRONES = ("drones", "std_msgs/msg/String")


def drone_values(link: Link) -> dict[str, Any]:
    """Return what there is to say of a drone, by name; m, s; NaN for what is not known."""
    nothing = (math.nan, math.nan)
    report = None if link.update is None else link.update.report
    offset = nothing if report is None else report.offset.tolist()
    sigma = nothing if report is None else report.offset_sigma.tolist()
    return {
        "agreement": math.nan if report is None else report.agreement,
        "shared_robots": 0 if report is None else report.shared,
        "offset_east_m": offset[0],
        "offset_north_m": offset[1],
        "sigma_east_m": sigma[0],
        "sigma_north_m": sigma[1],
        "disagrees": report is not None and report.disagrees,
        "fault": "" if report is None else report.fault,
        "clock_ahead_s": math.nan if report is None else report.clock.ahead_s,
        "clock_sigma_s": math.nan if report is None else report.clock.sigma_s,
        "delay_s": link.delay_s,
        "missing": link.gaps.missing,
        "lost": link.gaps.lost,
        "repeated": link.gaps.repeated,
        **{f"refused_{reason}": count for reason, count in sorted(link.refused.items())},
    }


def drones_text(stamp_ns: int, links: Iterable[Link]) -> str:
    """Return the message; `names` maps a drone's own names to the fleet's.

    Args:
        stamp_ns: of the fleet's newest result, ns.
        links: to the drones.
    """
    drones = [
        {
            "drone": link.drone,
            "namespace": link.source,
            **{name: _plain(value) for name, value in drone_values(link).items()},
            "names": {} if link.update is None else link.update.names,
        }
        for link in links
    ]
    return json.dumps({"version": 1, "stamp_ns": stamp_ns, "drones": drones})


def fleet_overview_text(
    result: FrameResult, now_ns: int, links: Iterable[Link], lights: Sequence[Light] = ()
) -> str:
    """Return the overview of a fleet: its robots, and each drone with what its camera shows.

    Args:
        result: of the fleet.
        now_ns: the clock by which ages count, ns.
        links: to the drones.
        lights: of the fleet.
    """
    count = len(result.estimates)
    unknown = np.full((count, 2), np.nan)
    seen = Overview(replace(result, pose=None), np.empty((0, 2)), unknown, unknown[:, 0])
    drones = [
        DroneInFleet(
            link.drone,
            link.seen.stamp_ns,
            link.seen.pose,
            outline(link.seen.pose, link.seen.camera, link.config.surface.max_range),
            tuple(link.update.names[one] for one in link.seen.labels if one in link.update.names),
        )
        for link in links
        if link.seen is not None and link.update is not None
    ]
    return overview_text(seen, now_ns, (), lights, drones)


def _plain(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value
