# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The report of `aerial-gnss check`: drone, camera, inputs and sign tests, in words."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from aerial_gnss_ros.adapters.feed import Subscription
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.geometry.frames import heading_from_yaw, yaw_of
from aerial_gnss_ros.core.telemetry.vertical_datum import describe_datums
from aerial_gnss_ros.preflight.flight_state import FlightState
from aerial_gnss_ros.preflight.monitor import InputMonitor
from aerial_gnss_ros.preflight.pointing import ViewCenter, relative_direction, view_center
from aerial_gnss_ros.preflight.verdict import SignTest, Verdict
from aerial_gnss_ros.text.sentences import counted

_WIDTH = 100
_CLOCK_S = 3.0
_STEEP_DEG = 80.0  # above, `view_heading` is that of the image's top or bottom
_REFERENCES = ("type", "altitude_datum", "world", "body", "unit", "north", "reference", "along",
               "home_topic", "mount_rpy_deg", "stamp", "latency_s")  # fmt: skip


@dataclass(frozen=True)
class Check:
    """The data of a report.

    Attributes:
        config: the estimator's parameters.
        monitor: the inputs received.
        subscriptions: the inputs.
        problems: sentences by input about topics that cannot be received.
        now_ns: arrival time from which ages are counted, ns.
        tests: the sign tests.
        notes: other sentences.
    """

    config: EstimatorConfig
    monitor: InputMonitor
    subscriptions: Sequence[Subscription]
    problems: Mapping[str, str]
    now_ns: int
    tests: Sequence[SignTest]
    notes: Sequence[str]

    @property
    def state(self) -> FlightState | None:
        """The newest state with a pose; without one if there never was one."""
        posed = (m for m in reversed(self.monitor.states) if m.pose is not None)
        last = self.monitor.states[-1] if self.monitor.states else None
        return next(posed, last)

    @property
    def missing(self) -> list[str]:
        """Missing inputs that positions need, except detections, which come later."""
        needed = [s.name for s in self.subscriptions if s.required and s.name != "detections"]
        return [name for name in needed if name not in self.monitor.records]

    @property
    def good(self) -> bool:
        """Whether the camera's pose is known now, no input is missing and no test failed."""
        last = self.monitor.states[-1] if self.monitor.states else None
        posed = last is not None and last.pose is not None
        passed = all(test.verdict is not Verdict.FAIL for test in self.tests)
        return posed and passed and not self.missing


def one_line(monitor: InputMonitor) -> str:
    """Return the newest state in one line, for a pilot who turns the drone by hand."""
    if not monitor.states:
        return "waiting for telemetry"
    state = monitor.states[-1]
    nose = "" if state.body is None else f"nose {heading_words(_nose(state))}, "
    if state.pose is None:
        return f"{nose}camera unknown: {state.reason}"
    return nose + _sentence(state, view_center(state.pose, monitor.camera))


def as_text(check: Check) -> str:
    """Return the report for people."""
    lines = [*_place_lines(check), "", "inputs"]
    lines += [_input_line(check, subscription) for subscription in check.subscriptions]
    if check.missing:
        lines.append(
            "  ! `aerial-gnss doctor` shows which topics there are and proposes a profile."
        )
    lines += _clock_lines(check)
    state = check.state
    if state is not None and state.fix is not None:
        datums = describe_datums(state.fix, check.config.fix, check.config.height)
        lines.append(textwrap.fill(f"  {datums}", _WIDTH, subsequent_indent="  "))
    lines += ["", "sign tests"]
    for test in check.tests:
        first = f"  {test.verdict!s:<11} {test.name}: "
        text = f"{test.seen} ({test.rule})"
        lines.append(textwrap.fill(first + text, _WIDTH, subsequent_indent=" " * 14))
    for note in check.notes:
        lines += ["", textwrap.fill(note, _WIDTH)]
    return "\n".join(lines)


def as_json(check: Check) -> dict[str, Any]:
    """Return the report as JSON."""
    state = check.state
    found: dict[str, Any] = {"good": check.good, "drone": None, "camera": None}
    if state is not None and state.fix is not None:
        found["drone"] = {
            "stamp_ns": state.stamp_ns,
            "latitude_deg": math.degrees(state.fix.latitude),
            "longitude_deg": math.degrees(state.fix.longitude),
            "altitude_m": _number(state.fix.altitude),
            "height_m": state.pose.height if state.pose else state.height,
            "nose_heading_deg": None if state.body is None else math.degrees(_nose(state)),
        }
    if state is not None and state.pose is not None:
        point = view_center(state.pose, check.monitor.camera)
        found["camera"] = {
            "heading_deg": math.degrees(point.heading),
            "below_horizon_deg": math.degrees(point.below_horizon),
            "distance_m": _number(point.distance),
            "range_m": _number(point.range_m),
            "bearing_deg": _number(math.degrees(point.bearing)),
            "latitude_deg": _number(math.degrees(point.latitude)),
            "longitude_deg": _number(math.degrees(point.longitude)),
        }
    found["inputs"] = {s.name: _input_fields(check, s) for s in check.subscriptions}
    found["no_pose"] = {str(reason): n for reason, n in sorted(check.monitor.reasons.items())}
    found["tests"] = [
        {"name": t.name, "rule": t.rule, "verdict": str(t.verdict), "seen": t.seen}
        for t in check.tests
    ]
    found["notes"] = list(check.notes)
    return found


def _place_lines(check: Check) -> list[str]:
    state, monitor = check.state, check.monitor
    if state is None:
        return ["drone   unknown: no telemetry"]
    lines = []
    if state.fix is None:
        lines.append("drone   its position is unknown")
    else:
        place = _place(state.fix.latitude, state.fix.longitude)
        height = state.pose.height if state.pose is not None else state.height
        above = "" if height is None else f", {height:.1f} m above the water"
        lines.append(f"drone   {place}{above}")
    if state.body is not None:
        tilt = math.degrees(math.acos(max(-1.0, min(1.0, float(state.body[2, 2])))))
        nose = heading_words(_nose(state))
        over = ", upside down" if tilt > 90.0 else ""
        lines.append(f"nose    heading {nose}, body tilted by {tilt:.0f} deg{over}")
    if state.pose is None:
        lines.append(f"camera  unknown: {state.reason}")
    else:
        point = view_center(state.pose, monitor.camera)
        lines.append(f"camera  {_sentence(state, point)}")
        if math.isfinite(point.distance):
            where = _place(point.latitude, point.longitude)
            lines.append(
                f"        image centre on the water at {where}, {point.range_m:.1f} m away"
            )
    if monitor.reasons:
        total = len(monitor.states)
        common = monitor.reasons.most_common()
        parts = [f"{r} {n / total:.0%}" for r, n in common if n > 0.01 * total]
        if parts:
            lines.append(f"        no pose part of the time: {', '.join(parts)}")
    return lines


def _sentence(state: FlightState, point: ViewCenter) -> str:
    below = math.degrees(point.below_horizon)
    tilt = f"{abs(below):.0f} deg {'below' if below > 0.0 else 'above'} the horizon"
    tilt = "along the horizon" if abs(below) < 0.5 else tilt
    if below < -_STEEP_DEG:
        top = heading_words(point.heading + math.pi)  # `view_heading` is the bottom's
        return f"straight up, image top to {top}, {tilt}: sees no water"
    if math.isnan(point.distance):
        return f"heading {heading_words(point.heading)}, {tilt}: sees no water"
    if point.distance < 0.05 * point.range_m:
        return f"straight below, image top to {heading_words(point.heading)}, {tilt}"
    where = "out" if state.body is None else relative_direction(point.bearing, _nose(state))
    return f"{point.distance:.0f} m {where}, heading {heading_words(point.bearing)}, {tilt}"


def _input_fields(check: Check, subscription: Subscription) -> dict[str, Any]:
    record = check.monitor.records.get(subscription.name)
    found: dict[str, Any] = {
        "topic": subscription.topic,
        "type": subscription.msgtype,
        "required": subscription.required,
        "uses": references(check.config, subscription.name),
        "problem": check.problems.get(subscription.name, ""),
        "count": record.count if record else 0,
    }
    if record:
        found |= {
            "bad": record.bad,
            "trouble": record.trouble,
            "rate_hz": round(record.rate, 2),
            "age_s": round((check.now_ns - record.last_arrival_ns) * 1e-9, 3),
            "stamp_to_arrival_s": round(record.delay_s, 4),
        }
    return found


def _input_line(check: Check, subscription: Subscription) -> str:
    fields = _input_fields(check, subscription)
    uses = ", ".join(f"{name} {value}" for name, value in fields["uses"].items())
    if not fields["count"]:
        need = "MISSING" if subscription.name in check.missing else "none"
        why = fields["problem"] or f"no messages on {subscription.topic}"
        return f"  {subscription.name:<12} {need}: {why}"
    bad = f", {fields['bad']} unusable ({fields['trouble']})" if fields["bad"] else ""
    line = (
        f"  {subscription.name:<12} {fields['rate_hz']:6.1f} Hz, age {fields['age_s']:.2f} s, "
        f"{counted(fields['count'], 'message')}{bad}; {uses}"
    )
    return textwrap.fill(line.rstrip("; "), _WIDTH, subsequent_indent=" " * 15)


def references(config: EstimatorConfig, name: str) -> dict[str, Any]:
    """Return the datums, references and clock that an input uses, by parameter."""
    group = getattr(config, {"camera_info": "camera"}.get(name, name), None)
    found = {key: getattr(group, key) for key in _REFERENCES if hasattr(group, key)}
    found = {key: value for key, value in found.items() if value != ""}
    kind = getattr(group, "type", "")
    if kind != "vector3":
        found.pop("unit", None)
    if getattr(group, "reference", "") != "fixed":
        found.pop("mount_rpy_deg", None)
    if getattr(group, "source", "") == "tf":
        found = {key: found[key] for key in ("reference", "north", "stamp") if key in found}
        found |= {key: getattr(group, key) for key in ("base_frame", "camera_frame")}
    return found


def _clock_lines(check: Check) -> list[str]:
    lines = []
    for subscription in check.subscriptions:
        record = check.monitor.records.get(subscription.name)
        if record and abs(record.delay_s) > _CLOCK_S:
            late = record.delay_s
            text = (
                f"  ! {subscription.name}: its stamps are {abs(late):.1f} s "
                f"{'older' if late > 0 else 'newer'} than their arrival: another clock. Set "
                f"{subscription.name}.stamp: arrival, unless the images have that clock too."
            )
            lines.append(textwrap.fill(text, _WIDTH, subsequent_indent="    "))
    return lines


def _place(latitude: float, longitude: float) -> str:
    return f"{math.degrees(latitude):.7f}, {math.degrees(longitude):.7f}"


def _nose(state: FlightState) -> float:
    assert state.body is not None  # noqa: S101 - only called with a pose
    return float(heading_from_yaw(yaw_of(state.body)))


def heading_words(heading: float) -> str:
    """Return a compass heading (rad) as `0 deg` to `359 deg`."""
    return f"{round(math.degrees(heading)) % 360} deg"


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
