# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A recording for the page: overviews by time, recorded ones or those of a replay."""

from __future__ import annotations

import json
from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.adapters.overview import OVERVIEW
from aerial_gnss_ros.bags.drone_tables import DroneFlight, read_drones
from aerial_gnss_ros.bags.plan import resolve
from aerial_gnss_ros.bags.reader import BagReader
from aerial_gnss_ros.bags.replay import Replay
from aerial_gnss_ros.bags.results import OVERVIEW_STEP_NS
from aerial_gnss_ros.bags.tables import read_positions
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.text.json_text import parse_json
from aerial_gnss_ros.text.sentences import cut
from aerial_gnss_ros.view.scene import Paths

_KEYS = {"stamp_ns", "now_ns", "drone", "footprint", "robots", "references", "area", "lights"}


class Recording:
    """Overviews of a whole flight.

    Args:
        texts: JSON texts of overviews, in any order.
        title: what is shown, for the page.

    Raises:
        InputError: there is none, or one is damaged.
    """

    def __init__(self, texts: Sequence[str], title: str) -> None:
        found = sorted(
            ((checked(text), text) for text in texts), key=lambda one: one[0]["stamp_ns"]
        )
        if not found:
            raise InputError("the recording has no image with a result: there is nothing to show.")
        self._stamps = [fields["stamp_ns"] for fields, _ in found]
        self._texts = [text for _, text in found]
        self.title = title
        self.begin_ns, self.end_ns = self._stamps[0], self._stamps[-1]
        self.paths = Paths(self.begin_ns)
        for fields, _ in found:
            self.paths.add(fields)

    @property
    def opening_s(self) -> float:
        """The time to show first, s: that of the first image with a robot, if there is one."""
        times = [points[0][0] for points in self.paths.robots().values()]
        return min(times, default=0.0)

    def hello(self) -> dict[str, Any]:
        """Return what the page needs once."""
        return {
            "live": False,
            "title": self.title,
            "begin_ns": self.begin_ns,
            "end_ns": self.end_ns,
            "paths": self.paths.robots(),
            "drone_path": self.paths.drone(),
            "drone_paths": self.paths.drones(),
        }

    def at(self, seconds: float) -> dict[str, Any]:
        """Return the overview at a time since the beginning, with robots that were lost by then.

        Args:
            seconds: s; outside the recording counts as at its nearer end.
        """
        now_ns = self.begin_ns + round(seconds * 1e9)
        now_ns = min(max(now_ns, self.begin_ns), self.end_ns)
        fields = json.loads(self._texts[bisect_right(self._stamps, now_ns) - 1])
        return {
            **fields,
            "now_ns": now_ns,
            "silent_s": (now_ns - fields["stamp_ns"]) * 1e-9,
            "robots": [*fields["robots"], *self.paths.lost(fields, now_ns)],
        }


def checked(text: str) -> dict[str, Any]:
    """Return the fields of an overview.

    Raises:
        InputError: it is not one.
    """
    try:
        fields = parse_json(text)
    except ValueError as error:
        raise InputError(f"an overview is no JSON ({cut(str(error))}).") from error
    if not isinstance(fields, dict) or not fields.keys() >= _KEYS:
        raise InputError(f"the topic {OVERVIEW[0]} does not hold what this version writes there.")
    return fields


def recorded_overviews(bag: BagReader, namespace: str) -> list[str] | None:
    """Return the texts of the overviews in a bag; None if it has none.

    Args:
        bag: open.
        namespace: of the estimator; empty: also that of the only topic of this name.
    """
    topics = [
        name
        for name, topic in bag.topics.items()
        if topic.msgtype == OVERVIEW[1] and topic.count and name.endswith(f"/{OVERVIEW[0]}")
    ]
    wanted = resolve(OVERVIEW[0], namespace)
    if wanted not in topics:
        if namespace or not topics:
            return None
        if len(topics) > 1:
            raise InputError(f"the bag has {', '.join(topics)}; choose one drone with --namespace.")
        wanted = topics[0]
    return [str(recorded.message().data) for recorded in bag.messages({wanted})]


def tabled_overviews(table: Path) -> list[str]:
    """Return overviews made of positions.csv: without footprint and lights.

    Drones are in them if they are of a fleet: drones.csv has their paths.

    Args:
        table: of a result without recorded overviews.

    Raises:
        InputError: the table is damaged.
    """
    robots: dict[int, list[dict[str, Any]]] = {}
    for name, track in read_positions(table).items():
        seen_ns = 0
        places = np.degrees(np.stack([track.latitude, track.longitude], axis=-1)).round(9).tolist()
        for i, stamp_ns in enumerate(track.stamps_ns.tolist()):
            measured = bool(track.measured[i])
            seen_ns = stamp_ns if measured or not seen_ns else seen_ns
            (east, cross), (_, north) = track.covariance[i].tolist()
            one = {
                "id": name,
                "class": "",
                "state": str(State.CONFIRMED if measured else State.COASTING),
                "place": places[i],
                "covariance_m2": [east, cross, north],
                "velocity_mps": [None, None],
                "last_seen_ns": seen_ns,
                "depth_m": None,
                "pixel": None,
            }
            robots.setdefault(stamp_ns, []).append(one)
    unknown: dict[str, Any] = {"drone": None, "image_size": None}
    unknown |= {key: [] for key in ("footprint", "references", "area", "lights")}
    flights = read_drones(table.parent / "drones.csv")
    texts = []
    for stamp_ns, found in sorted(robots.items()):
        fields = {"stamp_ns": stamp_ns, "now_ns": stamp_ns, "robots": found, **unknown}
        if flights:
            fields["drones"] = _drones_at(flights, stamp_ns)
        texts.append(json.dumps(fields))
    return texts


def _drones_at(flights: Mapping[str, DroneFlight], stamp_ns: int) -> list[dict[str, Any]]:
    """Return each drone as of its last row not after a stamp; none before its first one."""
    found = []
    for name, flight in flights.items():
        row = int(np.searchsorted(flight.path.stamps_ns, stamp_ns, "right")) - 1
        if row < 0:
            continue
        own_ns = int(flight.path.stamps_ns[row])
        place = np.degrees([flight.path.latitude[row], flight.path.longitude[row]]).round(9)
        found.append({
            "name": name, "stamp_ns": own_ns, "place": place.tolist(), "height_m": None,
            "camera_heading_deg": None, "camera_below_horizon_deg": None, "footprint": [],
            "sees": [robot for robot, stamps in flight.seen.items() if own_ns in stamps],
        })  # fmt: skip
    return found


def replayed_overviews(flight: Replay, on_message: Callable[[int], None]) -> Iterator[str]:
    """Yield the overviews of a replay, five a second of flight.

    Args:
        flight: not begun.
        on_message: called with the number of messages read so far.

    Raises:
        InputError: as `Replay.results`.
    """
    last_ns: int | None = None
    for result in flight.results(on_message):
        if last_ns is None or abs(result.stamp_ns - last_ns) >= OVERVIEW_STEP_NS:
            last_ns = result.stamp_ns
            yield flight.overview(result)
