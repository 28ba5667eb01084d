# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From images that wait to results, in order; where time, `map` or scene change, tracks begin anew.

An image waits until telemetry brackets its scene, at most `max_wait` from the first `advance` after
its arrival (longer by a negative latency, whose telemetry arrives later).
"""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.attempt import attempt
from aerial_gnss_ros.core.estimation.found_again import FoundAgain
from aerial_gnss_ros.core.estimation.image_queue import ImageQueue
from aerial_gnss_ros.core.estimation.origin_file import OriginKeeper
from aerial_gnss_ros.core.estimation.published_tracks import PublishedTracks
from aerial_gnss_ros.core.estimation.result_queue import ResultQueue
from aerial_gnss_ros.core.estimation.state_file import NameKeeper
from aerial_gnss_ros.core.estimation.time_base import TimeBase
from aerial_gnss_ros.core.estimation.unmatched_telemetry import UnmatchedTelemetry
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.map_origin import MapOrigin
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry
from aerial_gnss_ros.core.telemetry.stamp_decision import Decision
from aerial_gnss_ros.core.tracker.box_account import Settled
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.estimates import FrameResult
from aerial_gnss_ros.core.values.events import Events, WarningText
from aerial_gnss_ros.core.values.samples import Fix


class FrameProcessor:
    """Processes images, and handles the effects of messages on tracks (see `Receiver`).

    Args:
        config: states how long images wait.
        inputs: telemetry buffers.
        origin: of `map`.
        tracks: of the robots.
        time: shifts stamps.
        names: keeps labels over a restart.
        kept_origin: keeps the origin over a restart.
        dropped: counts images without a result.
        log: receives sentences.

    Attributes:
        results: those that are due, and the account of their boxes.
    """

    def __init__(
        self,
        config: EstimatorConfig,
        inputs: TelemetryBuffers,
        origin: MapOrigin,
        tracks: PublishedTracks,
        time: TimeBase,
        names: NameKeeper,
        kept_origin: OriginKeeper,
        dropped: Counter[str],
        log: Events,
    ) -> None:
        self._inputs, self._origin, self._tracks, self._time = inputs, origin, tracks, time
        self._names, self._kept_origin, self._log = names, kept_origin, log
        late_s = max(0.0, config.fix.latency_s, config.height.latency_s)
        self._wait_ns = round((config.max_wait + late_s) * 1e9)
        self._images = ImageQueue(dropped)
        self._found_again = FoundAgain()
        self._unmatched = UnmatchedTelemetry(config.max_wait, log)
        self.results = ResultQueue()

    @property
    def patience_ns(self) -> int:
        """Longest wait of an image for telemetry of its scene, ns: from the scene's time on."""
        later_ns = max(0, self._inputs.fix_later_ns)
        return self._wait_ns + max(0, later_ns - self._tracks.pipeline.latency.scene_ns)

    def advance(self, now_ns: int) -> list[FrameResult]:
        """Return the results that are due at a time of the node, ns."""
        self._images.tick(now_ns)
        patience_ns = self.patience_ns
        while self._images.waiting:
            if not self._finish_first(self._images.is_late(now_ns, patience_ns)):
                break
        return self.results.take()

    def predicted(self, stamp_ns: int) -> FrameResult | None:
        """Return the robots predicted without an image; see `Estimator.predicted`."""
        time_ns = self._images.time_before(self._time.of(stamp_ns))
        return None if time_ns is None else self._time.stamped(self._tracks.predicted(time_ns))

    def flush(self) -> list[FrameResult]:
        """Return results for all waiting images at the end of input."""
        self._origin.settle()
        self._finish_all()
        self._names.save(self._tracks.labels, self._time.shift_ns)
        self.results.end(self._stamped(self._tracks.pipeline.end()))
        return self.results.take()

    def receive_image(self, frame: DetectionFrame) -> None:
        """Queue an image until telemetry of its scene arrives."""
        if self._images.add(self._time.shifted(frame), self._inputs.newest_ns()):
            self._finish_first()

    def receive_fix(self, fix: Fix) -> str:
        """Pass a usable fix to the map; return why it is still unusable, else empty."""
        before = self._origin.local
        lasted_s = self._inputs.plausibility.agreed_s
        trouble = self._origin.accept(fix, lasted_s, bool(self.results.robots))
        if before is not None and self._origin.local is not before:
            self._tracks.pipeline.reset()
            self._tracks.forget_images()
        return trouble

    def begin_elsewhere(self, moved: str) -> None:
        """End all tracks after the drone turned out to be elsewhere.

        Its earlier or its new position was wrong, and with it all positions of robots from there.

        Args:
            moved: the change, in words.
        """
        robots = bool(self.results.robots)
        self._forget_robots()
        self._log.counts["began_elsewhere"] += 1
        ended = ": tracks are cleared, and robots get new labels" if robots else ""
        self._log.add(WarningText(f"{moved}{ended}."))

    def note_lead(self) -> None:
        """Ask anew how late images and the fix are."""
        self._tracks.doubt_latencies()

    def note_correction(self) -> None:
        """Have images taken in again for which telemetry was wrong."""
        self._tracks.note_correction()

    def reset_time(self, decision: Decision, passed_s: float | None) -> None:
        """Discard what precedes a reset of time or of an input's clock.

        Args:
            decision: on the stamps.
            passed_s: time since the last image arrived, s; None: unknown.
        """
        if not decision.time_reset:
            self._inputs.forget(decision.moved)
            self._log.add(f"{decision}; its earlier telemetry is discarded.")
            return
        self._finish_all()
        self._unmatched.reset()
        by_ns = self._time.step_ns(decision, passed_s, self._images.last_ns)
        if by_ns is None or self._tracks.pipeline.latency.searches:
            cleared = "telemetry and tracks are cleared, and robots get new labels"
            self._inputs.clear(decision.kept)
            self._forget_robots()
            self._time.reset()
            self._images.last_ns = None
        else:
            cleared = "telemetry is cleared; robots that are where they were keep their labels"
            self._inputs.clear()
            self._tracks.forget_images()
            self._time.step(by_ns, self._images.last_ns or 0)
            self._found_again.expect(self.results.robots)
        self._log.counts[f"time_went_{'backward' if decision.by_ns < 0 else 'forward'}"] += 1
        self._log.add(f"{decision}: {cleared}.")

    def _finish_all(self) -> None:
        while self._images.waiting:
            self._finish_first()

    def _finish_first(self, final: bool = True) -> bool:
        """Process the oldest image; return False if it must keep waiting."""
        image = self._images.waiting[0]
        frame = image.frame
        samples = self._tracks.telemetry(frame)
        if isinstance(samples, MissingTelemetry) and samples.can_arrive and not final:
            return False
        scene_ns = frame.stamp_ns - self._tracks.pipeline.latency.scene_ns
        self._unmatched.update(scene_ns, samples, image.newest_ns)
        result = self._tracks.result(frame, samples)
        self._images.pop()  # by now: an exception that ends the program leaves it in the queue
        self.results.add(self._time.stamped(result))
        self._keep(result)
        settled = self._tracks.weigh_latency(frame)
        if settled != Settled():
            self.results.decide(self._stamped(settled))
        if self._found_again.names and self._found_again.failed(result):
            self._log.add(
                "Robots are not detected where they were before time was reset: it is another "
                "scene, tracks are cleared, and robots get new labels."
            )
            self._forget_robots()
        return True

    def _stamped(self, settled: Settled) -> Settled:
        """Return decisions with the own stamps of their images."""
        return replace(settled, refused=self._time.refused(settled.refused))

    def _keep(self, result: FrameResult) -> None:
        """Save origin and labels if due; positions matter more than the files."""

        def keep() -> None:
            self._kept_origin.keep(result.datum)
            self._names.keep(result, self._tracks.labels, self._time.shift_ns)

        error = attempt(keep)
        if error is not None:
            self._log.warn_once(
                "state_file", f"state_file cannot be written ({type(error).__name__}: {error})."
            )

    def _forget_robots(self) -> None:
        self._found_again.reset()
        self._tracks.reset()
        self._names.reset()
        self.results.forget_robots()
