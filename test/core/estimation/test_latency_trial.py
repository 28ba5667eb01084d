# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a trial of another latency does to what is published meanwhile, and to pending boxes."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation import latency_trial
from aerial_gnss_ros.core.estimation.latency_trial import LatencyTrial, learn
from aerial_gnss_ros.core.estimation.recent_images import SeenImage
from aerial_gnss_ros.core.filter.latency_search import LatencySearch
from aerial_gnss_ros.core.geometry.geodesy import LocalMap
from aerial_gnss_ros.core.identity.labels import Labels
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.map_origin import MapOrigin
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry
from aerial_gnss_ros.core.tracker.box_account import Settled
from aerial_gnss_ros.core.values.estimates import FrameResult, MapDatum, RobotEstimate, State
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Input, Reason, Rejection

SECOND = 1_000_000_000


def estimate(stamp_ns, east, covariance, name="aqua_1"):
    place = np.array([east, 5.0])
    return RobotEstimate(
        stamp_ns, name, "aqua", State.CONFIRMED, 0.2, -1.0, 0.0, place, np.zeros(2),
        covariance * np.eye(4), stamp_ns,
    )  # fmt: skip


def result(stamp_ns, *estimates, refused=()):
    return FrameResult(stamp_ns, "camera", estimates, refused, None)


def seen(frame, measured):
    return SeenImage(frame, measured)


def trial_of(sea, images=()):
    """Return a trial whose images give what its list of results says."""
    config = estimator_config({**sea.origin, "noise.latency_s": 1.0})
    inputs = TelemetryBuffers(config)
    found = LatencyTrial(
        config,
        inputs,
        MapOrigin(config, None, Events()),
        Labels(config),
        LatencySearch(config, inputs),
        images,
    )
    found.gives = []
    found._inputs = SimpleNamespace(at=lambda _ns: None)
    found.pipeline = SimpleNamespace(
        result=lambda _frame, _samples: found.gives.pop(0),
        latency=SimpleNamespace(scene_ns=0),
        tracking=SimpleNamespace(check=lambda: None),
        measured=None,
    )
    return found


@pytest.fixture
def trial(sea):
    return trial_of(sea)


LOCAL = LocalMap(MapDatum(0.2, -1.0, 0.0))


def shown(sea, trial, late, waits=False):
    """Return what is published of a robot at 10 m, 1 m², with 0.25 for the trial's estimate."""
    now = sea.stamp(1.0)
    trial.gives = [result(late.stamp_ns, late)]
    trial.add(seen(sea.boxes(1.0, [[640.0, 360.0]]), {"aqua_1": 0}))
    trial.behind = waits
    one = estimate(now, 10.0, 1.0)
    found = [one, estimate(now, 30.0, 1.0, "aqua_2")]
    alone = [replace(each, covariance=5.0 * each.covariance) for each in found]
    return trial.mixed(found, alone, 0.25, LOCAL)


def test_moments_of_the_mixture_are_published(sea, trial):
    one, other = shown(sea, trial, estimate(sea.stamp(1.0), 14.0, 3.0))
    assert one.position.tolist() == [11.0, 5.0]
    assert one.covariance[0, 0] == pytest.approx(0.75 * 1.0 + 0.25 * 3.0 + 0.75 * 0.25 * 4.0**2)
    assert one.covariance[1, 1] == pytest.approx(0.75 * 1.0 + 0.25 * 3.0)
    place = LOCAL.places(one.position[None])
    assert (one.latitude, one.longitude) == (place[0][0], place[1][0])
    np.testing.assert_array_equal(other.covariance, 5.0 * np.eye(4))  # unknown to the trial
    assert other.position[0] == 30.0


def test_a_trial_with_images_of_seconds_ago_says_nothing_of_now(sea, trial):
    one, _ = shown(sea, trial, estimate(sea.stamp(-14.0), 14.0, 3.0), waits=True)
    assert one.position.tolist() == [10.0, 5.0]
    np.testing.assert_array_equal(one.covariance, 5.0 * np.eye(4))


def test_a_trial_of_earlier_images_goes_on_as_it_is(sea, trial):
    """Two seconds at 2 m/s; the velocity's variance of 3 makes 4 times 3 more."""
    late = replace(estimate(sea.stamp(-1.0), 10.0, 3.0), velocity=np.array([2.0, 0.0]))
    one, _ = shown(sea, trial, late)
    assert one.position[0] == pytest.approx(10.0 + 0.25 * 4.0)
    assert one.velocity[0] == pytest.approx(0.25 * 2.0)
    spread = 0.75 * 1.0 + 0.25 * (3.0 + 4.0 * 3.0) + 0.75 * 0.25 * 4.0**2
    assert one.covariance[0, 0] == pytest.approx(spread)
    assert one.covariance[0, 2] == pytest.approx(0.25 * 2.0 * 3.0 + 0.75 * 0.25 * 4.0 * 2.0)


def test_a_pending_box_is_refused_if_the_trial_refuses_it_too(sea, trial):
    now = sea.stamp(1.0)
    trial.pipeline.tracking.keep_pending = lambda boxes: boxes & {(now, 3.0, 5.0), (now, 4.0, 5.0)}
    boxes = [Rejection(now, Reason.UNCONFIRMED, u, 5.0) for u in (1.0, 2.0, 3.0)]
    trial.gives = [result(now, refused=(Rejection(now, Reason.GATED, 2.0, 5.0),))]
    trial.add(seen(sea.boxes(1.0, []), {}))
    assert trial.settled(Settled(4, tuple(boxes))) == Settled(5, (boxes[1],))
    assert trial.pending == {(now, 3.0, 5.0)}


def test_robots_are_called_as_their_boxes_were_published(sea, trial):
    """The trial labelled them first, when none was published; then images show who is who."""
    trial.identity._names.numbers["aqua"] = 4
    renamed, followed = [], []
    trial._tracker = SimpleNamespace(
        classes={"aqua_3": "aqua", "aqua_4": "aqua"},
        rename=renamed.append,
        follow_references=followed.append,
    )
    for t in (1.0, 2.0):
        frame = sea.boxes(t, [[100.0, 360.0], [900.0, 360.0], [500.0, 360.0]])
        scene = SimpleNamespace(detections=frame)
        trial.pipeline.measured = scene, {"aqua_3": 1, "aqua_4": 0}
        trial.gives = [result(frame.stamp_ns)]
        published = {"aqua_1": 0, "aqua_2": 1, "aqua_4": 2}  # the last one has no track here
        trial.add(SeenImage(frame, published, {"mark": "aqua_1"} if t > 1.0 else {}))
    assert followed == [{}, {"mark": "aqua_1"}]
    trial.adopt_labels()
    assert followed[2:] == [{}]  # published itself, it follows nobody
    assert renamed == [{"aqua_3": "aqua_2", "aqua_4": "aqua_1"}]


def test_the_better_known_latency_is_gone_on_with(trial):
    own = trial.pipeline.latency
    own.found = (1.0, 0.1)
    learn(trial.pipeline, SimpleNamespace(found=(1.1, 0.2)))
    assert trial.pipeline.latency is own
    better = SimpleNamespace(found=(1.1, 0.05))
    learn(trial.pipeline, better)
    assert trial.pipeline.latency is better


def test_images_so_far_are_taken_in_some_with_each_new_one(sea, monkeypatch):
    tuning = replace(latency_trial.TUNING, catch_up_hz=15.0)
    monkeypatch.setattr(latency_trial, "TUNING", tuning)
    old = [seen(sea.boxes(0.2 * k, []), None) for k in range(8)]
    trial, taken = trial_of(sea, old), []
    trial.pipeline.result = lambda frame, _samples: (
        taken.append(frame.stamp_ns) or result(frame.stamp_ns)
    )
    assert trial.behind
    counts = []
    for t in (1.5, 1.6, 1.7, 1.8, 1.9):
        trial.add(seen(sea.boxes(t, []), None))
        counts.append((len(taken), trial.behind))
    # Two for each 0.1 s of flight, and one for each new image.
    assert counts == [(3, True), (6, True), (9, True), (12, False), (13, False)]
    assert taken == sorted(taken)


def test_all_images_with_telemetry_are_taken_in_at_once(sea):
    trial, taken = trial_of(sea, [seen(sea.boxes(0.2 * k, []), None) for k in range(80)]), []
    trial.pipeline.result = lambda frame, _samples: (
        taken.append(frame.stamp_ns) or result(frame.stamp_ns)
    )
    missing = MissingTelemetry(Reason.no(Input.FIX), True)
    trial._inputs = SimpleNamespace(at=lambda ns: missing if ns > sea.stamp(15.5) else None)
    trial.take_all()
    assert taken == [sea.stamp(0.2 * k) for k in range(78)]
    assert not trial.behind
    assert [one.frame.stamp_ns for one in trial.waiting] == [sea.stamp(15.6), sea.stamp(15.8)]


def test_images_without_telemetry_so_far_are_not_waited_for(sea):
    old = [seen(sea.boxes(0.2 * k, []), None) for k in range(3)]
    trial = trial_of(sea, old)
    trial.gives = [result(sea.stamp(0.0))]
    missing = MissingTelemetry(Reason.no(Input.FIX), True)
    trial._inputs = SimpleNamespace(at=lambda ns: missing if ns > sea.stamp(0.1) else None)
    trial.add(seen(sea.boxes(0.6, []), None))
    assert len(trial.waiting) == 3
    assert not trial.behind
