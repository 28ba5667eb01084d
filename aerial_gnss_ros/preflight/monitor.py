# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Monitors the estimator's inputs without tracking robots: the basis of `aerial-gnss check`.

The monitor receives the same values as the estimator, through the same feed, and trusts the same
stamps. It samples the drone's state a few times a second, with the estimator's interpolation and
pose computation.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Callable
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.geometry.frames import matrix_from_quaternion
from aerial_gnss_ros.core.geometry.magnetic import declination, true_from_magnetic
from aerial_gnss_ros.core.telemetry.arrivals import Arrivals
from aerial_gnss_ros.core.telemetry.buffers import CAMERA_INFO, WATER_LEVEL, TelemetryBuffers
from aerial_gnss_ros.core.telemetry.clock import Clock
from aerial_gnss_ros.core.telemetry.depths import depth_input
from aerial_gnss_ros.core.telemetry.pose import PoseBuilder
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry
from aerial_gnss_ros.core.telemetry.series import (
    Sample,
    fix_series,
    orientation_series,
    scalar_series,
)
from aerial_gnss_ros.core.telemetry.stamp_decision import Decision
from aerial_gnss_ros.core.values.camera_pose import CameraPose
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Input, Reason
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar
from aerial_gnss_ros.preflight.flight_state import STEP_NS, FlightState
from aerial_gnss_ros.preflight.input_record import InputRecord
from aerial_gnss_ros.preflight.posed_boxes import PosedImages

Array = NDArray[np.float64]
V = TypeVar("V", Orientation, Scalar)

MAX_STATES = 18_000
"""Number of states kept: one hour."""

_JUMP_NS = 30_000_000_000
_BACK_NS = 1_000_000_000


class InputMonitor:
    """Receives the values that the feed would give to an estimator.

    Args:
        config: the estimator's parameters.

    Attributes:
        records: message statistics by input.
        states: the drone's states, the oldest first.
        boxes: images with boxes.
        reasons: counts of states without a pose, by reason.
        camera: the newest camera model.
        troubles: sentences that say more about a reason.
    """

    def __init__(self, config: EstimatorConfig) -> None:
        self.records: dict[str, InputRecord] = {}
        self.states: deque[FlightState] = deque(maxlen=MAX_STATES)
        self.boxes = PosedImages(round(config.camera.latency_s * 1e9))
        self.reasons: Counter[Reason] = Counter()
        self.camera: CameraModel | None = None
        self.troubles: set[str] = set()
        self._config = config
        self._inputs = TelemetryBuffers(config)
        self._posing = PoseBuilder(config)
        # The estimator keeps only what it needs; the sign tests use everything.
        self._fixes = fix_series(config.fix.max_gap)
        self._bodies = orientation_series(config.attitude.max_gap)
        self._heights = scalar_series(config.height.max_gap)
        self._wait_ns = round(config.max_wait * 1e9)
        # Inputs that the pose needs; a camera on a mast has none, and boxes or CameraInfo give the
        # time.
        self._needed = [i.value for i in Input if self._inputs.state_without_messages(i) is None]
        held = (CAMERA_INFO, WATER_LEVEL, *map(depth_input, config.depth.by_topic()))
        self._log = Events()
        self._arrivals = Arrivals(
            Clock(self._needed, held), self.records, Counter(), self._log, self._reset_time
        )
        self._next_ns: int | None = None
        self._arrival_ns = 0
        self._name = ""

    @property
    def events(self) -> list[str]:
        """Sentences about stamps and clocks."""
        return self._log.sentences

    def arriving(self, name: str, arrival_ns: int) -> None:
        """Record that a message of an input is about to be passed to the feed."""
        self._name, self._arrival_ns = name, arrival_ns
        record = self.records.setdefault(name, InputRecord(first_arrival_ns=arrival_ns))
        record.count += 1
        record.last_arrival_ns = arrival_ns

    def add_fix(self, fix: Fix) -> None:
        """Add a position of the drone."""

        def keep() -> str:
            trouble = self._inputs.add(Input.FIX, fix)
            self._fixes.add(replace(fix, valid=False) if trouble else fix)
            return trouble

        self._arrive(fix.stamp_ns, keep)

    def add_attitude(self, attitude: Orientation) -> None:
        """Add an orientation of the body."""
        self._take(Input.ATTITUDE, attitude, self._bodies.add)

    def add_gimbal(self, gimbal: Orientation) -> None:
        """Add an orientation of the camera; of one fixed to the body it comes with the attitude."""
        if Input.GIMBAL.value not in self._name:
            self._inputs.add(Input.GIMBAL, gimbal)
            return
        self._take(Input.GIMBAL, gimbal, lambda _gimbal: None)

    def add_height(self, height: Scalar) -> None:
        """Add a height of the drone."""
        self._take(Input.HEIGHT, height, self._heights.add)

    def add_water_level(self, level: Scalar) -> None:
        """Add a water level."""
        self._arrive(level.stamp_ns, lambda: self._inputs.add_level(level))

    def add_depth(self, _class_id: str, depth: Scalar) -> None:
        """Record that a robot's depth arrived; it is not a state of the drone."""
        self._arrive(depth.stamp_ns, lambda: "")

    def add_reference(self, name: str, fix: Fix) -> None:
        """Take a position that a reference sends."""
        self._arrive(fix.stamp_ns, lambda: self._inputs.references.add(name, fix))

    def add_camera(self, stamp_ns: int, camera: CameraModel | None) -> None:
        """Add the camera model; None if it was unusable."""

        def keep() -> str:
            self.camera = camera or self.camera
            return "" if camera is not None else "it describes no usable camera"

        self._arrive(stamp_ns, keep)

    def add_detections(self, frame: DetectionFrame) -> None:
        """Add an image's boxes."""

        def keep() -> str:
            self.boxes.add(frame)
            return ""

        self._arrive(frame.stamp_ns, keep)

    def refuse(self, _name: str, trouble: str) -> None:
        """Record an unreadable message, and why."""
        self.records[self._name].refuse(trouble)

    def advance(self, final: bool = False) -> None:
        """Sample the drone as far as its inputs allow.

        Args:
            final: nothing more comes.
        """
        self._arrivals.tick(self._arrival_ns)
        if final:
            self._arrivals.flush()
        self.boxes.settle(self.camera, lambda stamp_ns: self._pose_at(stamp_ns, final))
        if self._next_ns is None:
            return
        names = [name for name in self._needed if name in self.records] or list(self.records)
        newest = max(self.records[name].last_stamp_ns for name in names)
        if self._next_ns - newest > _BACK_NS:  # all clocks were set back, one after another
            self._sample_anew(newest)
        if newest - self._next_ns > _JUMP_NS:
            self._next_ns = newest - self._wait_ns
        while self._next_ns <= newest:
            samples = self._inputs.at(self._next_ns)
            waits = newest - self._next_ns < self._wait_ns and not final
            if isinstance(samples, MissingTelemetry) and samples.can_arrive and waits:
                return
            reason = samples.reason if isinstance(samples, MissingTelemetry) else None
            pose = None
            if not isinstance(samples, MissingTelemetry):
                found = self._posing.pose(samples)
                pose, reason = (found, None) if isinstance(found, CameraPose) else (None, found)
                if self._posing.trouble:
                    self.troubles.add(self._posing.trouble)
            at_the_end = final and str(reason).startswith("stale_")  # would have come
            if not at_the_end or newest - self._next_ns >= self._wait_ns:
                self._keep(self._next_ns, pose, reason)
            self._next_ns += STEP_NS

    def _pose_at(self, stamp_ns: int, final: bool) -> CameraPose | bool:
        """Return the camera's pose at a time, ns, else whether it may still come."""
        samples = self._inputs.at(stamp_ns)
        if isinstance(samples, MissingTelemetry):
            return samples.can_arrive and not final
        found = self._posing.pose(samples)
        return found if isinstance(found, CameraPose) else False

    def _keep(self, stamp_ns: int, pose: CameraPose | None, reason: Reason | None) -> None:
        fix, body = self._fixes.at(stamp_ns), self._bodies.at(stamp_ns)
        height = self._heights.at(stamp_ns)
        place = fix.value if isinstance(fix, Sample) and fix.value.valid else None
        self.states.append(
            FlightState(
                stamp_ns,
                place,
                self._body(body.value, place) if isinstance(body, Sample) else None,
                height.value.value if isinstance(height, Sample) else None,
                pose,
                reason,
            )
        )
        if reason is not None:
            self.reasons[reason] += 1

    def _body(self, attitude: Orientation, fix: Fix | None) -> Array | None:
        body = matrix_from_quaternion(attitude.quaternion)
        if self._config.attitude.north == "true":
            return body
        if fix is None:
            return None
        altitude = self._posing.altitude(fix)
        try:
            east = declination(fix.latitude, fix.longitude, attitude.stamp_ns, altitude)
        except InputError:
            return None
        return true_from_magnetic(body, east)

    def _take(self, source: Input, value: V, add: Callable[[V], None]) -> None:
        """Record a sample, and add it if it is usable."""

        def keep() -> str:
            trouble = self._inputs.add(source, value)
            if not trouble:
                add(value)
            return trouble

        self._arrive(value.stamp_ns, keep)

    def _arrive(self, stamp_ns: int, keep: Callable[[], str]) -> None:
        """Process a message, now or once its stamp is trusted.

        Args:
            stamp_ns: its stamp, ns.
            keep: stores its value; returns why it is unusable, else empty.
        """
        name, arrival_ns = self._name, self._arrival_ns

        def let_in() -> None:
            trouble, record = keep(), self.records[name]
            if trouble:
                record.refuse(trouble)
            record.last_stamp_ns = max(stamp_ns, record.last_stamp_ns)
            record.delays_ns.append(arrival_ns - stamp_ns)
            if self._next_ns is None and (name in self._needed or not self._needed):
                self._sample_anew(stamp_ns)

        self._arrivals.receive(name, stamp_ns, let_in)

    def _reset_time(self, decision: Decision) -> None:
        """Discard what precedes a reset of time or of an input's clock."""
        self._log.add(f"{decision}.")
        if decision.time_reset:
            moved = set(self.records) - set(decision.kept)
            self._inputs.clear(decision.kept)
            self.states.clear()
            self.boxes.clear()
            self._next_ns = None
        else:
            moved = set(decision.moved)
            self._inputs.forget(moved)
        if Input.FIX.value in moved:
            self._fixes.clear()
        if Input.ATTITUDE.value in moved:
            self._bodies.clear()
        if Input.HEIGHT.value in moved:
            self._heights.clear()
        for name in moved & set(self.records):
            self.records[name].last_stamp_ns = 0

    def _sample_anew(self, stamp_ns: int) -> None:
        """Discard the states and resume sampling at a time, rounded up."""
        self.states.clear()
        self._next_ns = -(-stamp_ns // STEP_NS) * STEP_NS
