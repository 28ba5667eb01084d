# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whatever an image does to the core: nothing is raised, and nothing but a count remains of it."""

from __future__ import annotations

import dataclasses
import inspect
import math
import sys
from collections import deque
from enum import Enum

import numpy as np
import pytest

from aerial_gnss_ros.core.estimation import guard
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Reason
from aerial_gnss_ros.core.values.samples import Scalar

pytestmark = pytest.mark.flights

TOLD_S = 40.0
"""Until when `ready` adds telemetry."""
STATEFUL = ("pipeline", "labels")
ROBOTS = {
    "a": lambda t: (-3.0 + 3.0 * math.sin(t / 5.0), 20.0),
    "b": lambda t: (3.0 - 3.0 * math.sin(t / 5.0), 19.5),
    "c": lambda t: (1.0, 15.0 + 0.2 * math.sin(t)),
}


class PutInError(Exception):
    """Raised somewhere within an image's work."""


def state(value, seen=None):  # noqa: PLR0911
    """Everything that can be reached from a value, in a form that can be compared."""
    seen = {} if seen is None else seen
    if isinstance(value, (str, bytes, int, float, Enum, type(None), np.generic, np.ndarray)):
        return value.tobytes() if isinstance(value, np.ndarray) else repr(value)
    if isinstance(
        value, (TelemetryBuffers, Events)
    ):  # images do not change the one; the other shows it
        return ""
    if id(value) in seen:
        return seen[id(value)]
    seen[id(value)] = f"number {len(seen)}"
    if isinstance(value, dict):
        return {repr(key): state(one, seen) for key, one in value.items()}
    if isinstance(value, (list, tuple, deque)):
        return [state(one, seen) for one in value]
    if isinstance(value, (set, frozenset)):
        return sorted(map(repr, value))
    if dataclasses.is_dataclass(value) and value.__dataclass_params__.frozen:
        return {f.name: state(getattr(value, f.name), seen) for f in dataclasses.fields(value)
                if f.name != "_poses"}  # fmt: skip
    if hasattr(value, "__dict__"):
        return {name: state(one, seen) for name, one in vars(value).items()}
    return repr(type(value))


def whole(engine):
    return [state(getattr(engine._tracks, name)) for name in STATEFUL]


def different(one, other, path=""):
    """Return where two states differ."""
    if isinstance(one, dict) and isinstance(other, dict) and one.keys() == other.keys():
        return [p for key in one for p in different(one[key], other[key], f"{path}.{key}")]
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        pairs = enumerate(zip(one, other, strict=True))
        return [p for i, both in pairs for p in different(*both, f"{path}[{i}]")]
    return [] if one == other else [path]


def fed(engine, world, t):
    """Add the image at t; `advance` works on it."""
    frame = world.frame(t)
    engine.add_detections(frame)
    return frame


def telemetry(engine, world, begin, end):
    """Add what the sensors say in a time."""
    for i in range(round(20.0 * begin), round(20.0 * end)):
        t = 0.05 * i
        engine.add_fix(world.fix(t))
        engine.add_gimbal(world.gimbal(t))
        engine.add_height(world.height(t))


def ready(sea, values=None, seconds=3.0):
    """Return an estimator that has confirmed three robots, and the telemetry of what follows."""
    world = sea.World(
        robots=ROBOTS,
        drone=lambda t: (3.0 * math.sin(t / 3.0), -2.0 * math.cos(t / 2.0), 30.0),
        pixel_sigma=1.0,
        clutter=0.3,
    )
    engine = sea.estimator(values)
    telemetry(engine, world, 0.0, TOLD_S)
    engine.add_camera(sea.stamp(0.0), sea.camera)
    for i in range(round(10.0 * seconds) + 1):
        fed(engine, world, 0.1 * i)
        (result,) = engine.advance(sea.stamp(0.1 * i))
    assert len(result.estimates) == 3
    return engine, world, result


def images(sea, engine, world, count):
    """Work on so many images after those of `ready`; return their results."""
    results = []
    for i in range(count):
        fed(engine, world, 3.1 + 0.1 * i)
        results += engine.advance(sea.stamp(3.1 + 0.1 * i))
    return results


class Calls:
    """Counts the calls of functions within a block, Python's and C's; fails at one of them.

    Generators do not count: what fails where one is closed by its destructor is seen by nobody.
    """

    def __init__(self, fail_at=None):
        self.count, self.fail_at = 0, fail_at

    def __enter__(self):
        sys.setprofile(self._count)
        return self

    def __exit__(self, *_):
        sys.setprofile(None)

    def _count(self, frame, event, _value):
        generator = event == "call" and frame.f_code.co_flags & inspect.CO_GENERATOR
        if event in ("call", "c_call") and not generator:
            self.count += 1
            if self.count == self.fail_at:
                raise PutInError("put in by a test")


@pytest.mark.parametrize(
    "values",
    [{}, {"noise.latency_s": 0.3}, {"method": "paper"}],
    ids=["filter", "latency", "paper"],
)
def test_an_image_that_fails_anywhere_leaves_no_trace(sea, monkeypatch, values):
    """At each place in turn, as far as an image has such: the next one is as if it never came."""
    engine, world, _ = ready(sea, values)
    work = engine._tracks.pipeline.result
    fail_at = 0

    def failing(frame, samples):
        if frame.stamp_ns not in chosen:
            return work(frame, samples)
        before.append(whole(engine))
        with Calls(fail_at) as calls:
            result = work(frame, samples)
        ended.append(calls.count)
        return result

    monkeypatch.setattr(engine._tracks.pipeline, "result", failing)
    chosen, ended, failed, t, told = set(), [], 0, 3.0, TOLD_S
    while not ended:
        t += 0.1
        if t > told - 5.0:
            telemetry(engine, world, told, told + 5.0)
            told += 5.0
        fail_at += 1 + fail_at // 16
        chosen, before = {sea.stamp(t)}, []
        names = [robot.robot_id for robot in engine.robots]
        frame = fed(engine, world, t)
        (result,) = engine.advance(sea.stamp(t))
        if ended:
            break
        failed += 1
        assert {one.reason for one in result.rejections} <= {Reason.INTERNAL}
        assert len(result.rejections) == len(frame)
        assert different(before[0], whole(engine)) == []
        assert [one.robot_id for one in result.estimates] == names
        for i in range(1, 4):  # and it goes on: five in a row would restart it
            fed(engine, world, t + 0.1 * i)
            (result,) = engine.advance(sea.stamp(t + 0.1 * i))
            assert Reason.INTERNAL not in [one.reason for one in result.rejections]
        t += 0.3
    assert failed > 30
    assert engine.happened["images_failed"] == failed
    assert engine.happened["filter_restarts"] == 0


def test_a_failed_image_is_reported_once_with_what_a_developer_needs(sea, monkeypatch):
    engine, world, _ = ready(sea)
    engine.take_events()

    def failing(_frame, _samples):
        raise ZeroDivisionError("by nothing")

    monkeypatch.setattr(engine._tracks.pipeline, "result", failing)
    images(sea, engine, world, 4)
    (sentence,) = engine.take_events()
    for part in (
        str(sea.stamp(3.1)), "ZeroDivisionError", "by nothing", "test_guard.py:", "3 boxes",
        "3 robots",
    ):  # fmt: skip
        assert part in sentence.replace("4 boxes", "3 boxes")
    assert engine.happened["images_failed"] == 4
    assert engine.counts[Reason.INTERNAL] >= 12


def test_several_failed_images_restart_the_filter_and_names_are_kept(sea, monkeypatch):
    engine, world, result = ready(sea)
    where = {one.robot_id: one.position for one in result.estimates}
    work, failed = engine._tracks.pipeline.result, []

    def failing(frame, samples):
        if frame.stamp_ns >= sea.stamp(3.55):
            return work(frame, samples)
        failed.append(frame.stamp_ns)
        raise ValueError("five in a row")

    monkeypatch.setattr(engine._tracks.pipeline, "result", failing)
    after = images(sea, engine, world, 30)
    assert len(failed) == guard.RESTART_AFTER
    assert engine.happened["filter_restarts"] == 1
    assert engine.happened["images_failed"] == guard.RESTART_AFTER
    assert [len(one.estimates) for one in after[:6]] == [3, 3, 3, 3, 0, 0]
    found = {one.robot_id: one.position for one in after[-1].estimates}
    assert found.keys() == where.keys()
    assert all(np.linalg.norm(found[name] - where[name]) < 2.0 for name in where)
    assert all(one.state is State.CONFIRMED for one in after[-1].estimates)


def test_fewer_failed_images_than_in_a_row_restart_nothing(sea, monkeypatch):
    engine, world, _ = ready(sea)
    work = engine._tracks.pipeline.result

    def failing(frame, samples):
        if (frame.stamp_ns - sea.stamp(3.1)) // 100_000_000 % guard.RESTART_AFTER:
            raise ValueError("all but each fifth")
        return work(frame, samples)

    monkeypatch.setattr(engine._tracks.pipeline, "result", failing)
    images(sea, engine, world, 20)
    assert engine.happened["images_failed"] == 16
    assert engine.happened["filter_restarts"] == 0


def test_a_state_that_cannot_be_fails_the_image_that_made_it(sea, monkeypatch):
    engine, world, _ = ready(sea)
    before = whole(engine)
    work = engine._tracks.pipeline.result

    def spoiling(frame, samples):
        result = work(frame, samples)
        engine._tracks.pipeline.tracking.table.filter._groups[0].covariance[8, 8] = math.nan
        return result

    monkeypatch.setattr(engine._tracks.pipeline, "result", spoiling)
    before[0]["result"] = whole(engine)[0]["result"]
    fed(engine, world, 3.1)
    (result,) = engine.advance(sea.stamp(3.2))
    assert {one.reason for one in result.rejections} == {Reason.INTERNAL}
    assert different(before, whole(engine)) == []
    assert all(np.isfinite(one.covariance).all() for one in result.estimates)


def test_what_ends_the_program_ends_it(sea, monkeypatch):
    engine, world, _ = ready(sea)
    for at_s, kind in ((3.1, MemoryError), (3.2, KeyboardInterrupt), (3.3, SystemExit)):

        def failing(_frame, _samples, kind=kind):
            raise kind

        monkeypatch.setattr(engine._tracks.pipeline, "result", failing)
        fed(engine, world, at_s)
        with pytest.raises(kind):
            engine.advance(sea.stamp(at_s + 0.1))


def test_telemetry_that_cannot_be_interpolated_refuses_the_image(sea, monkeypatch):
    engine, world, _ = ready(sea)

    def failing(_stamp_ns):
        raise FloatingPointError("of no use")

    monkeypatch.setattr(engine._inputs, "at", failing)
    frame = fed(engine, world, 3.1)
    (result,) = engine.advance(sea.stamp(3.2))
    assert [one.reason for one in result.rejections] == [Reason.INTERNAL] * len(frame)


def test_a_message_that_cannot_be_kept_is_counted(sea, monkeypatch):
    engine = sea.estimator()

    def failing(_source, _value):
        raise OverflowError("too large")

    monkeypatch.setattr(engine._inputs, "add", failing)
    engine.add_height(Scalar(sea.stamp(0.0), 30.0))
    engine.add_fix(sea.World().fix(0.0))
    for name in ("fix", "height"):
        status = engine.inputs[name]
        assert (status.count, status.bad) == (1, 1)
        assert "OverflowError: too large" in status.trouble
    assert engine._origin.local is not None  # as configured


def test_a_state_file_that_fails_in_any_way_is_reported_and_ends_nothing(
    sea, monkeypatch, tmp_path
):
    engine, world, _ = ready(sea, {"state_file": str(tmp_path / "names.json")})

    def failing(*_):
        raise UnicodeEncodeError("utf-8", "\ud800", 0, 1, "surrogates not allowed")

    monkeypatch.setattr(engine._frames._names, "keep", failing)
    engine.take_events()
    results = images(sea, engine, world, 3)
    assert all(len(one.estimates) == 3 for one in results)
    (reported,) = engine.take_events()
    assert "state_file cannot be written (UnicodeEncodeError" in reported
