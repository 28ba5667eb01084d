# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whether images come as late as configured, or by another latency: two hypotheses, weighed.

`LatencyOdds` says how likely another latency is, and when all others are ruled out. As another one
becomes likelier, it is tried (`LatencyTrial`), beside the configured one, and the moments of the
mixture of both are published. Both trackers go on whatever is published, so a doubt that turns out
wrong leaves nothing behind.

A trial begins with the images of the last seconds. While its latency is not known to 0.1 s they
tell nothing of the platform's other errors, so they are taken in once more when it is.

Until then, and while a trial takes in earlier images, published covariances contain what each other
latency makes of positions (`LatencyCover`).

The question stays open until images tell.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

from aerial_gnss_ros.core.camera.posed_frame import PosedFrame
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.latency_odds import LatencyOdds
from aerial_gnss_ros.core.estimation.latency_trial import LatencyTrial, learn
from aerial_gnss_ros.core.estimation.pipeline import Pipeline
from aerial_gnss_ros.core.estimation.recent_images import RecentImages, SeenImage
from aerial_gnss_ros.core.estimation.time_in_motion import TUNING as TIME_IN_MOTION
from aerial_gnss_ros.core.filter.latency_search import LatencySearch
from aerial_gnss_ros.core.filter.restarts import TUNING as RESTARTS
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.identity.labels import Labels
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.map_origin import MapOrigin
from aerial_gnss_ros.core.telemetry.stamp_resolution import stamp_sigma_s
from aerial_gnss_ros.core.values.estimates import FrameResult


@dataclass(frozen=True)
class LatencyDoubtTuning:
    """Chosen numbers of this module, with their units and where they come from."""

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
    known_s: float = RESTARTS.sure_s
    """Sigma of another latency below which images are taken in once more, s: above, the filter
    learns nothing else."""


TUNING = LatencyDoubtTuning()

UNKNOWN_S = 1.0
"""Prior sigma of a latency that is looked for, s: up to 3 s either way."""

ALWAYS_NS, NEVER_NS = -(2**63), 2**63


class LatencyDoubt:
    """Weighs "as configured" against "another latency".

    Args:
        config: of the estimator.
        inputs: telemetry buffers.
        recent: the last images.

    Attributes:
        open: whether it is undecided.
        doubted: whether another latency was found likelier.
        trial: tracks with another latency, while it is likely enough.
        due_ns: stamp of the next image that is wanted, ns.
        unknown: the configuration of a latency that is not known.
        odds: how likely another latency is.
    """

    def __init__(
        self, config: EstimatorConfig, inputs: TelemetryBuffers, recent: RecentImages
    ) -> None:
        self.open, self.doubted = True, False
        self.trial: LatencyTrial | None = None
        self._inputs = inputs
        self.unknown = _unknown(config)
        self._recent = recent
        self._published: Pipeline | None = None
        self._again = False
        self.odds = LatencyOdds(self.unknown, inputs)
        self._rival = -math.inf
        self.reset()

    def reconfigure(self, config: EstimatorConfig) -> EstimatorConfig:
        """Use another configuration; return the one that the filter is to use."""
        self.unknown = _unknown(config)
        self._drop()
        if self.open:
            former, self.odds = self.odds, LatencyOdds(self.unknown, self._inputs)
            self.odds.follow(former)
        return self.unknown if self.doubted else config

    def reset(self) -> None:
        """Begin anew with other robots; what images told of the latency stays."""
        self.odds.interrupt()
        self.forget_images()
        self.due_ns = ALWAYS_NS if self.open else NEVER_NS

    def forget_images(self) -> None:
        """Begin with none of the images so far: telemetry or `map` are others now."""
        self._drop()
        self.odds.cover.forget()

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
        return self.open and self.odds.motion.long

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
        if not (self.open or self.doubted):
            return
        stamp_ns, odds = scene.detections.stamp_ns, self.odds
        self._note_stamps()
        if self.doubted:
            odds.search.compare(scene, measured, local)
            self._learn_more(stamp_ns, not measured)
            return
        odds.update(scene, measured, local)
        self._rival = rival
        if odds.nats < (TUNING.tried_nats if odds.ruled_out else TUNING.dropped_nats):
            self._drop()
        self.open = self.trial is not None or not odds.ruled_out
        self.due_ns = stamp_ns + round(odds.motion.pause_s * 1e9) if self.open else NEVER_NS

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
        if self.trial is not None:
            self.trial.add(image)
        elif not self.doubted:
            if self.open and self.odds.nats >= TUNING.tried_nats:
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
        likelier = self.odds.nats > max(TUNING.doubted_nats, self._rival)
        self.doubted = likelier and trial.balance > -TUNING.fewer_robots
        if self.doubted:
            self.open = False
            learn(trial.pipeline, self._learnt())
        return self.doubted

    def _learn_more(self, stamp_ns: int, unlabelled: bool) -> None:
        """Go on telling which latency it is where boxes have no labels, until it is known."""
        self.due_ns = NEVER_NS if self._again else stamp_ns + round(TIME_IN_MOTION.interval_s * 1e9)
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
        search.stamp_sigma_s = self.odds.search.stamp_sigma_s
        return search

    def _note_stamps(self) -> None:
        """Judge how exact telemetry's stamps are, by the recent images."""
        images = [one.frame.stamp_ns for one in self._recent.images]
        if not images:
            return
        sigma_s = stamp_sigma_s(images, self._inputs.stamps(images[0], images[-1]))
        tracks = self._published if self.trial is None else self.trial.pipeline
        for search in (self.odds.search, None if tracks is None else tracks.latency):
            if search is not None:
                search.stamp_sigma_s = sigma_s

    def _learnt(self) -> LatencySearch:
        """Return a search that goes on from what decided."""
        search = LatencySearch(self.unknown, self._inputs)
        search.follow(self.odds.search)
        search.conclude()
        return search

    def note(self, scene: PosedFrame, corrects: Mapping[str, str]) -> None:
        """Note the camera of an image, whose result is to be `mixed`.

        Args:
            scene: the image.
            corrects: label of the robot that each reference is which corrects its positions.
        """
        if self.open:
            self.odds.cover.note(scene, corrects)

    def mixed(self, result: FrameResult, local: LocalMap | None) -> FrameResult:
        """Return a result as moments of the mixture of both hypotheses while it is undecided.

        Robots that no trial has are as uncertain as other latencies would displace them.
        """
        if local is None or not (self.open and result.estimates):
            return result
        alone = self.odds.cover.widened(result.estimates)
        if self.trial is not None:
            probability = 1.0 / (1.0 + math.exp(-self.odds.nats))
            alone = self.trial.mixed(result.estimates, alone, probability, local)
        return replace(result, estimates=tuple(alone))


def _unknown(config: EstimatorConfig) -> EstimatorConfig:
    return replace(config, noise=replace(config.noise, latency_s=UNKNOWN_S))
