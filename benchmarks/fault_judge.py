# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Judges what became of a flight with a fault by the same flight without it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from itertools import permutations

import numpy as np
from fault_flights import DURATION_S, Flown
from scipy.optimize import linear_sum_assignment

from aerial_gnss_ros.core.values.estimates import FrameResult, State

CONFIDENT = 13.8
"""Squared distance that one in a thousand of a right planar covariance exceeds."""
OWN_S = 5.0
"""For so long after it is first published a name is taken to be on its own robot, s."""
COMMON_M, OWN_M = 3.0, 0.5
"""One sigma of the error that positions of one image share, and of each one's own, m."""
STEADY_S = 1.0
"""For so long all must be right for it to be right again, s."""
SETTLED_S = 3.0
"""Sigma is compared from so long after the fault's end on, s."""


@dataclass(frozen=True)
class Row:
    """One published position.

    Attributes:
        t: of the image's stamp, s since the flight's start.
        name: that is published.
        robot: that the name stands for.
        error_m: distance from that robot's true place, m.
        sigma_m: root of the mean variance of both axes, m.
        squared: squared Mahalanobis distance by the published covariance.
        confirmed: measured in this image, not predicted.
    """

    t: float
    name: str
    robot: int
    error_m: float
    sigma_m: float
    squared: float
    confirmed: bool

    @property
    def wrong(self) -> bool:
        """Whether it is confident and wrong; a number that is none is wrong as well."""
        return not self.squared <= CONFIDENT


@dataclass(frozen=True)
class Verdict:
    """What became of a flight with a fault.

    Attributes:
        rows, clean_rows: positions published from the fault's begin on, with it and without.
        during, clean_during: of these the measured ones until the fault's end.
        after, clean_after: the measured ones from its end on.
        wrong: rows that are confident and wrong and are not so without the fault.
        most_m: largest error of those, m; 0 without any.
        most_sigmas: largest Mahalanobis distance of any row.
        kept, names: names that are on the same robot at the end, of those published before.
        right_s: from the fault's end until all robots are measured and right again, s; NaN where
            they never are.
        sigma: median of the published sigma by that without the fault, from 3 s after its end on;
            NaN where nothing is published then.
        same: whether every position is exactly that of the flight without the fault.
    """

    rows: int
    clean_rows: int
    during: int
    clean_during: int
    after: int
    clean_after: int
    wrong: int
    most_m: float
    most_sigmas: float
    kept: int
    names: int
    right_s: float
    sigma: float
    same: bool

    def record(self) -> dict[str, object]:
        """Return it for a line of JSON, which has no NaN."""
        return {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in asdict(self).items()
        }


def rows_of(flight: Flown, results: Iterable[tuple[float, FrameResult]]) -> list[Row]:
    """Return the published positions of a flight.

    A stamp outside the flight is no time at which a robot was anywhere: the position is compared
    with where the robot is when it is published.

    Args:
        flight: without a fault, for the truth.
        results: each with the time at which it was published, s.
    """
    found = []
    start_ns = flight.boxes[0].stamp_ns - round(float(flight.times[0]) * 1e9)
    for published, result in results:
        t = (result.stamp_ns - start_ns) * 1e-9
        when = t if 0.0 <= t <= DURATION_S else published
        true = flight.truth(min(max(when, 0.0), DURATION_S))
        for one in result.estimates:
            here = flight.local.positions([one.latitude], [one.longitude])[0]
            found.append((t, one, here - true))
    robots = robots_of_names(
        (t, one.robot_id, one.state is State.CONFIRMED, apart) for t, one, apart in found
    )
    return [
        _row(t, one.robot_id, robots[one.robot_id], apart[robots[one.robot_id]],
             one.covariance[:2, :2], one.state is State.CONFIRMED)
        for t, one, apart in found
    ]  # fmt: skip


def _row(t: float, name: str, robot: int, error: np.ndarray, P: np.ndarray, confirmed: bool) -> Row:
    if np.isfinite(P).all() and np.linalg.eigvalsh(P)[0] > 0.0:
        squared = float(error @ np.linalg.solve(P, error))
    else:
        squared = math.inf
    sigma = math.sqrt(max(0.0, 0.5 * float(np.trace(P))))
    return Row(t, name, robot, float(np.hypot(*error)), sigma, squared, confirmed)


def robots_of_names(published: Iterable[tuple[float, str, bool, np.ndarray]]) -> dict[str, int]:
    """Return the robot that each name stands for: the nearest in the name's first seconds.

    The assignment over all names is one to one as far as there are robots. A name that comes later
    stands for whichever is nearest, where others are measured along with it by their formation: the
    receiver's error is common to all of them.

    Args:
        published: time of each position, its name, whether it is measured, and its offsets from the
            robots (robots, 2), m.
    """
    since: dict[str, float] = {}
    total: dict[str, list[np.ndarray]] = {}
    measured: dict[str, dict[float, np.ndarray]] = {}
    for t, name, confirmed, apart in published:
        if abs(t - since.setdefault(name, t)) <= OWN_S:
            total.setdefault(name, []).append(np.minimum(np.sum(apart**2, axis=1), 1e12))
        if confirmed:
            measured.setdefault(name, {})[t] = apart
    names = sorted(total)
    if not names:
        return {}
    cost = np.nan_to_num(np.array([np.mean(total[name], axis=0) for name in names]), nan=1e12)
    first = min(since.values())
    early = [i for i, name in enumerate(names) if since[name] <= first + OWN_S]
    given = {name: int(np.argmin(cost[i])) for i, name in enumerate(names)}
    for name in names:
        together = _together(name, since[name], measured)
        if len(together) > 1:
            given[name] = _in_formation(together)
    rows, columns = linear_sum_assignment(cost[early])
    given.update({names[early[i]]: int(k) for i, k in zip(rows, columns, strict=True)})
    return given


def _together(
    name: str, since: float, measured: dict[str, dict[float, np.ndarray]]
) -> list[np.ndarray]:
    """Return mean offsets (robots, 2) of a name in its first seconds, and of those beside it, m.

    Those count that are measured in most of the same images.
    """
    own = [t for t in measured.get(name, {}) if abs(t - since) <= OWN_S]
    others = [one for one in measured if one != name]
    beside = [one for one in others if own and 2 * sum(t in measured[one] for t in own) > len(own)]
    return [
        np.mean([measured[one][t] for t in own if t in measured[one]], axis=0)
        for one in [name, *beside]
        if own
    ]


def _in_formation(together: list[np.ndarray]) -> int:
    """Return which robot the first of some positions is of, measured in the same images.

    Args:
        together: of each position, its offsets (robots, 2), m; each is of another robot as far as
            there are robots.
    """
    offsets = np.array(together)[: len(together[0])]
    n = len(offsets)
    shared = COMMON_M**2 / (OWN_M**2 + n * COMMON_M**2)

    def squared(robots: tuple[int, ...]) -> float:
        chosen = offsets[np.arange(n), list(robots)]
        sums = chosen.sum(axis=0)
        return float(np.sum(chosen**2) - shared * sums @ sums)

    return min(permutations(range(offsets.shape[1]), n), key=squared)[0]


def judged(fault: list[Row], clean: list[Row], begin_s: float, end_s: float) -> Verdict:
    """Return what a fault did.

    Args:
        fault: positions of the flight with it.
        clean: of the flight without it.
        begin_s: of the fault, and
        end_s: of it, s since the flight's start.
    """
    base = {(_image(row), row.robot) for row in clean if row.wrong}
    ours = [row for row in fault if row.t >= begin_s - 0.05]
    theirs = [row for row in clean if row.t >= begin_s - 0.05]
    wrong = [row for row in ours if row.wrong and (_image(row), row.robot) not in base]
    kept, names = _names(fault, clean, begin_s)
    return Verdict(
        len(ours), len(theirs),
        *(sum(row.confirmed and row.t < end_s for row in rows) for rows in (ours, theirs)),
        *(sum(row.confirmed and row.t >= end_s for row in rows) for rows in (ours, theirs)),
        len(wrong),
        max((row.error_m for row in wrong), default=0.0),
        math.sqrt(max((row.squared for row in ours), default=0.0)),
        kept, names, _right_again(fault, clean, end_s), _sigmas(ours, theirs, end_s),
        [_key(row) for row in fault] == [_key(row) for row in clean],
    )  # fmt: skip


def _image(row: Row) -> int:
    return round(row.t * 1e3)


def _key(row: Row) -> tuple[object, ...]:
    return row.t, row.name, row.error_m, row.sigma_m, row.confirmed


def _names(fault: list[Row], clean: list[Row], begin_s: float) -> tuple[int, int]:
    """Return how many names are kept, and how many there are to keep.

    A name is to be kept where the flight without the fault has the same robot measured under one
    name before and in the last `OWN_S`. Where nothing is published before the fault (it is there
    from the start), a robot is to have any name at the end.
    """
    before = {row.name: row.robot for row in fault if row.t < begin_s}
    last_s = max((row.t for row in clean), default=0.0) - OWN_S
    end = {(row.name, row.robot) for row in clean if row.t > last_s and row.confirmed}
    wanted = {robot for name, robot in end if not before or before.get(name) == robot}
    found: dict[int, list[Row]] = {}
    for row in fault:
        if row.t > last_s and row.confirmed:
            found.setdefault(row.robot, []).append(row)
    kept = sum(
        any(not before or before.get(row.name) == robot for row in found.get(robot, []))
        and not all(row.wrong for row in found[robot])
        for robot in wanted
    )
    return kept, len(wanted)


def _right_again(fault: list[Row], clean: list[Row], end_s: float) -> float:
    """Return when every robot that is measured without the fault is so with it, and right, s."""
    good = {(_image(row), row.robot) for row in fault if row.confirmed and not row.wrong}
    base = {(_image(row), row.robot) for row in clean if row.wrong}
    good |= base
    images: dict[int, bool] = {}
    for row in clean:
        if row.t >= end_s and row.confirmed:
            key = _image(row)
            images[key] = images.get(key, True) and (key, row.robot) in good
    since: int | None = None
    for key in sorted(images):
        if not images[key]:
            since = None
        elif since is None:
            since = key
        if since is not None and key - since >= 1e3 * STEADY_S - 1.0:
            return max(0.0, since * 1e-3 - end_s)
    return math.nan


def _sigmas(fault: list[Row], clean: list[Row], end_s: float) -> float:
    usual = {(_image(row), row.robot): row.sigma_m for row in clean if row.confirmed}
    ratios = [
        row.sigma_m / usual[_image(row), row.robot]
        for row in fault
        if row.confirmed and row.t >= end_s + SETTLED_S and (_image(row), row.robot) in usual
    ]
    return float(np.median(ratios)) if ratios else math.nan
