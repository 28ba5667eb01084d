# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether images come as late as configured, or by another latency: two hypotheses, weighed.

Nearly all flights have the configured latency (images and telemetry of one clock); of the others,
any latency within 3 s is as likely as another. `LatencyEvidence` says what images tell of each.

As another latency becomes likelier, it is tried (`LatencyTrial`), beside the configured one, and
the moments of the mixture of both are published. Both trackers go on whatever is published, so a
doubt that turns out wrong leaves nothing behind.

Telemetry that was written down with images has their stamps, and is late by up to the time between
two of them: its latency is known no better than that, so it is estimated at once.

A trial begins with the images of the last seconds. While its latency is not known to 0.1 s they
tell nothing of the platform's other errors, so they are taken in once more when it is.

Until then, and while a trial takes in earlier images, published covariances contain what each other
latency makes of positions (`LatencyCover`).

The question stays open until images tell: around an even circle every latency shows the same scene,
turned about its centre, however long it is flown. Later images are compared more seldom.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.latency_cover import LatencyCover
from aerial_gnss_ros.core.estimation.latency_trial import LatencyTrial, learn
from aerial_gnss_ros.core.estimation.pipeline import Pipeline
from aerial_gnss_ros.core.estimation.recent_images import RecentImages, SeenImage
from aerial_gnss_ros.core.estimation.time_in_motion import TimeInMotion
from aerial_gnss_ros.core.filter.latency_search import LatencySearch
from aerial_gnss_ros.core.filter.restarts import TUNING as RESTARTS
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.identity.labels import Labels
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.map_origin import MapOrigin
from aerial_gnss_ros.core.telemetry.stamp_resolution import stamp_sigma_s
from aerial_gnss_ros.core.values.estimates import FrameResult

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LatencyDoubtTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    elsewhere: float = 0.1
    """Probability before any image that the latency is another one. Judged."""
    tried_nats: float = -1.0
    """Log odds of another latency from which it is tried: before it is the likelier one, so that
    its tracks are ready then. Judged."""
    dropped_nats: float = -2.0
    """Log odds below which a trial ends. Judged."""
    doubted_nats: float = 3.0
    """Log odds of another latency from which it is taken for right: 20 to 1, as everywhere. Until
    then the mixture of both is published."""
    fewer_robots: float = 0.5
    """Mean number of robots that a trial may measure less than the configured latency, whose tracks
    are older, and be taken for right. Judged."""
    settled_nats: float = -3.0
    """Log likelihood of the best other latency at which the configured one is right. Judged."""
    settled_apart_s: float = 0.25
    """Latencies nearer to the configured one do not keep the question open, s: they take long to
    tell apart. Judged."""
    known_s: float = RESTARTS.sure_s
    """Sigma of another latency below which images are taken in once more, s: above, the filter
    learns nothing else."""
    interval_s: float = 0.4
    """Least time between images that are taken, s: some ten decide, each costs as much as ten in
    the filter, and what fits badly does so for about as long, by one cause. Judged."""
    often_s: float = 30.0
    """Time in motion after which images are taken more seldom, s: most flights have told by then.
    Judged."""
    seldom_s: float = 1.0
    """Least time between images from then on, s. Judged."""


TUNING = LatencyDoubtTuning()

UNKNOWN_S = 1.0
"""Prior sigma of a latency that is looked for, s: up to 3 s either way."""

ALWAYS_NS, NEVER_NS = -(2**63), 2**63


class LatencyDoubt:
    """Weighs "as configured" against "another latency".

    Args:
        config: of the estimator.
        inputs: telemetry buffers.

    Attributes:
        open: whether it is undecided.
        doubted: whether another latency was found likelier.
        trial: tracks with another latency, while it is likely enough.
        due_ns: stamp of the next image that is wanted, ns.
        unknown: the configuration of a latency that is not known.
        search: what has been learnt of other latencies.
    """

    def __init__(self, config: EstimatorConfig, inputs: TelemetryBuffers) -> None:
        self.open, self.doubted = True, False
        self.trial: LatencyTrial | None = None
        self._inputs = inputs
        self.unknown = _unknown(config)
        self._recent = RecentImages()
        self._published: Pipeline | None = None
        self._again = False
        self.search = LatencySearch(self.unknown, inputs, weighs=True)
        self._motion = TimeInMotion()
        self._nats = self._rival = -math.inf
        self._cover = LatencyCover(self.search.corrections, TUNING.elsewhere)
        self.reset()

    def reconfigure(self, config: EstimatorConfig) -> EstimatorConfig:
        """Use another configuration; return the one that the filter is to use."""
        self.unknown = _unknown(config)
        self._drop()
        if self.open:
            former = self.search
            self.search = LatencySearch(self.unknown, self._inputs, weighs=True)
            self.search.follow(former)
            self._cover = LatencyCover(self.search.corrections, TUNING.elsewhere)
        return self.unknown if self.doubted else config

    def reset(self) -> None:
        """Begin anew with other robots; what images told of the latency stays."""
        self.search.reset()
        self.forget_images()
        self._motion.interrupt()
        self.due_ns = ALWAYS_NS if self.open else NEVER_NS

    def forget_images(self) -> None:
        """Begin with none of the images so far: telemetry or `map` are others now."""
        self._drop()
        self._recent.images.clear()
        self._cover.forget()

    def _drop(self) -> None:
        """End what was begun with recent images; it may begin anew."""
        self.trial, self._again = None, False

    def close(self) -> None:
        """Decide no more, and begin no more with recent images."""
        self.open, self.trial, self._again = False, None, True

    @property
    def active(self) -> bool:
        """Whether images are wanted: it is undecided, or they are to be taken in once more."""
        return self.open or (self.doubted and (self.trial is not None or not self._again))

    @property
    def long_open(self) -> bool:
        """Whether it is undecided after a time in motion by which most flights have told."""
        return self.open and self._motion.total_s > TUNING.often_s

    def update(
        self, scene: PosedFrame, measured: dict[str, int], local: LocalMap, rival: float = -math.inf
    ) -> None:
        """Take in an image that is due.

        Args:
            scene: its boxes and the camera's pose.
            measured: index of the box of each labelled robot.
            local: the frame `map`.
            rival: log odds of another latency of the fix.
        """
        evidence = self.search.evidence
        if evidence is None or not (self.open or self.doubted):
            return
        stamp_ns = scene.detections.stamp_ns
        self._note_stamps()
        self.search.compare(scene, measured, local)
        if self.doubted:
            self._learn_more(stamp_ns, not measured)
            return
        self._motion.update(stamp_ns, scene.in_map)
        gains, most = evidence.bounds()
        self._cover.weigh(most)
        far = most[np.abs(self.search.corrections) > TUNING.settled_apart_s]
        right = float(far.max()) < TUNING.settled_nats
        self._weigh(np.delete(gains, evidence.configured))
        self._rival = rival
        if self._nats < (TUNING.tried_nats if right else TUNING.dropped_nats):
            self._drop()
        self.open = self.trial is not None or not right
        pause_s = TUNING.seldom_s if self.long_open else TUNING.interval_s
        self.due_ns = stamp_ns + round(pause_s * 1e9) if self.open else NEVER_NS

    def _weigh(self, gains: Array) -> None:
        """Weigh the configured latency against the others together.

        Args:
            gains: (h - 1,) log likelihood of each of these over the configured one.
        """
        best = float(gains.max())
        likelihood = best + math.log(float(np.exp(gains - best).mean()))
        self._nats = math.log(TUNING.elsewhere / (1.0 - TUNING.elsewhere)) + likelihood
        if self.stamped_seldom:
            self._nats = math.inf

    def try_another(
        self,
        image: SeenImage,
        origin: MapOrigin,
        labels: Labels,
    ) -> LatencyTrial | None:
        """Take an image to the trial, if there is one; return it when it is to be published.

        That is so when its latency is found right, and when recent images have been taken in once
        more, with the latency known.

        Args:
            image: as the published tracker took it in.
            origin: of `map`.
            labels: of the published robots.
        """
        self._recent.add(image)
        if self.trial is not None:
            self.trial.add(image)
        elif not self.doubted:
            if self.open and self._nats >= TUNING.tried_nats:
                self._again, self.trial = False, self._begin(self._anew(), origin, labels)
            return None
        found = self.trial
        if found is not None and not found.behind and self._believed(found):
            self.trial, self._published = None, found.pipeline
            return found
        known = self._known()
        if known is not None:
            self._again, self.trial = True, self._begin(known, origin, labels)
        return None

    def _believed(self, trial: LatencyTrial) -> bool:
        """Return whether a trial's latency is the likelier one; once it is, it stays so."""
        if self.doubted:
            return True
        likelier = self._nats > max(TUNING.doubted_nats, self._rival)
        self.doubted = likelier and trial.balance > -TUNING.fewer_robots
        if self.doubted:
            self.open = False
            learn(trial.pipeline, self._learnt())
        return self.doubted

    def _learn_more(self, stamp_ns: int, unlabelled: bool) -> None:
        """Go on telling which latency it is where boxes have no labels, until it is known."""
        self.due_ns = NEVER_NS if self._again else stamp_ns + round(TUNING.interval_s * 1e9)
        if unlabelled and self._published is not None and not self._again:
            learn(self._published, self._learnt())

    def _known(self) -> LatencySearch | None:
        """Return a search to take images in with once more, if the latency has become known."""
        if self._again or (self.trial is not None and self.trial.behind):
            return None
        tracks = self._published if self.trial is None else self.trial.pipeline
        found = None if tracks is None else tracks.latency.found
        if tracks is None or found is None or found[1] > TUNING.known_s:
            return None
        search = LatencySearch(self.unknown, self._inputs)
        search.resume(tracks.latency)
        return search

    def _begin(self, search: LatencySearch, origin: MapOrigin, labels: Labels) -> LatencyTrial:
        """Return a trial that begins with the recent images."""
        images = self._recent.images
        return LatencyTrial(self.unknown, self._inputs, origin, labels, search, images)

    def _anew(self) -> LatencySearch:
        """Return a search that knows nothing but how exact stamps are."""
        search = LatencySearch(self.unknown, self._inputs)
        search.stamp_sigma_s = self.search.stamp_sigma_s
        return search

    @property
    def stamped_seldom(self) -> bool:
        """Whether telemetry has the stamps of images, and no latency is known for that reason."""
        return self.search.stamp_sigma_s > TUNING.known_s

    def _note_stamps(self) -> None:
        """Judge how exact telemetry's stamps are, by the recent images."""
        images = [one.frame.stamp_ns for one in self._recent.images]
        if not images:
            return
        sigma_s = stamp_sigma_s(images, self._inputs.stamps(images[0], images[-1]))
        tracks = self._published if self.trial is None else self.trial.pipeline
        for search in (self.search, None if tracks is None else tracks.latency):
            if search is not None:
                search.stamp_sigma_s = sigma_s

    def _learnt(self) -> LatencySearch:
        """Return a search that goes on from what decided."""
        search = LatencySearch(self.unknown, self._inputs)
        search.follow(self.search)
        search.conclude()
        return search

    def note(self, scene: PosedFrame, corrects: Mapping[str, str]) -> None:
        """Note the camera of an image, whose result is to be `mixed`.

        Args:
            scene: the image.
            corrects: label of the robot that each reference is which corrects its positions.
        """
        if self.open:
            self._cover.note(scene, corrects)

    def mixed(self, result: FrameResult, local: LocalMap | None) -> FrameResult:
        """Return a result as moments of the mixture of both hypotheses while it is undecided.

        Robots that no trial has are as uncertain as other latencies would displace them.
        """
        if local is None or not (self.open and result.estimates):
            return result
        alone = self._cover.widened(result.estimates)
        if self.trial is not None:
            probability = 1.0 / (1.0 + math.exp(-self._nats))
            alone = self.trial.mixed(result.estimates, alone, probability, local)
        return replace(result, estimates=tuple(alone))


def _unknown(config: EstimatorConfig) -> EstimatorConfig:
    return replace(config, noise=replace(config.noise, latency_s=UNKNOWN_S))
