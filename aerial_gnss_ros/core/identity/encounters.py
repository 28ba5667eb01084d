# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Data association of robots that pass close to one another, with a deferred decision.

The matcher assigns two neighbouring boxes to two robots image by image; only which is which is
uncertain. While a pair is close, its likeliest histories are followed side by side
(`pair_hypotheses`; multiple hypotheses: Reid 1979; Blackman 2004). They decide which box updates
which track, and correct labels that were exchanged once later images make that clear. Ambiguity
that remains when the pair has separated is kept and contained in the published covariance
(`label_ambiguity`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.association.track import Track
from aerial_gnss_ros.core.georeferencing.measurements import Measurements
from aerial_gnss_ros.core.identity.label_ambiguity import LabelAmbiguity, Position
from aerial_gnss_ros.core.identity.pair_hypotheses import PairHypotheses
from aerial_gnss_ros.core.models.motion_model import MotionModel
from aerial_gnss_ros.core.numerics.small_arrays import MAX_ROWS

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
Swaps = list[tuple[int, int]]


@dataclass(frozen=True)
class EncountersTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    followed_sigmas: float = 8.0
    """A pair is followed when its two boxes are closer than this many sigmas of their separation.
    Judged."""
    parted_sigmas: float = 12.0
    """A pair has separated beyond this many sigmas. Judged."""
    most_pairs: int = 30
    """Greatest number of pairs followed at once, the closest first. Judged."""
    steering_ratio: float = 2.0
    """Acceleration of robots that meet, as a multiple of the stated one: they evade. Judged."""
    least_acceleration: float = 0.02
    """Lower bound of that acceleration, root of its spectral density, m/s^1.5. Judged."""
    velocity_lag_mps: float = 0.1
    """Lag of the filter's velocity when a robot turns, one sigma, each axis, m/s. Judged."""
    exchange_probability: float = 0.9
    """Probability above which labels are exchanged while the pair is close. Each exchange is an
    identity switch and the published covariances contain both robots until the pair has separated,
    so a small lead does not suffice; after separation the likelier assignment is taken. Judged."""
    lost_s: float = 3.0
    """A pair that no image has shown together for this time has separated. Judged."""
    remembered_probability: float = 0.01
    """Least probability of an exchange that is remembered after separation. Judged."""


TUNING = EncountersTuning()


class Known(Protocol):
    """The joint filter, as encounters use it."""

    @property
    def motion(self) -> MotionModel:
        """Motion model of the robots."""

    def moments(self) -> tuple[Array, Array]:
        """Return means (n, 4) and covariances (n, 4, 4) of robots' positions and velocities."""

    def box_noise(self, places: Array) -> Array:
        """Return covariances (m, 2, 2) of positions that boxes' own noise causes, m²."""


@lru_cache(maxsize=8)
def _every_pair(n: int) -> tuple[Indices, Indices]:
    """Return the first and the second index of each pair out of n."""
    rows, columns = np.triu_indices(n, 1)
    return rows, columns


def _close(positions: Array, white: Array) -> list[list[int]]:
    """Return the pairs of boxes that are close enough to be followed, closest first.

    Args:
        positions: (n, 2) East, North, m.
        white: (n, 2, 2) covariances of these, m².
    """
    size = np.sqrt(white[:, 0, 0] + white[:, 1, 1])
    if len(size) <= MAX_ROWS:
        boxes = list(enumerate(zip(positions.tolist(), size.tolist(), strict=True)))
        found = []
        for (a, ((east, north), own)), (b, ((x, y), theirs)) in combinations(boxes, 2):
            separation = math.hypot(east - x, north - y)
            if separation < TUNING.followed_sigmas * max(own, theirs):
                found.append((separation, a, b))
        return [[a, b] for _, a, b in sorted(found)] if found else []
    firsts, seconds = _every_pair(len(size))
    east, north = positions[:, 0], positions[:, 1]
    # Most pairs are far apart even for the largest size; a little more, as rounding differs.
    reach = TUNING.followed_sigmas * float(size.max()) * (1.0 + 1e-9)
    squared = np.square(east.take(firsts) - east.take(seconds))
    squared += np.square(north.take(firsts) - north.take(seconds))
    few = np.flatnonzero(squared < reach * reach)
    firsts, seconds = firsts[few], seconds[few]
    vectors = positions[firsts] - positions[seconds]
    distances = np.hypot(vectors[:, 0], vectors[:, 1])
    near = distances < TUNING.followed_sigmas * np.maximum(size[firsts], size[seconds])
    order = np.argsort(distances[near], kind="stable")
    pairs: list[list[int]] = np.stack([firsts[near], seconds[near]], axis=1)[order].tolist()
    return pairs


class Encounters:
    """Follows pairs of labelled robots that are close.

    Args:
        known: the joint filter.

    Attributes:
        ambiguous: whether any label may belong to another robot.
    """

    def __init__(self, known: Known) -> None:
        self._known = known
        self._acceleration = max(
            TUNING.steering_ratio * known.motion.acceleration, TUNING.least_acceleration
        )
        self._pairs: list[PairHypotheses] = []
        self._parted = LabelAmbiguity()
        self.ambiguous = False

    def reset(self) -> None:
        """Forget all pairs and ambiguities."""
        self._pairs.clear()
        self._parted = LabelAmbiguity()
        self.ambiguous = False

    def update(
        self,
        tracks: list[Track],
        rows: Indices,
        columns: Indices,
        seen: Measurements,
        stamp_ns: int,
        image_cost: Array | None = None,
    ) -> tuple[Indices, Swaps]:
        """Update with the boxes of one image; return what corrects exchanged labels.

        Args:
            tracks: all of them.
            rows: (m,) of those in the image, by the association.
            columns: (m,) their measurements.
            seen: the image's measurements.
            stamp_ns: of the image, ns.
            image_cost: minus twice the log likelihood of all tracks' measurements by tracking in
                the image.

        Returns:
            The measurements (m,) that update the tracks, and the rows of tracks that exchange
            their labels, one exchange after the other.
        """
        labelled: list[int] = []
        for i, row in enumerate(rows.tolist()):
            if tracks[row].robot_id:
                labelled.append(i)
        boxes = columns[labelled]
        positions, white = seen.positions[boxes], seen.white[boxes]
        if not self._pairs and not _close(positions, white):
            return columns, []
        shown, columns = [tracks[row] for row in rows[labelled].tolist()], columns.copy()
        cost = None if image_cost is None else image_cost[rows[labelled]][:, boxes]
        order, swaps = self.follow(shown, rows[labelled], positions, white, stamp_ns, cost)
        columns[labelled] = boxes[order]
        of = rows[labelled].tolist()
        return columns, [(of[a], of[b]) for a, b in swaps]

    def follow(
        self,
        tracks: list[Track],
        rows: Indices,
        positions: Array,
        white: Array,
        stamp_ns: int,
        image_cost: Array | None = None,
    ) -> tuple[Indices, Swaps]:
        """Update with the boxes of an image's labelled robots; return what corrects labels.

        Args:
            tracks: m tracks in the image, as associated.
            rows: (m,) rows of these tracks in the filter.
            positions: (m, 2) of their boxes, East, North, m.
            white: (m, 2, 2) white covariance of these, m².
            stamp_ns: of the image, ns.
            image_cost: (m, m) minus twice the log likelihood of tracks' boxes by tracking in the
                image.

        Returns:
            Indices (m,) of the boxes that update the tracks: 0 to m - 1, permuted where exchanged;
            and the indices of tracks that exchange their labels, one exchange after the other.
        """
        labels, swaps = [track.robot_id for track in tracks], list[tuple[int, int]]()
        shown = {label: i for i, label in enumerate(labels)}
        boxes = np.arange(len(tracks))
        for pair in list(self._pairs):
            if pair.names[0] in shown and pair.names[1] in shown:
                a, b = (shown[name] for name in pair.names)
                one, other = boxes[a], boxes[b]
                both = [one, other]
                separation, spread = positions[other] - positions[one], white[one] + white[other]
                own = self._known.box_noise(positions[both])
                common = (white[both] - own).mean(axis=0)
                exchange = 0.0
                if image_cost is not None:
                    direct = image_cost[a, one] + image_cost[b, other]
                    exchange = 0.5 * float(direct - image_cost[a, other] - image_cost[b, one])
                exchanged = pair.update(
                    stamp_ns, positions[both], own, common, self._acceleration, exchange
                )
                if exchanged > 0.5:
                    boxes[a], boxes[b] = other, one
                    pair.exchange()
                parted = (
                    float(separation @ np.linalg.solve(spread, separation))
                    > TUNING.parted_sigmas**2
                )
                if pair.exchanged > (0.5 if parted else TUNING.exchange_probability):
                    swaps.append((a, b))
                    labels[a], labels[b] = labels[b], labels[a]
                    shown[pair.names[0]], shown[pair.names[1]] = b, a
                    self._exchange(pair)
                if parted:
                    self._part(pair)
            elif stamp_ns - pair.seen_ns > TUNING.lost_s * 1e9:
                self._part(pair)
        self._begin(tracks, labels, rows, positions[boxes], white[boxes], stamp_ns)
        self._conclude(self._parted)
        return boxes, swaps

    def update_ambiguity(self, distributions: Mapping[str, Mapping[str, float]]) -> None:
        """Update the distributions over tracks, by label."""
        self._conclude(self._parted.after_permutation(distributions))

    def note_departure(self, name: str, position: Position, share: float) -> None:
        """Record the probability that a label's robot stayed where it was."""
        self._conclude(self._parted.after_departure(name, position, share))

    def ambiguity_covariances(self, estimates: dict[str, Position]) -> dict[str, Array]:
        """Return covariances (2, 2) to be added for ambiguous labels, m².

        Args:
            estimates: estimated position of each labelled robot; other labels are forgotten.
        """
        self._parted.prune(estimates)
        self._conclude(self._parted)
        now = self._parted
        for pair in self._pairs:
            if pair.names[0] in estimates and pair.names[1] in estimates:
                now = now.after_exchange(*pair.names, pair.exchanged)
        return now.covariances(estimates)

    def rename(self, names: Mapping[str, str]) -> None:
        """Give robots other labels: new ones by old ones; others stay."""
        for pair in self._pairs:
            first, second = pair.names
            pair.names = names.get(first, first), names.get(second, second)
        self._conclude(self._parted.renamed(names))

    def _conclude(self, parted: LabelAmbiguity) -> None:
        self._parted, self.ambiguous = parted, bool(self._pairs or parted.probabilities)

    def _exchange(self, decided: PairHypotheses) -> None:
        """Keep the other pairs on their tracks, under the exchanged labels."""
        decided.exchange()
        other = dict(zip(decided.names, decided.names[::-1], strict=True))
        for pair in self._pairs:
            if pair is not decided:
                first, second = pair.names
                pair.names = other.get(first, first), other.get(second, second)

    def _part(self, pair: PairHypotheses) -> None:
        self._pairs.remove(pair)
        if pair.exchanged > TUNING.remembered_probability:
            self._parted = self._parted.after_exchange(*pair.names, pair.exchanged)

    def _begin(
        self,
        tracks: list[Track],
        labels: list[str],
        rows: Indices,
        positions: Array,
        white: Array,
        stamp_ns: int,
    ) -> None:
        """Start following pairs that have come close, under labels that are corrected."""
        if len(tracks) < 2:
            return
        close = _close(positions, white)
        followed = [{*pair.names} for pair in self._pairs]
        for both in close:
            if len(self._pairs) >= TUNING.most_pairs:
                return
            one, other = (tracks[k] for k in both)
            names = (labels[both[0]], labels[both[1]])
            if one.class_id != other.class_id or {*names} in followed:
                continue
            spread = np.zeros((2, 4, 4))
            spread[:, :2, :2] = white[both]
            covariance = self._known.moments()[1][rows[both], 2:, 2:]
            spread[:, 2:, 2:] = covariance + TUNING.velocity_lag_mps**2 * np.eye(2)
            velocities = np.array([one.velocity, other.velocity])
            self._pairs.append(
                PairHypotheses.begin(names, positions[both], velocities, spread, stamp_ns)
            )
