# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables of positions over time: those of a replay and of truth."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.adapters.table_files import table_rows
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.samples import Array
from aerial_gnss_ros.text.sentences import cut

POSITION_COLUMNS = (
    "stamp_ns", "robot_id", "class_id", "latitude_deg", "longitude_deg", "altitude_m",
    "var_east_m2", "cov_east_north_m2", "var_north_m2", "velocity_east_mps",
    "velocity_north_mps", "state",
)  # fmt: skip
STATES = (State.CONFIRMED.value, State.COASTING.value)


@dataclass(frozen=True)
class Track:
    """Positions of one robot, or of the drone, ordered by stamp.

    Attributes:
        stamps_ns: (n,) int64.
        latitude: (n,) rad.
        longitude: (n,) rad.
    """

    stamps_ns: NDArray[np.int64]
    latitude: Array
    longitude: Array

    def __len__(self) -> int:
        return len(self.stamps_ns)


@dataclass(frozen=True)
class EstimatedTrack(Track):
    """Published positions of one robot.

    Attributes:
        covariance: (n, 2, 2) East, North in m².
        measured: (n,) True where confirmed, False where coasting.
    """

    covariance: Array
    measured: NDArray[np.bool_]


def read_positions(path: Path) -> dict[str, EstimatedTrack]:
    """Read positions.csv.

    Returns:
        Tracks by robot id.

    Raises:
        InputError: the file is missing, or its columns are not those of a replay's result.
    """
    if not path.is_file():
        raise InputError(f"There is no {path}; give the folder that `aerial-gnss replay` wrote.")
    rows: dict[str, list[dict[str, str]]] = {}
    for line, row in table_rows(path, POSITION_COLUMNS, "the positions.csv of a replay"):
        if row["state"] not in STATES:  # the last column is the first to be cut off
            raise InputError(
                f"{path}, line {line}: state is {cut(row['state']) or 'missing'}, not "
                f"{' or '.join(STATES)}: the table was cut off or changed; replay again."
            )
        rows.setdefault(row["robot_id"], []).append(row)
    try:
        return {name: _track(rows[name]) for name in sorted(rows)}
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{path} has an invalid row: {cut(str(error))}.") from error


def _track(rows: list[dict[str, str]]) -> EstimatedTrack:
    def column(name: str) -> Array:
        return np.array([float(row[name]) for row in rows])

    cross = column("cov_east_north_m2")
    covariance = np.stack(
        [column("var_east_m2"), cross, cross, column("var_north_m2")], axis=-1
    ).reshape(-1, 2, 2)
    latitude, longitude = column("latitude_deg"), column("longitude_deg")
    if not (np.abs(latitude) <= 90.0).all() or not (np.abs(longitude) <= 180.0).all():
        raise ValueError("a position is not on Earth")
    if not np.isfinite(covariance).all():
        raise ValueError("a covariance is not finite")
    return EstimatedTrack(
        np.array([int(row["stamp_ns"]) for row in rows], dtype=np.int64),
        np.radians(latitude),
        np.radians(longitude),
        covariance,
        np.array([row["state"] == "confirmed" for row in rows]),
    )


def read_rejections(path: Path) -> Counter[str]:
    """Count the rejections in rejected.csv by reason; an absent file counts none.

    Raises:
        InputError: the file is not such a table.
    """
    if not path.is_file():
        return Counter()
    meant = "the rejected.csv of a replay"
    return Counter(row["reason"] for _, row in table_rows(path, ("reason",), meant))
