# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Identity scores: how well labels stay with their robots (IDF1, switches, HOTA).

IDF1, switches and misses come from motmetrics (MIT), a standard tool, if it is installed (extra
`[identity]`). HOTA (Luiten et al., IJCV 2021) is computed here: the released motmetrics lacks it,
and TrackEval would replace OpenCV and numpy. The error that all robots share in an image (GNSS
offset, compass) is removed first, because it is unrelated to identity.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.bags.tables import EstimatedTrack, Track
from aerial_gnss_ros.core.geometry.geodesy import enu_from_geodetic
from aerial_gnss_ros.core.numerics.linear_assignment import linear_sum_assignment
from aerial_gnss_ros.core.values.samples import Array
from aerial_gnss_ros.evaluation.errors import RobotErrors, at_stamps

ALPHAS = np.arange(0.05, 0.99, 0.05)
"""Similarities at which HOTA is taken; it is their mean."""
NEAR_M = 2.0
"""Distance beyond which a label does not match a robot, after removing the common error, m."""
ENOUGH = 3
"""Least number of robots in an image for which the median error is the common one."""
EXPLAINED = 13.8
"""NEES up to which the published covariance explains an error: 99.9 % of a planar normal law."""


@dataclass(frozen=True)
class Scene:
    """Robots and labels in one image.

    Attributes:
        robots: n true robots in view, by number.
        names: m published labels, by number.
        distances: (n, m) m.
    """

    robots: NDArray[np.intp]
    names: NDArray[np.intp]
    distances: Array


@dataclass(frozen=True)
class Identities:
    """Scores, 0 to 1, and counts; None without motmetrics.

    Attributes:
        hota: higher-order tracking accuracy; 1 is perfect.
        assa: its association part.
        deta: its detection part.
        idf1: share of images in which robots have their one label.
        switches: number of changes of a robot's label.
        fragmentations: number of interruptions of tracks.
        misses: robots in view without a label near them, over all images.
        false_names: labels without a robot near them, over all images.
        images: compared.
    """

    hota: float
    assa: float
    deta: float
    idf1: float | None
    switches: int | None
    fragmentations: int | None
    misses: int | None
    false_names: int | None
    images: int


def identities(
    estimates: Mapping[str, EstimatedTrack],
    truth: Mapping[str, Track],
    errors: list[RobotErrors],
    in_view: Mapping[str, NDArray[np.int64]] | None = None,
    near_m: float = NEAR_M,
) -> Identities | None:
    """Return the scores of published labels against true robots; None without common data.

    Args:
        estimates: published tracks; only measured positions count.
        truth: true tracks, at the images' stamps.
        errors: of `compare`, for the common error.
        in_view: image stamps at which each robot was in view; None: always.
        near_m: greatest distance of a match, m.
    """
    return scores(_scenes(estimates, truth, errors, in_view or {}), near_m)


def scores(scenes: list[Scene], near_m: float) -> Identities | None:
    """Return the scores of consecutive images; None without images.

    Args:
        scenes: robots and labels in each image.
        near_m: greatest distance of a match, m.
    """
    if not scenes:
        return None
    hota, assa, deta = hota_scores(scenes, near_m)
    counted = _motmetrics(scenes, near_m)
    return Identities(hota, assa, deta, *counted, len(scenes))


def hota_scores(scenes: list[Scene], near_m: float) -> tuple[float, float, float]:
    """Return HOTA, AssA and DetA, the means over `ALPHAS`; similarity is 1 - distance / near_m."""
    robots = 1 + max(int(s.robots.max(initial=-1)) for s in scenes)
    names = 1 + max(int(s.names.max(initial=-1)) for s in scenes)
    similar = [np.maximum(0.0, 1.0 - s.distances / near_m) for s in scenes]
    robot_count = np.zeros(robots)
    name_count = np.zeros(names)
    potential = np.zeros((robots, names))
    for scene, s in zip(scenes, similar, strict=True):
        total = s.sum(axis=0)[None] + s.sum(axis=1)[:, None] - s
        share = np.divide(s, total, out=np.zeros_like(s), where=total > 1e-12)
        potential[np.ix_(scene.robots, scene.names)] += share
        robot_count[scene.robots] += 1
        name_count[scene.names] += 1
    either = robot_count[:, None] + name_count[None]
    alignment = potential / np.maximum(either - potential, 1e-12)
    matches = np.zeros((len(ALPHAS), robots, names))
    for scene, s in zip(scenes, similar, strict=True):
        rows, columns = linear_sum_assignment(-alignment[np.ix_(scene.robots, scene.names)] * s)
        for a, alpha in enumerate(ALPHAS):
            good = s[rows, columns] >= alpha - 1e-12
            matches[a, scene.robots[rows[good]], scene.names[columns[good]]] += 1
    hits = matches.sum(axis=(1, 2))
    union = robot_count.sum() + name_count.sum() - hits
    deta = hits / np.maximum(union, 1.0)
    associated = matches / np.maximum(either[None] - matches, 1.0)
    assa = (matches * associated).sum(axis=(1, 2)) / np.maximum(hits, 1.0)
    return float(np.mean(np.sqrt(deta * assa))), float(assa.mean()), float(deta.mean())


def _scenes(
    estimates: Mapping[str, EstimatedTrack],
    truth: Mapping[str, Track],
    errors: list[RobotErrors],
    in_view: Mapping[str, NDArray[np.int64]],
) -> list[Scene]:
    names, robots = sorted(estimates), sorted(truth)
    if not names or not robots:
        return []
    stamps = np.unique(np.concatenate([*(e.stamps_ns for e in estimates.values()),
                                       *in_view.values()]))  # fmt: skip
    origin = float(truth[robots[0]].latitude[0]), float(truth[robots[0]].longitude[0])
    true = np.full((len(stamps), len(robots), 2), np.nan)
    for i, robot in enumerate(robots):
        latitude, longitude, known = at_stamps(truth[robot], stamps)
        if in_view:
            known = known & np.isin(stamps, in_view.get(robot, []))
        true[known, i] = _plane(latitude[known], longitude[known], origin)
    found = np.full((len(stamps), len(names), 2), np.nan)
    for j, name in enumerate(names):
        track = estimates[name]
        rows = np.searchsorted(stamps, track.stamps_ns[track.measured])
        found[rows, j] = _plane(
            track.latitude[track.measured], track.longitude[track.measured], origin
        )
    found -= _common(stamps, errors)[:, None]
    scenes = []
    for t in range(len(stamps)):
        here = np.flatnonzero(np.isfinite(true[t, :, 0]))
        there = np.flatnonzero(np.isfinite(found[t, :, 0]))
        if len(here) or len(there):
            apart = true[t, here][:, None] - found[t, there][None]
            scenes.append(Scene(here, there, np.hypot(apart[..., 0], apart[..., 1])))
    return scenes


def _common(stamps: NDArray[np.int64], errors: list[RobotErrors]) -> Array:
    """Return the robots' common error at each stamp, (n, 2) m; 0 if unknown.

    It is the median, so that one mislabelled robot does not affect the others. With one or two
    robots the median would contain the mislabelled robot's error and hide it, so there an error
    counts only if the published covariance explains it.
    """
    found = np.full((len(errors), len(stamps), 2), np.nan)
    explained = np.zeros(found.shape[:2], dtype=bool)
    for row, robot in enumerate(errors):
        at = np.searchsorted(stamps, robot.stamps_ns)
        found[row, at] = robot.east_north
        explained[row, at] = robot.nees <= EXPLAINED
    few = np.isfinite(found[..., 0]).sum(axis=0) < ENOUGH
    found[~explained & few] = np.nan
    with warnings.catch_warnings():  # of stamps without any
        warnings.simplefilter("ignore", RuntimeWarning)
        middle: Array = np.nanmedian(found, axis=0) if len(errors) else found.sum(axis=0)
    return np.nan_to_num(middle)


def _plane(latitude: Array, longitude: Array, origin: tuple[float, float]) -> Array:
    zeros = np.zeros(len(latitude))
    return enu_from_geodetic(latitude, longitude, zeros, *origin, 0.0)[:, :2]


def _motmetrics(
    scenes: list[Scene], near_m: float
) -> tuple[float | None, int | None, int | None, int | None, int | None]:
    try:
        import motmetrics  # type: ignore[import-untyped,unused-ignore]
    except ImportError:
        return None, None, None, None, None
    accumulator = motmetrics.MOTAccumulator(auto_id=True)
    with warnings.catch_warnings():  # about its use of pandas
        warnings.simplefilter("ignore")
        for scene in scenes:
            near = np.where(scene.distances <= near_m, scene.distances, np.nan)
            accumulator.update(scene.robots, scene.names, near)
        wanted = ["idf1", "num_switches", "num_fragmentations", "num_misses", "num_false_positives"]
        row = motmetrics.metrics.create().compute(
            accumulator, metrics=wanted, return_dataframe=False
        )
    counts = (int(row[name]) for name in wanted[1:])
    switches, fragments, misses, false = counts
    return float(row["idf1"]), switches, fragments, misses, false
