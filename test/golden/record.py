# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The golden record: what replays of the bags beside it gave, and how a replay now differs.

python test/golden/record.py                compare; a table of the differences
python test/golden/record.py --bytes        the same, and whether tables are equal to the byte
python test/golden/record.py --write        record anew; prints the table of what changed

Names, states, refusals and stamps are to be equal on every processor, positions and sigmas to a
millimetre. Bytes are compared by a hash, which is that of the machine that recorded; processors
differ in the last bits.
"""

from __future__ import annotations

import argparse
import hashlib
import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.replay import Replay, no_detector
from aerial_gnss_ros.bags.results import position_row, rejection_row
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.detection.config import DetectorConfig

HERE = Path(__file__).resolve().parent
BAGS, RECORDS = HERE / "bags", HERE / "records"

_RTK = {"noise.gnss_offset_m": 0.02}
_LATE = {"noise.latency_s": 0.3}
_AIRFRAME = {
    "gimbal.reference": "body",
    "camera.offset_m": [0.3, -0.1, -0.2],
    "height.type": "pose",
    "height.stamp": "header",
    "fix.altitude_datum": "ellipsoid",
    "detections.classes": ["aqua"],
}
_STARTS = {
    "robots.leader.class": "aqua",
    "robots.leader.start": [13.1939, -59.641518],  # 2 m west of the origin
    "robots.follower.class": "aqua",
    "robots.follower.start": [13.193923, -59.6415],  # 2.5 m north
    "start_radius_m": 1.5,
}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "dives": ("dives", {}),
    "crossing": ("crossing", _STARTS),
    "crossing_single": ("crossing", {"method": "single"}),
    "crossing_paper": ("crossing", {"method": "paper"}),
    "glitch": ("glitch", _RTK),
    "jump": ("jump", {}),
    "runaway": ("runaway", _RTK),
    "many": ("many", {}),
    "airframe": ("airframe", _AIRFRAME | {"camera.latency_s": 0.2}),
    "airframe_late": ("airframe", _AIRFRAME | _LATE),
    "recorded": ("recorded", {}),
}
"""Each case's bag, and the parameters with which it is replayed."""

UNIT_DEG = 1e-9
"""A tenth of a millimetre of latitude: what a recorded position is a multiple of."""
UNIT_M = 1e-4
"""The same for sigmas, m, and velocities, m/s."""
SAME_M = 0.001
"""Largest difference that is none, m or m/s: other machines and releases round otherwise."""
DEG_M = math.pi / 180.0 * 6_378_137.0

COLUMNS = {
    "latitude": "i4", "longitude": "i4", "sigma_east": "i4", "sigma_north": "i4",
    "correlation": "i2", "velocity_east": "i4", "velocity_north": "i4",
}  # fmt: skip
"""Numbers of a row, in the units above; the correlation in 1e-4."""


@dataclass(frozen=True)
class Result:
    """What a replay gave.

    Attributes:
        rows: stamp in ns, name, class and state of each position, in the order of positions.csv.
        numbers: of each, by the names of `COLUMNS`.
        origin: latitude, longitude that positions count from, in 1e-9 deg.
        refused: stamp in ns, reason and pixel (u, v, whole) of each refused box.
        digest: SHA-256 of positions.csv's and rejected.csv's rows.
    """

    rows: list[tuple[int, str, str, str]]
    numbers: dict[str, np.ndarray]
    origin: tuple[int, int]
    refused: list[tuple[int, str, int, int]]
    digest: str


def replayed(case: str) -> Result:
    """Replay a case's bag, as `aerial-gnss replay` does."""
    name, values = CASES[case]
    with open_bag([BAGS / f"{name}.mcap"]) as bag:
        replay = Replay(bag, estimator_config(values), DetectorConfig(), no_detector)
        results = list(replay.results())
    estimates = [one for result in results for one in result.estimates]
    refusals = [one for result in results for one in result.rejections]
    positions = [
        position_row(one) for one in sorted(estimates, key=lambda e: (e.stamp_ns, e.robot_id))
    ]
    refused = [rejection_row(one) for one in sorted(refusals, key=lambda r: r.stamp_ns)]
    text = "\n".join(",".join(row) for row in [*positions, *refused])
    digest = hashlib.sha256(text.encode()).hexdigest()
    numbers, origin = _numbers(positions)
    return Result(
        [(int(row[0]), row[1], row[2], row[11]) for row in positions],
        numbers,
        origin,
        [(int(row[0]), row[1], round(float(row[2])), round(float(row[3]))) for row in refused],
        digest,
    )


def _numbers(rows: list[list[str]]) -> tuple[dict[str, np.ndarray], tuple[int, int]]:
    """Return the numbers of rows of positions.csv in recorded units, and the origin."""
    table = np.array([[float(row[i]) for i in (3, 4, 6, 7, 8, 9, 10)] for row in rows])
    table = table.reshape(-1, 7)
    places = np.round(table[:, :2] / UNIT_DEG)
    origin = places[0] if len(places) else np.zeros(2)
    east, north = np.sqrt(table[:, 2]), np.sqrt(table[:, 4])
    correlation = table[:, 3] / np.maximum(east * north, 1e-12)
    scaled = (
        *(places - origin).T, east / UNIT_M, north / UNIT_M, correlation / 1e-4,
        table[:, 5] / UNIT_M, table[:, 6] / UNIT_M,
    )  # fmt: skip
    numbers = {
        name: np.round(one).astype(kind)
        for (name, kind), one in zip(COLUMNS.items(), scaled, strict=True)
    }
    return numbers, (int(origin[0]), int(origin[1]))


def write(case: str, result: Result) -> None:
    """Keep a result; equal results give equal bytes."""
    RECORDS.mkdir(exist_ok=True)
    stamps = sorted({row[0] for row in result.rows} | {row[0] for row in result.refused})
    arrays: dict[str, np.ndarray] = {
        "stamps_ns": np.array(stamps, np.int64),
        "origin": np.array(result.origin, np.int64),
        "digest": np.array(result.digest),
    }
    for name, values in (
        ("row", [row[0] for row in result.rows]),
        ("refusal", [row[0] for row in result.refused]),
    ):
        arrays[f"{name}_image"] = np.searchsorted(stamps, values).astype(np.uint16)
    for name, texts in (
        ("name", [row[1] for row in result.rows]),
        ("class", [row[2] for row in result.rows]),
        ("state", [row[3] for row in result.rows]),
        ("reason", [row[1] for row in result.refused]),
    ):
        kinds = sorted(set(texts))
        arrays[f"{name}s"] = np.array(kinds or [""])
        arrays[name] = np.array([kinds.index(text) for text in texts], np.uint8)
    arrays["pixel"] = np.array([row[2:] for row in result.refused], np.int16).reshape(-1, 2)
    np.savez_compressed(RECORDS / f"{case}.npz", **arrays, **result.numbers)


def read(case: str) -> Result:
    """Return the recorded result."""
    with np.load(RECORDS / f"{case}.npz") as kept:
        stamps = kept["stamps_ns"]

        def texts(name: str) -> list[str]:
            return [str(text) for text in kept[f"{name}s"][kept[name]]]

        rows = zip(
            stamps[kept["row_image"]].tolist(), texts("name"), texts("class"), texts("state"),
            strict=True,
        )  # fmt: skip
        pixels = kept["pixel"].astype(np.int64)
        refused = zip(
            stamps[kept["refusal_image"]].tolist(), texts("reason"), pixels[:, 0].tolist(),
            pixels[:, 1].tolist(), strict=True,
        )  # fmt: skip
        east, north = kept["origin"].tolist()
        return Result(
            list(rows), {name: kept[name] for name in COLUMNS}, (east, north), list(refused),
            str(kept["digest"]),
        )  # fmt: skip


@dataclass(frozen=True)
class Difference:
    """How a result differs from the recorded one.

    Attributes:
        rows: recorded positions.
        lost: those that are no more (a name at an image).
        gained: new ones.
        names: that are on one side only.
        states: positions whose state or class changed.
        refused: refused boxes on one side only.
        place_m: largest change of a position, m.
        sigma_m: largest change of a sigma, m.
        sigma_share: the same as a share of it, where it changed by more than `SAME_M`.
        velocity_mps: largest change of a velocity, m/s.
        bytes_equal: whether tables are equal to the byte.
    """

    rows: int
    lost: int
    gained: int
    names: tuple[str, ...]
    states: int
    refused: int
    place_m: float
    sigma_m: float
    sigma_share: float
    velocity_mps: float
    bytes_equal: bool

    @property
    def same(self) -> bool:
        """Whether all is equal but for the last bits."""
        largest = max(self.place_m, self.sigma_m, self.velocity_mps)
        counts = self.lost + self.gained + len(self.names) + self.states + self.refused
        return counts == 0 and largest <= SAME_M


def difference(old: Result, new: Result) -> Difference:
    """Compare two results, a row with that of the same image and name."""
    before = {row[:2]: i for i, row in enumerate(old.rows)}
    after = {row[:2]: i for i, row in enumerate(new.rows)}
    both = [key for key in before if key in after]
    i, j = [before[key] for key in both], [after[key] for key in both]
    names = {row[1] for row in old.rows} ^ {row[1] for row in new.rows}
    place, sigma, share, velocity = 0.0, 0.0, 0.0, 0.0
    if both:
        a = {name: values[i].astype(np.float64) for name, values in old.numbers.items()}
        b = {name: values[j].astype(np.float64) for name, values in new.numbers.items()}
        shrink = math.cos(math.radians(old.origin[0] * UNIT_DEG))
        north = b["latitude"] - a["latitude"] + new.origin[0] - old.origin[0]
        east = b["longitude"] - a["longitude"] + new.origin[1] - old.origin[1]
        place = float(np.hypot(east * shrink, north).max()) * UNIT_DEG * DEG_M
        for name in ("sigma_east", "sigma_north"):
            change = np.abs(b[name] - a[name])
            sigma = max(sigma, float(change.max()) * UNIT_M)
            large = change * UNIT_M > SAME_M
            if large.any():
                share = max(share, float((change[large] / np.maximum(a[name][large], 1.0)).max()))
        for name in ("velocity_east", "velocity_north"):
            velocity = max(velocity, float(np.abs(b[name] - a[name]).max()) * UNIT_M)
    return Difference(
        len(old.rows), len(before) - len(both), len(after) - len(both), tuple(sorted(names)),
        sum(old.rows[k][2:] != new.rows[m][2:] for k, m in zip(i, j, strict=True)),
        len(_extra(old.refused, new.refused)), place, sigma, share, velocity,
        old.digest == new.digest,
    )  # fmt: skip


def _extra(
    old: list[tuple[int, str, int, int]], new: list[tuple[int, str, int, int]]
) -> list[tuple[int, str]]:
    """Return stamps and reasons of boxes refused on one side only; pixels count to 1 px."""
    left = sorted(old)
    extra: list[tuple[int, str]] = []
    for one in sorted(new):
        near = next(
            (
                other for other in left
                if other[:2] == one[:2] and abs(other[2] - one[2]) <= 1 >= abs(other[3] - one[3])
            ),
            None,
        )  # fmt: skip
        if near is None:
            extra.append(one[:2])
        else:
            left.remove(near)
    return extra + [one[:2] for one in left]


HEADS = (
    "case", "rows", "lost", "gained", "names changed", "states", "refusals", "position m",
    "sigma m", "sigma %", "velocity m/s", "bytes",
)  # fmt: skip


def row(case: str, one: Difference) -> str:
    """Return one line of the table."""
    cells = (
        case, one.rows, one.lost, one.gained, " ".join(one.names) or "–", one.states, one.refused,
        f"{one.place_m:.4f}", f"{one.sigma_m:.4f}", f"{100.0 * one.sigma_share:.1f}",
        f"{one.velocity_mps:.4f}", "equal" if one.bytes_equal else "differ",
    )  # fmt: skip
    return f"| {' | '.join(map(str, cells))} |"


def main() -> int:
    """Compare or record, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", help=f"of {', '.join(CASES)}; default: all")
    parser.add_argument("--bytes", action="store_true", help="fail where bytes differ, too")
    parser.add_argument("--write", action="store_true", help="record what the replays give now")
    given = parser.parse_args()
    unknown = sorted(set(given.cases) - set(CASES))
    if unknown:
        parser.error(f"there is no case {', '.join(unknown)}; there are {', '.join(CASES)}.")
    print(f"| {' | '.join(HEADS)} |\n|---|{'---:|' * (len(HEADS) - 1)}")
    failed = False
    for case in given.cases or CASES:
        new = replayed(case)
        if (RECORDS / f"{case}.npz").exists():
            found = difference(read(case), new)
            failed |= not found.same or (given.bytes and not found.bytes_equal)
            print(row(case, found), flush=True)
        else:
            failed = True
            print(f"| {case} | nothing recorded; {len(new.rows)} rows now |", flush=True)
        if given.write:
            write(case, new)
    return int(failed and not given.write)


if __name__ == "__main__":
    sys.exit(main())
