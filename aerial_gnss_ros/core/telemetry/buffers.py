# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The estimator's telemetry: a buffer for each input, constants in place of missing topics."""

from __future__ import annotations

import math
from collections.abc import Collection
from dataclasses import replace
from functools import lru_cache
from typing import cast

import numpy as np

from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.geometry.frames import matrix_from_rpy, quaternion_from_matrix
from aerial_gnss_ros.core.telemetry.cameras import Cameras
from aerial_gnss_ros.core.telemetry.depths import Depths
from aerial_gnss_ros.core.telemetry.input_buffer import (
    AnyBuffer,
    fix_buffer,
    orientation_buffer,
    scalar_buffer,
)
from aerial_gnss_ros.core.telemetry.input_status import InputState, InputStatus
from aerial_gnss_ros.core.telemetry.interpolation_error import Uncertain
from aerial_gnss_ros.core.telemetry.plausibility import Plausibility
from aerial_gnss_ros.core.telemetry.reference_places import ReferencePlaces, reference_input
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry, SceneTelemetry
from aerial_gnss_ros.core.telemetry.series import Missing, Series, held_series
from aerial_gnss_ros.core.telemetry.validity import validate
from aerial_gnss_ros.core.values.rejection import Input, Reason
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

CAMERA_INFO, WATER_LEVEL = "camera_info", "water_level"
_TELEMETRY = frozenset(source.value for source in Input)


class TelemetryBuffers:
    """Stores telemetry and returns its values at a time.

    Unusable samples (NaN, no fix, a quaternion that is not unit) are stored as such: a scene
    between them is refused instead of interpolated across them.

    Attributes:
        depths: of robots.
        cameras: by time.
        references: positions of references.
        plausibility: tests each sample before it is stored.
        sent_again: inputs that were found to send values again until the next is measured.
        fix_later_ns: how much later than configured a fix is stamped, ns.
    """

    def __init__(self, config: EstimatorConfig, keep_s: float = 60.0) -> None:
        self._config = config
        self._keep_s = keep_s
        self.plausibility = Plausibility(config)
        self._buffers: dict[Input, AnyBuffer] = {}
        self._constants: dict[Input, Fix | Orientation | Scalar] = {}
        self._late_ns = {
            Input.FIX: round(config.fix.latency_s * 1e9),
            Input.HEIGHT: round(config.height.latency_s * 1e9),
        }
        self.fix_later_ns = 0
        self._set_up_fix()
        self._set_up_orientations()
        if config.height.source == "constant":
            self._constants[Input.HEIGHT] = Scalar(0, config.height.value_m)
        elif config.height.source == "topic":
            self._buffers[Input.HEIGHT] = scalar_buffer(config.height.max_gap, keep_s)
        self.depths = Depths(config.depth, keep_s)
        self.references = ReferencePlaces(config.references)
        self._level: Series[Scalar] = held_series(keep_s=keep_s)
        self._first_level = config.water_level.value_m
        self.sent_again: list[Input] = []
        self.cameras = Cameras(config, keep_s)

    def _set_up_fix(self) -> None:
        fix = self._config.fix
        if fix.source == "topic":
            self._buffers[Input.FIX] = fix_buffer(fix.max_gap, self._keep_s)
            return
        latitude, longitude = math.radians(fix.latitude_deg), math.radians(fix.longitude_deg)
        self._constants[Input.FIX] = Fix(0, latitude, longitude, fix.altitude_m)

    def _set_up_orientations(self) -> None:
        config = self._config
        wanted: list[tuple[Input, str, float, tuple[float, ...]]] = []
        if config.needs_attitude:
            attitude = config.attitude
            wanted.append((Input.ATTITUDE, attitude.source, attitude.max_gap, attitude.rpy_deg))
        if config.gimbal.reference != "fixed":
            gimbal = config.gimbal
            wanted.append((Input.GIMBAL, gimbal.source, gimbal.max_gap, gimbal.rpy_deg))
        for source, kind, max_gap, rpy_deg in wanted:
            if kind != "constant":
                self._buffers[source] = orientation_buffer(max_gap, self._keep_s)
            else:
                matrix = matrix_from_rpy(*np.radians(rpy_deg))
                self._constants[source] = Orientation(0, quaternion_from_matrix(matrix))

    def reconfigure(self, config: EstimatorConfig) -> None:
        """Use the focal length and the references of another configuration from now on."""
        self._config = config
        self.cameras.rescale(config.calibration.focal_scale)
        self.references = self.references.replaced(config.references)

    def _held_s(self, source: Input) -> float:
        """Return the time within which an input's repeated value is no measurement, s."""
        positions = self._buffers.get(Input.FIX)
        by_positions = 0.0 if positions is None else positions.held.held_s
        return max(self._buffers[source].held.held_s, by_positions)

    @property
    def constant_fix(self) -> Fix | None:
        """The position of a camera on a mast, None for one that flies."""
        return cast("Fix | None", self._constants.get(Input.FIX))

    def state_without_messages(self, source: Input) -> InputState | None:
        """Return unused or constant for an input that needs no messages, else None."""
        if source in self._buffers:
            return None
        return InputState.CONSTANT if source in self._constants else InputState.UNUSED

    def without_messages(self, status: InputStatus) -> InputStatus:
        """Return an input's status, unused or constant if it needs no messages."""
        name, state = status.name, None
        if name in _TELEMETRY:
            state = self.state_without_messages(Input(name))
        elif name != "detections" and name not in map(reference_input, self.references.sent):
            given = self.cameras.fixed is not None if name == CAMERA_INFO else not status.count
            if given:
                state = InputState.CONSTANT
            elif status.state is InputState.STALE:
                state = InputState.OK  # a camera or a level is valid until replaced
        return status if state is None else replace(status, state=state)

    def add(self, source: Input, value: Fix | Orientation | Scalar) -> str:
        """Store a sample if the configuration needs it; return why it is unusable, else empty."""
        trouble, kept = self._judged(source, value)
        late_ns = self._late_ns.get(source, 0)
        if late_ns:
            kept = replace(kept, stamp_ns=kept.stamp_ns - late_ns)
        buffer = self._buffers.get(source)
        if buffer is None:
            return trouble
        if trouble:
            buffer.add_unusable(kept)  # type: ignore[arg-type]
            return trouble
        self._judge_held(source, kept)
        return buffer.add(kept, self._held_s(source))  # type: ignore[arg-type]

    def _judge_held(self, source: Input, value: Fix | Orientation | Scalar) -> None:
        """Judge by a sample whether its input sends values again until the next is measured."""
        known = self._held_s(source)
        self._buffers[source].held.update(value)
        if self._held_s(source) and not known:
            self.sent_again.append(source)
            for one, buffer in self._buffers.items():
                buffer.discard_repeated(self._held_s(one), self._is_usable)

    def _is_usable(self, value: Fix | Orientation | Scalar) -> bool:
        return not validate(value, self._config.limits)[0]

    def _judged(
        self, source: Input, value: Fix | Orientation | Scalar
    ) -> tuple[str, Fix | Orientation | Scalar]:
        if isinstance(value, Fix):
            return self.plausibility.fix(value)
        if source is Input.HEIGHT and isinstance(value, Scalar):
            return self.plausibility.height(value)
        if isinstance(value, Orientation):
            return self.plausibility.orientation(source, value)
        return validate(value, self._config.limits)

    def add_level(self, level: Scalar) -> str:
        """Store a water level until it is replaced; an implausible one is ignored."""
        trouble = self.plausibility.level(level)
        if not trouble:
            self._level.add(level)
        return trouble

    def forget(self, names: Collection[str]) -> None:
        """Discard the samples of some inputs whose clocks were set."""
        for source, buffer in self._buffers.items():
            if source.value in names:
                buffer.clear()
        self.plausibility.clear()

    def clear(self, kept: Collection[str] = ()) -> None:
        """Discard all samples; level and camera stay, as they may not be sent again.

        Args:
            kept: inputs whose samples stay valid.
        """
        self.forget({source.value for source in self._buffers} - set(kept))
        last = self._level.last
        self._first_level = last.value if last is not None else self._first_level
        self._level.clear()
        self.depths.clear()
        self.references.clear()
        self.cameras.clear()

    def stamps(self, first_ns: int, last_ns: int) -> list[list[int]]:
        """Return for each input on a topic its stamps, as sent, from one time to another, ns."""
        found = []
        for source, buffer in self._buffers.items():
            late_ns = self._late_ns.get(source, 0)
            sent = buffer.series.stamps(first_ns - late_ns, last_ns - late_ns)
            found.append([one + late_ns for one in sent])
        return found

    def newest_ns(self) -> dict[Input, int]:
        """Return the time of the newest sample of each input on a topic that has any, ns."""
        found = {source: one.series.last_stamp_ns for source, one in self._buffers.items()}
        return {source: stamp_ns for source, stamp_ns in found.items() if stamp_ns is not None}

    def at(self, stamp_ns: int) -> SceneTelemetry | MissingTelemetry:
        """Return all telemetry at the time of a scene, or the missing input."""
        values = self._constants.copy()
        uncertain: dict[Input, Uncertain] = {}
        oldest_s = 0.0
        for source, buffer in self._buffers.items():
            found = buffer.at(self._stamped_ns(source, stamp_ns))
            if isinstance(found, Missing):
                return self._missing(stamp_ns)
            sample, error = found
            values[source] = sample.value
            oldest_s = max(oldest_s, sample.age_s)
            if error is not None:
                uncertain[source] = error
        level = self._level.latest(stamp_ns)
        height = cast("Scalar | None", values.get(Input.HEIGHT))
        return SceneTelemetry(
            stamp_ns,
            cast("Fix", values[Input.FIX]),
            cast("Orientation | None", values.get(Input.ATTITUDE)),
            cast("Orientation | None", values.get(Input.GIMBAL)),
            None if height is None else height.value,
            self._first_level if level is None else level.value,
            oldest_s,
            uncertain,
        )

    def _stamped_ns(self, source: Input, time_ns: int) -> int:
        """Return which stamp in a series an input of a time has, ns."""
        return time_ns + self.fix_later_ns if source is Input.FIX else time_ns

    def _missing(self, stamp_ns: int) -> MissingTelemetry:
        """Return the input that is missing at a time."""
        lacking: list[MissingTelemetry] = []
        for source, buffer in self._buffers.items():
            series, time_ns = buffer.series, self._stamped_ns(source, stamp_ns)
            missing = series.missing_at(time_ns)
            if missing is Missing.BEFORE:
                later_s = ((series.first_stamp_ns or 0) - time_ns) * 1e-9
                lacking.append(MissingTelemetry(Reason.no(source), False, later_s))
            elif missing is not None:
                lacking.append(_lacking(source, missing))
        # An input that can never arrive is reported; late ones need no wait then.
        return min(lacking, key=lambda one: one.can_arrive)


@lru_cache(maxsize=64)  # called for every message while an image waits
def _lacking(source: Input, missing: Missing) -> MissingTelemetry:
    return MissingTelemetry(missing.reason(source), missing.can_arrive)
