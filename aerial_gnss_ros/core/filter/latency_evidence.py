# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What images say of each candidate latency against the configured one, whatever telemetry does.

A latency shows whenever the camera's motion changes, and always by as much; a gimbal or a compass
that jumps shows once. But a candidate meets such a jump at its own time: one of +2 s two seconds
after the configured one, and until then it seems to fit better. So each candidate is compared with
the configured latency twice: by the same images, and by the same telemetry, which are images of
different times. It is found by the lesser of the two, ruled out by the greater, and as likely as
both agree. What happens in the images (robots that turn, a false box) concerns all candidates at
one image; what telemetry does wrong, all at the same telemetry.

Two things are compared: how well boxes of labelled robots fit (`latency_bank`), and how far boxes
are from where they should be seen again (`latency_reappearance`).
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class LatencyEvidenceTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    most_misfit: float = 13.0
    """Upper bound of what an image costs beyond the expected by its residuals: what fits far worse
    is no Gaussian error any more. Judged."""
    caution: float = 2.0
    """Divisor of log likelihoods: robots and errors do not follow the model exactly, and a box may
    count twice. Judged."""
    before_s: float = 0.5
    """How long before telemetry jumps images do not count, s: it is smoothed. Judged."""
    after_s: float = 1.2
    """How long after it, s: robots are then found again. Judged."""
    rounding_s: float = 1e-6
    """Rounding of times, s."""
    most_images: int = 400
    """Number of images that are kept. Judged."""
    least_variance: float = 1.0
    """Added to the variance that noise does not explain: few images may agree by chance. Judged."""


TUNING = LatencyEvidenceTuning()

ALL = slice(None)
"""All candidates."""


@dataclass
class Stretch:
    """Images between which telemetry is complete.

    Attributes:
        times_s: of the n images, s.
        costs: n of (h,), -2 log likelihood of an image's boxes at each candidate, up to a constant;
            infinite where there was no telemetry, or it has not arrived.
        sizes: of each image's fits, log determinant at the configured latency; None: no such fit.
        jumps_s: times at which telemetry may have jumped, ascending, s.
    """

    times_s: list[float] = field(default_factory=list)
    costs: list[Array] = field(default_factory=list)
    sizes: list[list[float | None]] = field(default_factory=list)
    jumps_s: list[float] = field(default_factory=list)


class Used(NamedTuple):
    """What counts of a stretch.

    Attributes:
        times: (n, 1) of its images, s.
        cost: (n, h) of these, 0 where it does not count.
        right: (n, h) whether it counts.
    """

    times: Array
    cost: Array
    right: Mask


def agreed(least: Array, most: Array) -> Array:
    """Return what both comparisons say (h,): the lesser in size, 0 where they contradict.

    Args:
        least: (h,) and
        most: (h,) as `LatencyEvidence.bounds` returns them.
    """
    return np.asarray(np.clip(0.0, least, most))


def disturbed(times: Array, jumps_s: Sequence[float]) -> Mask:
    """Return whether telemetry of times (…) has jumped about then, s."""
    jumps = np.array([-np.inf, *jumps_s, np.inf])
    last = np.searchsorted(jumps, times, side="right") - 1
    after, before = times - jumps[last], jumps[last + 1] - times
    return np.asarray((after <= TUNING.after_s) | (before <= TUNING.before_s))


class LatencyEvidence:
    """Accumulates what images say of h candidate latencies.

    Args:
        corrections: (h,) candidates, ascending, s.
    """

    def __init__(self, corrections: Array) -> None:
        self._corrections = corrections
        self._zero = int(np.argmin(np.abs(corrections)))
        self.reset()

    def reset(self) -> None:
        """Forget all images."""
        self._stretches = deque([Stretch()])

    def note_jumps(self, times_s: Iterable[float]) -> None:
        """Let no image count whose telemetry, at a candidate, is of about a time of these."""
        known = self._stretches[-1].jumps_s
        last = known[-1] if known else -math.inf
        known += [one for one in times_s if one > last]

    def interrupt(self) -> None:
        """Begin a new stretch: telemetry before and after it is not compared."""
        if self._stretches[-1].times_s:
            self._stretches.append(Stretch())
        while sum(len(one.times_s) for one in self._stretches) > TUNING.most_images:
            self._stretches.popleft()

    def add(
        self,
        time_s: float,
        fits: Sequence[tuple[Array, Array] | None],
        known: Mask | None = None,
        part: slice = ALL,
    ) -> None:
        """Take in an image, for all candidates or some: first those with the configured latency.

        Args:
            time_s: its time, s.
            fits: of each kind, (m,) what residuals in units of their noise cost beyond what is
                expected, and log determinants of their covariances; None: there is no such fit.
            known: (m,) whether there was telemetry at each candidate's time; None: everywhere.
            part: which m of the candidates.
        """
        if part.start is None or part.start <= self._zero < part.stop:
            if all(one is None for one in fits):
                return
            stretch, row = self._begin(time_s, fits, part), -1
        else:
            place = self._place(time_s)
            if place is None:
                return
            stretch, row = place
        cost = np.zeros(len(self._corrections[part]))
        for fit, size in zip(fits, stretch.sizes[row], strict=True):
            if fit is not None and size is not None:
                cost += np.minimum(fit[0], TUNING.most_misfit) + fit[1] - size
        number = sum(one is not None for one in stretch.sizes[row])
        cost = np.minimum(cost, number * TUNING.most_misfit)
        if known is not None:
            cost[~known] = np.inf
        stretch.costs[row][part] = cost
        if len(self._stretches[-1].times_s) >= TUNING.most_images:
            self.interrupt()

    def _begin(
        self, time_s: float, fits: Sequence[tuple[Array, Array] | None], part: slice
    ) -> Stretch:
        """Return the last stretch with one more image, that nothing is known of."""
        own = self._zero - (part.start or 0)
        stretch = self._stretches[-1]
        stretch.times_s.append(time_s)
        stretch.costs.append(np.full(len(self._corrections), np.inf))
        stretch.sizes.append([None if one is None else float(one[1][own]) for one in fits])
        return stretch

    def _place(self, time_s: float) -> tuple[Stretch, int] | None:
        """Return the stretch and the index of an image; None: it was not compared, or is gone."""
        for stretch in reversed(self._stretches):
            if stretch.times_s and stretch.times_s[0] <= time_s:
                row = bisect_left(stretch.times_s, time_s)
                found = row < len(stretch.times_s) and stretch.times_s[row] == time_s
                return (stretch, row) if found else None
        return None

    def gains(self, against: int | None = None) -> Array:
        """Return the log likelihood (h,) of each candidate over one of them, the lesser of both.

        Args:
            against: index of that one; None: the configured latency. Candidates are comparable with
                one another by what each gains over the best: over the configured latency one with
                more images gains more.
        """
        return np.minimum(*self._compared(against))

    def bounds(self) -> tuple[Array, Array]:
        """Return the lesser and the greater log likelihood (h,) over the configured latency.

        The lesser speaks for a candidate; one is ruled out if the greater speaks against it.
        """
        by_images, by_telemetry = self._compared(None)
        return np.minimum(by_images, by_telemetry), np.maximum(by_images, by_telemetry)

    def _compared(self, against: int | None) -> tuple[Array, Array]:
        """Return the log likelihoods (h,) by the same images and by the same telemetry."""
        own = self._zero if against is None else against
        used = [self._used(stretch) for stretch in self._stretches if stretch.times_s]
        return self._by_images(used, own), self._by_telemetry(used, own)

    def _used(self, stretch: Stretch) -> Used:
        """Return what counts of a stretch that has images."""
        times, cost = np.array(stretch.times_s)[:, None], np.array(stretch.costs)
        right = ~disturbed(times - self._corrections, stretch.jumps_s) & np.isfinite(cost)
        return Used(times, np.where(right, cost, 0.0), right)

    def _by_images(self, used: list[Used], base: int) -> Array:
        """Return the log likelihoods (h,) over one candidate by the images that both have.

        Telemetry that is rounded or interpolated has another error at each candidate's time, which
        is in no noise that was stated. Then images favour now one candidate and now another. If
        noise is as stated, differences with the mean m have the variance 4 |m| (-2 log likelihoods
        of Gaussian errors); if it is s² more, n of them tell n m² / 2 s² at most, for or against.
        """
        count, total, squares = np.zeros((3, len(self._corrections)))
        for _, cost, each in used:
            right = each & each[:, base, None]
            apart = np.where(right, cost[:, base, None] - cost, 0.0)
            count += right.sum(axis=0)
            total += apart.sum(axis=0)
            squares += np.square(apart).sum(axis=0)
        count = np.maximum(count, 1.0)
        mean = total / count
        unmodelled = squares / count - mean**2 - 4.0 * np.abs(mean)
        variance = np.maximum(unmodelled, 0.0) + TUNING.least_variance
        sure = 0.5 * count * mean**2 / variance
        return np.asarray(np.clip(total / (2.0 * TUNING.caution), -sure, sure))

    @property
    def configured(self) -> int:
        """Index of the configured latency."""
        return self._zero

    def _by_telemetry(self, used: list[Used], base: int) -> Array:
        """Return the log likelihoods (h,) over one candidate by the same telemetry."""
        late = self._corrections
        own, other = np.zeros((2, len(late))), np.zeros((2, len(late)))
        for times, cost, right in used:
            first = times[0] - np.minimum(late, late[base])
            last = times[-1] - np.maximum(late, late[base])
            in_own = right[:, base, None] & _within(times - late[base], first, last)
            in_other = right & _within(times - late, first, last)
            own += (in_own * cost[:, base, None]).sum(axis=0), in_own.sum(axis=0)
            other += (in_other * cost).sum(axis=0), in_other.sum(axis=0)
        number = np.minimum(own[1], other[1])
        mean = [one[0] / np.maximum(one[1], 1.0) for one in (own, other)]
        return np.asarray(number * (mean[0] - mean[1]) / (2.0 * TUNING.caution))


def _within(times: Array, first: Array, last: Array) -> Mask:
    return np.asarray((times >= first - TUNING.rounding_s) & (times <= last + TUNING.rounding_s))
