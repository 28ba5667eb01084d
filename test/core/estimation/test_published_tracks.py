# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Another latency's tracks are published from the image after it is found right, and not before."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation import published_tracks
from aerial_gnss_ros.core.estimation.published_tracks import PublishedTracks
from aerial_gnss_ros.core.estimation.recent_images import SeenImage
from aerial_gnss_ros.core.identity.labels import Labels
from aerial_gnss_ros.core.telemetry.buffers import TelemetryBuffers
from aerial_gnss_ros.core.telemetry.map_origin import MapOrigin
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry
from aerial_gnss_ros.core.tracker.box_account import Settled
from aerial_gnss_ros.core.values.detection_frame import empty_detections
from aerial_gnss_ros.core.values.events import Events
from aerial_gnss_ros.core.values.rejection import Input, Reason, Rejection

LATE_NS = 300
BOX = (2, 3.0, 4.0)
PENDING = Settled(4, (Rejection(2, Reason.UNCONFIRMED, 3.0, 4.0),))
MISSING = MissingTelemetry(Reason.no(Input.FIX), True)


class Doubt:
    """Stands in for the weighing of latencies: says what a test lets it say."""

    def __init__(self, *_):
        self.active, self.due_ns = True, 2**63
        self.odds = SimpleNamespace(stamped_seldom=False)
        self.found, self.done = None, []

    def note(self, *_):
        """Take in a camera."""

    def mixed(self, result, _local):
        """Return what is published."""
        return replace(result, frame_id=f"mixed {result.frame_id}")

    def try_another(self, image, *_):
        """Return a trial that was found right."""
        self.done.append(image.frame.stamp_ns)
        if isinstance(self.found, Exception):
            raise self.found
        return self.found

    def close(self):
        """End."""
        self.done.append("closed")

    def reset(self):
        """Begin anew."""
        self.done.append("reset")

    def forget_images(self):
        """Forget images."""
        self.done.append("forgot")


class Part:
    """Something with attributes, whose state can be restored."""

    def __init__(self, **attributes):
        vars(self).update(attributes)


class Line:
    """Stands in for the pipeline of another latency: notes what it takes in."""

    def __init__(self, result_at):
        self.taken, self.constant, self.measured, self.corrects = [], (), None, {}
        self.latency = Part(scene_ns=LATE_NS)
        self.tracking = Part(check=lambda: None, keep_pending=self.taken.append)
        self.result_at = result_at

    def result(self, frame, samples):
        """Take in an image."""
        self.taken.append((frame.stamp_ns, samples))
        return replace(self.result_at(frame.stamp_ns, boxes=0), frame_id="other")


class Setting:
    """Tracks with what they act on, and a trial that may be found right."""

    def __init__(self, sea, result_at, monkeypatch, values=None):
        monkeypatch.setattr(published_tracks, "LatencyDoubt", Doubt)
        config = estimator_config({**sea.origin, **(values or {})})
        self.log, self.inputs = Events(), TelemetryBuffers(config)
        origin = MapOrigin(config, None, self.log)
        labels = Labels(config, log=self.log)
        self.tracks = PublishedTracks(config, self.inputs, origin, labels, self.log)
        self.doubt = self.tracks._doubt
        self.adopted = []
        self.trial = SimpleNamespace(
            adopt_labels=lambda: self.adopted.append(True),
            settled=lambda _ended: PENDING,
            log=Events(),
            identity=Labels(config),
            pipeline=Line(result_at),
            waiting=[SeenImage(empty_detections(2), None)],
            pending={BOX},
        )
        self.log.drain()


@pytest.fixture
def setting(sea, result_at, monkeypatch):
    return Setting(sea, result_at, monkeypatch)


def test_the_scene_is_before_the_image_by_the_latency(setting, monkeypatch):
    monkeypatch.setattr(setting.inputs, "at", lambda stamp_ns: stamp_ns)
    setting.tracks.pipeline.latency.scene_ns = 300
    assert setting.tracks.telemetry(empty_detections(1000)) == 700
    monkeypatch.setattr(setting.inputs, "at", lambda _ns: 1 // 0)
    assert isinstance(setting.tracks.telemetry(empty_detections(1000)), ZeroDivisionError)


def test_a_mixture_is_published_while_it_is_undecided(setting):
    own = setting.tracks.pipeline
    result = setting.tracks.result(empty_detections(1), MISSING)
    assert result.frame_id.startswith("mixed")
    assert setting.tracks.predicted(5).frame_id.startswith("mixed")
    assert setting.tracks.weigh_latency(empty_detections(1)) == Settled()
    assert setting.tracks.pipeline is own
    assert setting.doubt.done == [1]
    assert setting.log.counts["latency_doubted"] == 0


def test_a_trial_that_was_found_right_is_published_from_the_next_image_on(setting):
    tracks, trial = setting.tracks, setting.trial

    def wrap(tracking):
        tracking.wrapped = True
        return tracking

    tracks.wrap_tracking(wrap)
    tracks.result(empty_detections(3), MISSING)
    setting.doubt.found = trial
    assert tracks.weigh_latency(empty_detections(3)) == PENDING
    assert setting.adopted == [True]
    assert tracks.pipeline is trial.pipeline
    assert tracks.pipeline.tracking.wrapped
    assert tracks.labels is trial.identity
    assert trial.log.counts is setting.log.counts  # what it says is heard from now on
    # First the image that it had not taken in, then the boxes that nobody has decided on.
    assert tracks.result(empty_detections(4), MISSING).frame_id == "mixed other"
    (early, samples), kept, (now, given) = trial.pipeline.taken
    assert (early, now, kept) == (2, 4, {BOX})
    assert isinstance(samples, MissingTelemetry)
    assert given is MISSING
    tracks.result(empty_detections(5), MISSING)
    assert [one[0] for one in trial.pipeline.taken[3:]] == [5]


@pytest.mark.parametrize(
    ("seldom", "begins"),
    [(False, "Boxes do not fit camera.latency_s: "), (True, "Telemetry has the stamps of images")],
)
def test_it_is_said_once_why_the_latency_is_estimated(setting, seldom, begins):
    setting.doubt.found, setting.doubt.odds.stamped_seldom = setting.trial, seldom
    setting.trial.pipeline.end = Settled
    for stamp_ns in (3, 4):
        setting.tracks.weigh_latency(empty_detections(stamp_ns))
    (sentence,) = setting.log.drain()
    assert sentence.startswith(begins)
    assert setting.log.counts["latency_doubted"] == 1


def test_a_trial_that_fails_ends_the_doubt_and_nothing_else(setting):
    own = setting.tracks.pipeline
    setting.doubt.found = ValueError("put in by a test")
    assert setting.tracks.weigh_latency(empty_detections(1)) == Settled()
    assert setting.doubt.done == [1, "closed"]
    assert setting.tracks.pipeline is own


def test_nothing_is_weighed_once_it_is_decided(setting):
    setting.doubt.active, setting.doubt.found = False, setting.trial
    assert setting.tracks.weigh_latency(empty_detections(1)) == Settled()
    assert setting.doubt.done == []


def test_a_reset_leaves_no_image_to_take_in(setting):
    setting.doubt.found = setting.trial
    setting.tracks.weigh_latency(empty_detections(3))
    setting.trial.pipeline.reset = lambda: setting.doubt.done.append("pipeline")
    setting.tracks.reset()
    assert setting.doubt.done == [3, "reset", "pipeline"]
    setting.tracks.result(empty_detections(4), MISSING)
    assert [one[0] for one in setting.trial.pipeline.taken] == [4]


@pytest.mark.parametrize("values", [{"camera.find_latency": False}, {"noise.latency_s": 0.3}])
def test_a_latency_that_is_not_looked_for_or_estimated_anyway_is_not_doubted(
    sea, result_at, monkeypatch, values
):
    setting = Setting(sea, result_at, monkeypatch, values)
    assert setting.doubt is None
    setting.tracks.forget_images()
    setting.tracks.reset()
    result = setting.tracks.result(empty_detections(1), MISSING)
    assert not result.frame_id.startswith("mixed")
    assert setting.tracks.weigh_latency(empty_detections(1)) == Settled()
