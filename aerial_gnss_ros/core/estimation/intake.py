# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Intake of messages: stamps are checked, samples stored, messages counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Protocol

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.estimation.attempt import attempt
from aerial_gnss_ros.core.estimation.time_base import TimeBase
from aerial_gnss_ros.core.telemetry.arrivals import Arrivals
from aerial_gnss_ros.core.telemetry.buffers import CAMERA_INFO, WATER_LEVEL, TelemetryBuffers
from aerial_gnss_ros.core.telemetry.clock import DETECTIONS, Clock
from aerial_gnss_ros.core.telemetry.depths import depth_input
from aerial_gnss_ros.core.telemetry.input_status import InputStatus, MessageCounter
from aerial_gnss_ros.core.telemetry.reference_places import is_reference, reference_input
from aerial_gnss_ros.core.telemetry.stamp_decision import Decision
from aerial_gnss_ros.core.telemetry.steady import Steady
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Input
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

_ALSO = ", also of what other inputs repeat no longer"
LONG_S = 10.0
"""Time after which an unusable input is reported again, s."""


class Receiver(Protocol):
    """Handles the effects of incoming messages."""

    def receive_fix(self, fix: Fix) -> str:
        """Process a usable fix; return why it is still unusable, else empty."""

    def receive_image(self, frame: DetectionFrame) -> None:
        """Add an image's boxes."""

    def begin_elsewhere(self, moved: str) -> None:
        """Handle a drone that turned out to be elsewhere; `moved` describes it."""

    def note_lead(self) -> None:
        """Handle that stamps of telemetry lead those of images more than before."""

    def note_correction(self) -> None:
        """Handle that telemetry was wrong, and that stored samples are right now."""

    def reset_time(self, decision: Decision, passed_s: float | None) -> None:
        """Handle a reset of time or of an input's clock.

        Args:
            decision: on the stamps.
            passed_s: time since the last image arrived, s; None: unknown.
        """


class Intake:
    """Processes incoming messages.

    Args:
        config: of the inputs.
        inputs: stores samples.
        time: shifts stamps.
        dropped: counts images with wrong stamps.
        log: receives sentences about refusals.
        receiver: handles effects of messages.

    Attributes:
        tallies: count messages, by input.
        arrivals: holds messages with outlying stamps.
    """

    def __init__(
        self,
        config: EstimatorConfig,
        inputs: TelemetryBuffers,
        time: TimeBase,
        dropped: Counter[str],
        log: Events,
        receiver: Receiver,
    ) -> None:
        self._inputs, self._time, self._log, self._receiver = inputs, time, log, receiver
        needed = [str(i) for i in Input if inputs.state_without_messages(i) is None]
        held = [WATER_LEVEL, CAMERA_INFO, *map(depth_input, config.depth.by_topic())]
        sent = map(reference_input, inputs.references.sent)
        self.tallies: dict[str, MessageCounter] = {
            name: MessageCounter()
            for name in (*map(str, Input), *held[:2], DETECTIONS, *held[2:], *sent)
        }
        self.arrivals = Arrivals(
            Clock(needed, held), self.tallies, dropped, log, self._reset_time, receiver.note_lead
        )
        self._steady = Steady()
        self._image_steady_ns: int | None = None

    def tick(self, now_ns: int, steady_ns: int | None) -> None:
        """Update the node's time.

        Args:
            now_ns: node time, ns.
            steady_ns: of a monotonic clock, ns; None: there is none.
        """
        self.arrivals.tick(now_ns, self._steady.update(now_ns, steady_ns))

    def expect_references(self) -> None:
        """Count the messages of the references that there are now, and of no others."""
        sent = [reference_input(name) for name in self._inputs.references.sent]
        for name in filter(is_reference, list(self.tallies)):
            if name not in sent:
                del self.tallies[name]
        for name in sent:
            self.tallies.setdefault(name, MessageCounter())

    def statuses(self, patience_ns: int) -> dict[str, InputStatus]:
        """Return the status of each input, by its name.

        Args:
            patience_ns: longest wait of images, ns.
        """
        newest_ns = self.tallies[DETECTIONS].last_stamp_ns
        found = {}
        for name, tally in self.tallies.items():
            status = tally.status(name, newest_ns, patience_ns)
            found[name] = self._inputs.without_messages(status)
        return found

    def add_fix(self, fix: Fix) -> None:
        """Add a position of the drone."""
        self._arrive(Input.FIX.value, fix.stamp_ns, lambda: self._keep_fix(fix))

    def add(self, source: Input, value: Orientation | Scalar) -> None:
        """Add an orientation or a height."""
        self._arrive(source.value, value.stamp_ns, lambda: self._keep(source, value))

    def add_water_level(self, level: Scalar) -> None:
        """Add a water level, valid until replaced."""
        self._arrive(WATER_LEVEL, level.stamp_ns, lambda: self._keep_level(level))

    def add_depth(self, class_id: str, depth: Scalar) -> None:
        """Add a depth that robots of a class send (empty: all); it is valid for a while."""
        name, of_time = depth_input(class_id), self._time.shifted
        self._arrive(
            name, depth.stamp_ns, lambda: self._inputs.depths.add(class_id, of_time(depth))
        )

    def add_reference(self, name: str, fix: Fix) -> None:
        """Add a position sent by a reference."""
        of_time, known = self._time.shifted, self._inputs.references
        self._arrive(reference_input(name), fix.stamp_ns, lambda: known.add(name, of_time(fix)))

    def add_camera(self, stamp_ns: int, camera: CameraModel | None) -> None:
        """Add the camera model; None if it was unusable."""

        def keep() -> None:
            trouble = "" if camera is not None else "it describes no camera"
            self.tallies[CAMERA_INFO].add(stamp_ns, trouble)
            self._inputs.cameras.add(self._time.of(stamp_ns), camera)

        self.arrivals.receive(CAMERA_INFO, stamp_ns, keep)

    def add_detections(self, frame: DetectionFrame) -> None:
        """Add one image's boxes."""

        def keep() -> None:
            self.tallies[DETECTIONS].add(frame.stamp_ns)
            self._image_steady_ns = self._steady.now_ns
            self._receiver.receive_image(frame)

        self.arrivals.receive(DETECTIONS, frame.stamp_ns, keep)

    def refuse(self, name: str, trouble: str) -> None:
        """Count an unreadable message.

        Args:
            name: of the input.
            trouble: why, in words.
        """
        self.tallies.setdefault(name, MessageCounter()).refuse(trouble)
        self._tell_bad(name, trouble)

    def _arrive(self, name: str, stamp_ns: int, keep: Callable[[], str]) -> None:
        """Store a message's value and count it, once its stamp is trusted.

        Args:
            name: of the input.
            stamp_ns: of the message.
            keep: stores the value; returns why it is unusable, in words, or empty.
        """
        self.arrivals.receive(name, stamp_ns, lambda: self._count(name, stamp_ns, keep))

    def _count(self, name: str, stamp_ns: int, keep: Callable[[], str]) -> None:
        trouble = attempt(keep)
        if isinstance(trouble, Exception):
            trouble = f"it cannot be kept ({type(trouble).__name__}: {trouble})"
        self.tallies[name].add(stamp_ns, trouble)
        if trouble:
            self._tell_bad(name, trouble)

    def _reset_time(self, decision: Decision) -> None:
        self._receiver.reset_time(decision, self._steady.since_s(self._image_steady_ns))
        if decision.time_reset:
            for tally in self.tallies.values():
                tally.reset_stamps()

    def _keep_fix(self, fix: Fix) -> str:
        return self._keep(Input.FIX, fix) or self._receiver.receive_fix(fix)

    def _keep_level(self, level: Scalar) -> str:
        trouble = self._inputs.add_level(self._time.shifted(level))
        return trouble or self._look_for_move()

    def _keep(self, source: Input, value: Fix | Orientation | Scalar) -> str:
        """Store a sample; return why it is unusable, else empty."""
        known = len(self._inputs.sent_again)
        trouble = self._inputs.add(source, self._time.shifted(value))
        if len(self._inputs.sent_again) > known:
            self._receiver.note_correction()
            self._log.warn_once(
                f"sent again {source}",
                f"Each value of {source} is sent several times until the next is measured: only "
                f"the first sample of each is used{_ALSO if source is Input.FIX else ''}.",
            )
        return trouble or self._look_for_move()

    def _look_for_move(self) -> str:
        """Report a drone that turned out to be elsewhere; the sample is usable."""
        moved = self._inputs.plausibility.pop_relocation()
        if moved:
            self._receiver.begin_elsewhere(moved)
        return ""

    def _tell_bad(self, name: str, trouble: str) -> None:
        """Report the first unusable message of an input, and an input without usable ones."""
        self._log.warn_once(f"bad {name}", f"A message on {name} is of no use: {trouble}.")
        if self.tallies[name].bad_s > LONG_S:
            self._log.warn_once(
                f"long bad {name}",
                f"No message on {name} has been of use for {LONG_S:.0f} s, the last one because "
                f"{trouble}.",
            )
