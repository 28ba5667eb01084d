# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The images a second time, with a latency that is not known: what if it is another one?

While the odds are open, the configured latency's tracks go on, and these run beside them on the
same images; the mixture of both is published. A doubt that turns out wrong is dropped, and nothing
has changed; one that turns out right is published alone from the next image on. Robots keep their
labels: the same box shows the same robot to both, and the same thing of known position. A trial
begins with images of the last seconds, which the published tracks took in with the configured
latency; it takes some of them in with each new image, and is published only when none is left.
"""

from __future__ import annotations

import math
from collections import Counter, deque
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.pipeline import Pipeline
from aerial_gnss_ros.core.estimation.recent_images import SeenImage
from aerial_gnss_ros.core.filter.latency_search import LatencySearch
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.identity.labels import Box, Labels
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.map_origin import MapOrigin
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry
from aerial_gnss_ros.core.tracker.box_account import Settled
from aerial_gnss_ros.core.tracker.tracker import Tracker
from aerial_gnss_ros.core.values.estimates import RobotEstimate
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Rejection


@dataclass(frozen=True)
class LatencyTrialTuning:
    """Chosen numbers of this module, with their units and where they come from."""

    memory: float = 0.9
    """Weight of an image in the balance of measured robots, of the next one's. Judged."""
    most_waiting: int = 1000
    """Greatest number of images that wait for telemetry. Judged."""
    catch_up_hz: float = 40.0
    """Images that are taken in for each second of flight, besides the new ones, until none wait.
    Judged: a slow computer takes 5 ms for each."""
    most_passed_s: float = 1.0
    """Time since the last image that counts for that, at most, s. Judged."""


TUNING = LatencyTrialTuning()


class LatencyTrial:
    """Tracks robots with a latency that is not known.

    Args:
        config: states its sigma.
        inputs: telemetry buffers.
        origin: of `map`.
        labels: of the robots that are published.
        search: what is known of the latency.
        images: to begin with, the oldest first.

    Attributes:
        pipeline: that of this latency.
        identity: labels of its robots.
        log: what it would say.
        waiting: images that it has not taken yet.
        balance: mean number of robots that its images measure beyond those of the configured
            latency.
        behind: whether images wait although their telemetry is there.
        pending: boxes of published images that this trial decides on after it is published.
    """

    def __init__(
        self,
        config: EstimatorConfig,
        inputs: TelemetryBuffers,
        origin: MapOrigin,
        labels: Labels,
        search: LatencySearch,
        images: Iterable[SeenImage] = (),
    ) -> None:
        self._inputs = inputs
        self.log = Events()
        self.identity = labels.beside()
        self._tracker = Tracker(config, self.identity, self.log)
        self.pipeline = Pipeline(config, inputs, self._tracker, origin, self.log)
        self.pipeline.latency = search
        self.waiting: deque[SeenImage] = deque()
        self.balance = 0.0
        self.behind = False
        self._robots: dict[str, RobotEstimate] = {}
        self._shared: Counter[tuple[str, str]] = Counter()
        self._refused: set[Box] = set()
        self.pending: set[Box] = set()
        self._newest_ns = 0
        for image in images:
            self._note(image)
            self.behind = True

    def add(self, image: SeenImage) -> None:
        """Take in an image after the published tracker has."""
        passed_s = (image.frame.stamp_ns - self._newest_ns) * 1e-9
        self._note(image)
        for _ in range(1 + math.ceil(min(passed_s, TUNING.most_passed_s) * TUNING.catch_up_hz)):
            self.behind = bool(self.waiting) and self._take(self.waiting[0])
            if not self.behind:
                return
            self.waiting.popleft()
        self.behind = bool(self.waiting)

    def take_all(self) -> None:
        """Take in all images whose telemetry has come."""
        while self.waiting and self._take(self.waiting[0]):
            self.waiting.popleft()
        self.behind = False

    def _note(self, image: SeenImage) -> None:
        """Let an image wait."""
        frame = image.frame
        self._newest_ns = frame.stamp_ns
        boxes = frame.centers.tolist()
        self.identity.tell(
            {(frame.stamp_ns, *boxes[i]): name for name, i in (image.measured or {}).items()}
        )
        self.waiting.append(image)

    def settled(self, boxes: Settled) -> Settled:
        """Return the decision on boxes that were pending, but for those that are here as well.

        What the trial has refused is refused, the others are used. Those of images that it has not
        taken yet are used: whether they will be is not known.

        Args:
            boxes: what the configured latency's tracker has decided on ending.
        """
        pending = {_box(one) for one in boxes.refused}
        self.pending = self.pipeline.tracking.keep_pending(pending)
        decided = [one for one in boxes.refused if _box(one) not in self.pending]
        refused = tuple(one for one in decided if _box(one) in self._refused)
        return Settled(boxes.used + len(decided) - len(refused), refused)

    def adopt_labels(self) -> None:
        """Call robots as the configured latency's tracker does, which have been published.

        It may have labelled a robot later than this one: then labels are different, and images that
        both have taken in since show whose boxes are the same.
        """
        names = self.identity.adopted(self._shared, self._tracker.classes)
        if names:
            self._tracker.rename(names)
        self._tracker.follow_references({})

    def mixed(
        self,
        estimates: Sequence[RobotEstimate],
        alone: list[RobotEstimate],
        probability: float,
        local: LocalMap,
    ) -> list[RobotEstimate]:
        """Return published robots as moments of the mixture with this trial's.

        Args:
            estimates: by the configured latency.
            alone: what is published of robots that the trial does not have; while images wait, its
                robots are those of seconds ago, and it has none.
            probability: of another latency.
            local: the frame `map`.
        """
        if self.behind:
            return alone
        others = [self._robots.get(one.robot_id) for one in estimates]
        return [
            own if other is None else _mixture(one, other, probability, local)
            for one, own, other in zip(estimates, alone, others, strict=True)
        ]

    def _take(self, image: SeenImage) -> bool:
        """Process an image; return False while telemetry of its scene may still come."""
        frame, known = image.frame, len(image.measured or {})
        scene_ns = frame.stamp_ns - self.pipeline.latency.scene_ns
        samples = self._inputs.at(scene_ns)
        late = len(self.waiting) > TUNING.most_waiting
        if isinstance(samples, MissingTelemetry) and samples.can_arrive and not late:
            return False
        self._tracker.follow_references(image.corrects)
        result = self.pipeline.result(frame, samples)
        self.pipeline.tracking.check()
        self._robots = {one.robot_id: one for one in result.estimates}
        self._refused.update(map(_box, (*result.rejections, *result.late)))
        seen = self.pipeline.measured
        if seen is not None and seen[0].detections.stamp_ns == frame.stamp_ns:
            boxes = {index: name for name, index in (image.measured or {}).items()}
            self._shared.update(
                (own, boxes[index]) for own, index in seen[1].items() if index in boxes
            )
            more = len(seen[1]) - known
            self.balance = TUNING.memory * self.balance + (1.0 - TUNING.memory) * more
        return True


def _mixture(
    one: RobotEstimate, late: RobotEstimate, probability: float, local: LocalMap
) -> RobotEstimate:
    """Return an estimate with the first two moments of two hypotheses.

    Args:
        one: by the first hypothesis.
        late: by the second one, of an earlier time: the robot goes on as it is.
        probability: of the second hypothesis.
        local: the frame `map`.
    """
    step = np.eye(4)
    step[:2, 2:] = (one.stamp_ns - late.stamp_ns) * 1e-9 * np.eye(2)
    first = np.concatenate([one.position, one.velocity])
    off = step @ np.concatenate([late.position, late.velocity]) - first
    mean = first + probability * off
    latitude, longitude = local.places(mean[None, :2])
    spread = probability * (1.0 - probability)
    own, other = one.covariance, step @ late.covariance @ step.T
    return replace(
        one,
        latitude=float(latitude[0]),
        longitude=float(longitude[0]),
        position=mean[:2],
        velocity=mean[2:],
        covariance=(1.0 - probability) * own + probability * other + spread * np.outer(off, off),
    )


def _box(refused: Rejection) -> Box:
    return refused.stamp_ns, refused.u_px, refused.v_px


def learn(pipeline: Pipeline, search: LatencySearch) -> None:
    """Let a pipeline go on with another search if that knows the latency better."""
    own, other = pipeline.latency.found, search.found
    if own is not None and other is not None and other[1] < own[1]:
        pipeline.latency = search
