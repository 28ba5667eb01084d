# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Targets that write: names of robots, messages, maps and tables, read back by strict parsers."""

from __future__ import annotations

import csv
import io
import json
import math
import random
import re
from collections.abc import Callable
from xml.etree import ElementTree as ET

import numpy as np

from aerial_gnss_ros.adapters.results import result_messages
from aerial_gnss_ros.bags.maps import geojson, gpx, kml
from aerial_gnss_ros.bags.results import position_row
from aerial_gnss_ros.bags.tables import POSITION_COLUMNS
from aerial_gnss_ros.bags.typestore import serialize
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.identity.label_format import LabelRegistry, class_token
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum, RobotEstimate, State
from fuzz import mutate
from fuzz.engine import OUTPUT, Broken
from fuzz.files import allowed

Report = Callable[[str], None]
_ROBOT_ID = re.compile(r"[a-z][a-z0-9]*(_[a-z0-9]+)*")
_FORMULA = ("=", "+", "-", "@", "\t", "\r")


class RobotNames:
    """Class names from the detector, and names and starts of robots from the configuration."""

    name, weight, block = "names", 6, 100

    def begin(self, _block: int, _rng: random.Random) -> None:
        """Nothing is kept from case to case."""

    def case(self, rng: random.Random, report: Report) -> None:
        """Name robots of damaged classes."""
        class_id = mutate.text(rng, mutate.text(rng, rng.choice(("aqua", "boat_2", ""))))
        report(repr(class_id[:200]))
        names = LabelRegistry(frozenset({"aqua_1"}))
        given = [names.next(class_id) for _ in range(3)]
        for name in (class_token(class_id), *given):
            if not _ROBOT_ID.fullmatch(name):
                raise Broken(OUTPUT, f"no name of a topic: {name[:200]!r}")
        if len(set(given)) != 3:
            raise Broken(OUTPUT, f"name given twice: {given}")
        start = [mutate.number(rng, 13.2), mutate.number(rng, -59.6)]
        name = mutate.text(rng, "leader")
        values: object = rng.choice((
            {name: {"class": class_id, "start": start}}, {name: start}, {name: class_id}, name,
            {name: {"class": start, "start": class_id}}, {name: {"start": start * 2, "class": "a"}},
        ))  # fmt: skip
        allowed(lambda: estimator_config({"robots": values, "map.latitude_deg": start[0]}))


class Written:
    """Results whose class names and numbers are as bad as they can be, in every form of output."""

    name, weight, block = "outputs", 6, 100

    def begin(self, _block: int, _rng: random.Random) -> None:
        """Nothing is kept from case to case."""

    def case(self, rng: random.Random, report: Report) -> None:
        """Write results and read them back."""
        class_id = mutate.text(rng, mutate.text(rng, "aqua"))
        report(repr(class_id[:200]))
        names = LabelRegistry()
        track = [_estimate(rng, names.next(class_id), class_id)]
        track += [_moved(rng, track[0]) for _ in range(rng.randrange(3))]
        datum = MapDatum(track[0].latitude, track[0].longitude, track[0].altitude)
        for estimate in track:
            result = FrameResult(estimate.stamp_ns, "camera", (estimate,), (), datum)
            for message in result_messages(result):
                serialize(message.msgtype, message.fields)
        tracks = {track[0].robot_id: track}
        _check_xml("GPX", gpx(tracks))
        _check_xml("KML", kml(tracks))
        json.loads(geojson(tracks), parse_constant=_refuse_constant)
        _check_table(track)


def _check_xml(what: str, text: str) -> None:
    try:
        ET.fromstring(text.encode())  # noqa: S314 - written here
    except ET.ParseError as error:
        raise Broken(OUTPUT, f"{what} is not XML: {error}") from error


def _refuse_constant(name: str) -> None:
    raise Broken(OUTPUT, f"GeoJSON holds {name}")


def _check_table(track: list[RobotEstimate]) -> None:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(map(position_row, track))
    rows = list(csv.reader(io.StringIO(text.getvalue(), newline="")))
    if any(len(row) != len(POSITION_COLUMNS) for row in rows) or len(rows) != len(track):
        raise Broken(OUTPUT, f"positions.csv has other rows than written: {rows}")
    for row in rows:
        for cell in (row[1], row[2]):
            if cell.startswith(_FORMULA):
                raise Broken(OUTPUT, f"a spreadsheet would compute it: {cell[:80]!r}")


def _estimate(rng: random.Random, robot_id: str, class_id: str) -> RobotEstimate:
    spread = 10.0 ** rng.uniform(-3.0, 3.0)
    root = np.array([[rng.gauss(0.0, 1.0) for _ in range(4)] for _ in range(4)])
    covariance = spread * (root @ root.T + 1e-6 * np.eye(4))
    return RobotEstimate(
        stamp_ns=rng.randrange(-(2**31), 2**31) * 10**9 + rng.randrange(10**9),
        robot_id=robot_id,
        class_id=class_id,
        state=rng.choice((State.CONFIRMED, State.COASTING)),
        latitude=rng.choice((0.5 * math.pi, -0.5 * math.pi, 0.0, rng.uniform(-1.5, 1.5))),
        longitude=rng.choice((math.pi, -math.pi, 0.0, rng.uniform(-3.1, 3.1))),
        altitude=rng.choice((math.nan, -40.0, 1e-9, 9e3)),
        position=np.array([rng.gauss(0.0, 1e3), rng.gauss(0.0, 1e3)]),
        velocity=np.array([rng.choice((0.0, 1e-12, rng.gauss(0.0, 1.0))), rng.gauss(0.0, 1.0)]),
        covariance=covariance,
        last_seen_ns=0,
    )


def _moved(rng: random.Random, one: RobotEstimate) -> RobotEstimate:
    return _estimate(rng, one.robot_id, one.class_id)


def targets() -> list[RobotNames | Written]:
    """Return the targets that write."""
    return [RobotNames(), Written()]
