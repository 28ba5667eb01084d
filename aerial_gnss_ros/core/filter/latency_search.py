# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Estimates the image latency by comparing all candidates (`latency_bank`).

No derivative by the latency is used, so noise is not mistaken for information, and a large error
does no harm: each candidate uses the pose measured at its own time, whatever the drone did. A
flight in which all latencies fit leaves them all possible.

An image is compared once telemetry has arrived for all candidates of a band (`latency_band`), of
which there are several where latencies are only weighed; nothing is extrapolated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.filter.latency_band import LatencyBand, bands
from aerial_gnss_ros.core.filter.latency_bank import BankObservation, LatencyFit
from aerial_gnss_ros.core.filter.latency_evidence import LatencyEvidence, disturbed
from aerial_gnss_ros.core.filter.latency_posterior import CAUTION, LatencyPrior, posterior
from aerial_gnss_ros.core.filter.latency_views import Mask, Views
from aerial_gnss_ros.core.filter.pose_lattice import (
    STEP_NS,
    STEP_S,
    PoseLattice,
    SampledPose,
)
from aerial_gnss_ros.core.geometry.frames import FLU_FROM_OPTICAL
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.geometry.map_pose import MapPose
from aerial_gnss_ros.core.models.evidence import SURE_SIGMAS
from aerial_gnss_ros.core.models.motion_model import motion_model
from aerial_gnss_ros.core.models.platform_model import PlatformModel
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.pose import PoseBuilder
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry
from aerial_gnss_ros.core.values.rejection import Reason

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LatencySearchTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    max_latency_s: float = 3.0
    """Greatest absolute latency, configured plus estimated, s. The range of camera.latency_s."""
    reach_steps: int = 3
    """Least number of candidates to either side. Judged."""
    interval_s: float = 0.2
    """Least time between images that are compared, s: each costs as much as ten in the filter.
    Judged."""
    images_memory_s: float = 300.0
    """Time constant with which older images are down-weighted, s: the latency may change.
    Judged."""
    most_bend_m: float = 0.3
    """Greatest change of the smoothed camera position from one step to the next, m: 3 g. Beyond,
    telemetry has jumped, by a metre or more."""
    most_bend_rad: float = 0.05
    """The same of the orientation, rad: a gimbal that starts at 60 deg/s has less, one that jumps
    by 12 deg has more. Judged."""
    most_waiting: int = 100
    """Greatest number of images that wait for telemetry. Judged."""


TUNING = LatencySearchTuning()


class LatencySearch:
    """Estimates the correction of `camera.latency_s`; its prior sigma is `noise.latency_s`.

    Args:
        config: noise, motion, latency.
        inputs: telemetry buffers.
        weighs: whether it weighs other latencies than the configured one.
        most_s: greatest absolute latency, configured plus estimated, s.

    Attributes:
        found: mean and sigma of the correction, s; None where it is not estimated.
        scene_ns: estimated time from an image's scene to its stamp, ns.
        evidence: what images say of other latencies than the configured one, if it weighs them.
        stamp_sigma_s: standard deviation of telemetry's stamps, s, by which no latency is known
            better.
    """

    def __init__(
        self,
        config: EstimatorConfig,
        inputs: TelemetryBuffers,
        weighs: bool = False,
        most_s: float = TUNING.max_latency_s,
    ) -> None:
        stated = config.camera.latency_s
        self._stated_ns = round(stated * 1e9)
        self._inputs, self._posing = inputs, PoseBuilder(config)
        self._local: LocalMap | None = None
        self._sigma = config.noise.value("latency_s")
        reach = max(SURE_SIGMAS * self._sigma, TUNING.reach_steps * STEP_S)
        first = math.ceil(max(-most_s - stated, -reach) / STEP_S - 1e-9)
        last = math.floor(min(most_s - stated, reach) / STEP_S + 1e-9)
        self.corrections: Array = np.arange(first, last + 1, dtype=np.float64) * STEP_S
        self._lattice = PoseLattice(last - first + 2 * TUNING.most_waiting)
        # Hypotheses of the bank say by themselves that errors are larger.
        model = PlatformModel(config.noise, config.gimbal.reference, exact=True)
        motion = motion_model(config)
        self._bands = [
            LatencyBand(model, motion, low, high, slice(low - first, high - first + 1))
            for low, high in (bands(first, last) if weighs else [(first, last)])
        ]
        self.evidence = LatencyEvidence(self.corrections) if weighs else None
        self.stamp_sigma_s = 0.0
        self.reset()

    def reset(self) -> None:
        """Forget all images."""
        self._newest_ns: int | None = None
        self._cost = np.zeros(len(self.corrections))
        self._images = 0.0
        self._lattice.clear()
        self._turned: tuple[tuple[float, ...], ...] | None = None
        for band in self._bands:
            band.reset()
        if self.evidence is not None:
            self.evidence.interrupt()
        self._conclude(self._posterior() if self._sigma > 0.0 else None)

    def follow(self, former: LatencySearch) -> None:
        """Continue a search about another latency, or with another calibration.

        What images said of the latency itself stays; the prior is about the new one. A candidate
        that the former search did not have counts as its outermost one did.
        """
        apart = 1e-9 * (self._stated_ns - former._stated_ns)
        wanted, known = self.corrections + apart, former.corrections
        self._cost = np.interp(wanted, known, former._cost)
        self._images = former._images
        self.evidence, self.stamp_sigma_s = former.evidence, former.stamp_sigma_s
        if self.evidence is not None and apart:
            self.evidence = LatencyEvidence(self.corrections)
        if self.searches:
            self._conclude(self._posterior())

    def resume(self, former: LatencySearch) -> None:
        """Continue a search about the same latency; images that it has compared tell no more."""
        self.follow(former)
        self._newest_ns = former._bands[-1].last_ns

    def conclude(self) -> None:
        """Take over what decided for another latency, and weigh no more."""
        self._conclude(self.weighed())
        self.evidence = None

    def weighed(self) -> tuple[float, float]:
        """Return mean and sigma of the correction by the evidence, if it weighs any, s."""
        if self.evidence is not None:
            best = int(np.argmax(self.evidence.gains()))
            self._cost = -2.0 * CAUTION * self.evidence.gains(best)
            self._images = max(self._images, 1.0)
        return self._posterior()

    @property
    def searches(self) -> bool:
        """Whether the latency is estimated at all."""
        return self._sigma > 0.0

    def _conclude(self, found: tuple[float, float] | None) -> None:
        self.found = found
        self.scene_ns = self._stated_ns + (0 if found is None else round(found[0] * 1e9))

    def update(self, frame: PosedFrame, measured: dict[str, int], local: LocalMap) -> None:
        """Take in an image, compare all waiting ones whose telemetry has arrived, and conclude.

        Args:
            frame: with its boxes.
            measured: index of the box of each labelled robot.
            local: the frame `map`.
        """
        if self.found is None:
            return
        if self.compare(frame, measured, local):
            self._conclude(self._posterior())

    def compare(self, frame: PosedFrame, measured: dict[str, int], local: LocalMap) -> bool:
        """Do the same without a conclusion; return whether the image was taken."""
        boxes = frame.detections
        newest, stamp_ns = self._newest_ns, boxes.stamp_ns - self._stated_ns
        if newest is not None and stamp_ns - newest < TUNING.interval_s * 1e9:
            return False
        self._local, self._newest_ns = local, stamp_ns
        pixels = {name: boxes.centers[index] for name, index in measured.items()}
        observation = BankObservation(stamp_ns, frame.camera, pixels, frame.pose.fix_covariance)
        for band in self._bands:
            band.waiting.append((observation, boxes.centers))
            while band.waiting and self._compare(band, *band.waiting[0]):
                band.waiting.popleft()
        return True

    def _compare(self, band: LatencyBand, seen: BankObservation, centers: Array) -> bool:
        """Take an image to a band; return False where telemetry for it may still come."""
        node, rest = divmod(seen.stamp_ns, STEP_NS)
        first, last = node - band.last, node - band.first
        late = len(band.waiting) > TUNING.most_waiting
        if not self._lattice.fill(first, last, self._pose, late):
            return False
        positions, rotations = self._lattice.between(first, last, rest / STEP_NS)
        posed = self._posed(band, positions)
        if not _is_smooth(positions[posed], rotations[posed]):
            self._interrupt(band)
            return True
        passed = band.passed(seen.stamp_ns)
        # A larger latency is an earlier pose; before the first one there is none to compare.
        begin = int(np.argmax(posed))
        positions[:begin], rotations[:begin] = positions[begin], rotations[begin]
        positions, rotations, posed = positions[::-1], rotations[::-1], posed[::-1]
        positions, rotations = self._cameras(band, positions, rotations)
        between = self._lattice.interpolation(first, last, passed)
        between = None if between is None else between[::-1]
        views = Views(positions, rotations @ FLU_FROM_OPTICAL, between)
        anew = None
        if self.evidence is not None:
            late_s = self.corrections[band.part]
            anew = disturbed(1e-9 * seen.stamp_ns - late_s, self._lattice.jumps_s) | ~posed
        again, fit = band.compare(seen, centers, passed, views, rotations, anew)
        known = band.known(posed)
        self._add(band, fit, passed, known)
        if self.evidence is not None:
            self.evidence.note_jumps(self._lattice.jumps_s)
            fits = again, None if fit is None else fit.of_a_robot
            self.evidence.add(seen.stamp_ns * 1e-9, fits, known, band.part)
        return True

    def _cameras(
        self, _band: LatencyBand, positions: Array, rotations: Array
    ) -> tuple[Array, Array]:
        """Return the camera (n, 3), (n, 3, 3) at a band's candidates from those of their times."""
        return positions, rotations

    def _posed(self, band: LatencyBand, positions: Array) -> Mask:
        """Return which of some poses (n, 3), the earliest first, an image is compared with.

        All of them, if any is missing none; but evidence is about those from the first one on.
        """
        posed: Mask = np.ones(len(positions), np.bool_)
        if self.evidence is not None:
            begin = int(np.argmax(np.isfinite(positions[:, 0])))
            needed = max(0, self.evidence.configured - band.part.start)
            posed[: min(begin, len(posed) - 1 - needed)] = False
        return posed

    def _interrupt(self, band: LatencyBand) -> None:
        """Compare nothing before with what follows."""
        band.interrupt()
        if self.evidence is not None and band is self._bands[0]:
            self.evidence.interrupt()

    def _add(self, band: LatencyBand, fit: LatencyFit | None, passed: float, known: Mask) -> None:
        part, first = band.part, band is self._bands[0]
        fade = math.exp(-max(passed, 0.0) / TUNING.images_memory_s)
        self._cost[part] *= fade
        self._images *= fade if first else 1.0
        if fit is not None:
            self._cost[part] += known * (fit.misfit + fit.size)
            self._images += float(first)

    def _posterior(self) -> tuple[float, float]:
        """Return posterior mean and sigma of the correction, s."""
        prior = LatencyPrior.of(self._sigma, self.stamp_sigma_s, bool(self._stated_ns))
        return posterior(self.corrections, self._cost, prior, bool(self._images))

    def _pose(self, stamp_ns: int) -> MapPose | bool:
        """Return the camera at a time; without one, whether its telemetry may still arrive."""
        assert self._local is not None  # noqa: S101 - `update` sets it
        samples = self._inputs.at(stamp_ns)
        if isinstance(samples, MissingTelemetry):
            return samples.can_arrive
        turned = tuple(one.jumped for one in (samples.attitude, samples.gimbal) if one is not None)
        if turned != self._turned:
            if self._turned is not None:
                self._lattice.note_jump(stamp_ns * 1e-9)
            self._turned = turned
        pose = self._posing.pose(samples)
        if isinstance(pose, Reason):
            return False
        shown = MapPose.of(pose, self._local)
        if samples.fix.jumped:  # which the drone has not flown
            shown = MapPose(shown.position - np.append(samples.fix.jumped, 0.0), shown.rotation)
        if not pose.interpolation.any():
            return shown
        return SampledPose(shown.position, shown.rotation, pose.interpolation * pose.gaps_s)


def _is_smooth(positions: Array, rotations: Array) -> bool:
    """Return whether poses that follow one another are known and none has jumped.

    However fast the drone is: only changes of its velocity count.

    Args:
        positions: (n, 3) m, smoothed.
        rotations: (n, 3, 3) smoothed.
    """
    moved = np.linalg.norm(np.diff(positions, n=2, axis=0), axis=1)
    turned = np.linalg.norm(np.diff(rotations, n=2, axis=0), axis=(1, 2))
    # False for NaN: gaps in telemetry are not bridged. A turn by w changes a matrix by √2 w.
    return bool(
        (moved <= TUNING.most_bend_m).all()
        and (turned <= math.sqrt(2.0) * TUNING.most_bend_rad).all()
    )
