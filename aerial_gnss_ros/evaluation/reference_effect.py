# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The positions that a reference corrected."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from aerial_gnss_ros.bags.tables import EstimatedTrack

_LEAST_SHARE = 0.5
"""A reference that corrects at least halves the variance: it takes away the receiver's offset."""


def while_corrected(
    tracks: Mapping[str, EstimatedTrack], without: Mapping[str, EstimatedTrack]
) -> tuple[dict[str, EstimatedTrack], float]:
    """Return the positions of images in which most had at most half the variance, and their share.

    Args:
        tracks: positions by robot, with references.
        without: positions of the same flight without them.
    """
    whole, less = _variances(without), _variances(tracks)
    shared = less.keys() & whole.keys()
    corrected = [at for at in shared if less[at] <= _LEAST_SHARE * whole[at]]
    kept = {name: _at(one, corrected) for name, one in tracks.items()}
    return kept, len(corrected) / max(len(less), 1)


def _at(one: EstimatedTrack, stamps_ns: list[int]) -> EstimatedTrack:
    kept = np.isin(one.stamps_ns, np.array(stamps_ns, np.int64))
    return EstimatedTrack(
        one.stamps_ns[kept], one.latitude[kept], one.longitude[kept], one.covariance[kept],
        one.measured[kept],
    )  # fmt: skip


def _variances(tracks: Mapping[str, EstimatedTrack]) -> dict[int, float]:
    """Return the median over robots of the variance in each image, m²."""
    by_stamp: dict[int, list[float]] = {}
    for one in tracks.values():
        traces = np.trace(one.covariance, axis1=1, axis2=2)
        for stamp_ns, trace in zip(one.stamps_ns.tolist(), traces.tolist(), strict=True):
            by_stamp.setdefault(stamp_ns, []).append(trace)
    return {stamp_ns: float(np.median(one)) for stamp_ns, one in by_stamp.items()}
