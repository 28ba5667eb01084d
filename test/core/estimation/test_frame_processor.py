# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images become results in order, over tracks that only note what they are asked."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import pytest

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.found_again import TRIAL_IMAGES
from aerial_gnss_ros.core.estimation.frame_processor import FrameProcessor
from aerial_gnss_ros.core.estimation.time_base import TimeBase
from aerial_gnss_ros.core.telemetry.scene import MissingTelemetry
from aerial_gnss_ros.core.telemetry.stamp_decision import Decision
from aerial_gnss_ros.core.tracker.box_account import Settled
from aerial_gnss_ros.core.values.detection_frame import empty_detections
from aerial_gnss_ros.core.values.events import Events, WarningText
from aerial_gnss_ros.core.values.rejection import Input, Reason, Rejection

SECOND = 1_000_000_000


class Tracks:
    """Stands in for the tracks: robots `a` and `b` are in each image."""

    def __init__(self, result_at):
        self.result_at, self.names, self.done = result_at, ["a", "b"], []
        self.missing, self.decided, self.labels = None, Settled(), "labels"
        self.pipeline = SimpleNamespace(
            latency=SimpleNamespace(scene_ns=0, searches=False),
            end=lambda: Settled(2, (Rejection(1, Reason.UNCONFIRMED, 3.0, 4.0),)),
            reset=lambda: self.done.append("pipeline"),
        )

    def telemetry(self, _frame):
        """Return what is there of it."""
        return self.missing

    def result(self, frame, _samples):
        """Take in an image."""
        self.done.append(frame.stamp_ns)
        return self.result_at(frame.stamp_ns, self.names, boxes=3)

    def predicted(self, stamp_ns):
        """Predict."""
        return self.result_at(stamp_ns, self.names)

    def weigh_latency(self, _frame):
        """Return what was decided of boxes."""
        return self.decided

    def forget_images(self):
        """Forget images."""
        self.done.append("forget")

    def reset(self):
        """End."""
        self.done.append("reset")


class Setting:
    """A processor with what it acts on."""

    def __init__(self, result_at, values=None):
        self.tracks, self.time, self.log = Tracks(result_at), TimeBase(), Events()
        self.dropped, self.done = Counter(), self.tracks.done
        self.kept, self.fix_trouble = [], ""
        self.inputs = SimpleNamespace(
            fix_later_ns=0,
            newest_ns=dict,
            plausibility=SimpleNamespace(agreed_s=7.0),
            forget=lambda names: self.done.append(("forget", *names)),
            clear=lambda kept=(): self.done.append(("clear", *kept)),
        )
        self.origin = SimpleNamespace(local="here", settle=lambda: None, accept=self._accept)
        self.names = SimpleNamespace(
            keep=lambda result, *_: self.kept.append(result.stamp_ns),
            save=lambda labels, shift_ns: self.kept.append((labels, shift_ns)),
            reset=lambda: self.kept.append("reset"),
        )
        self.frames = FrameProcessor(
            estimator_config(values or {}),
            self.inputs,
            self.origin,
            self.tracks,
            self.time,
            self.names,
            SimpleNamespace(keep=lambda _datum: None),
            self.dropped,
            self.log,
        )

    def _accept(self, fix, lasted_s, robots):
        self.done.append((fix, lasted_s, robots))
        return self.fix_trouble

    def see(self, *seconds):
        """Take in images at some times, and return the results that are due."""
        for t in seconds:
            self.frames.receive_image(empty_detections(round(t * SECOND)))
        return self.frames.advance(round(seconds[-1] * SECOND))


@pytest.fixture
def setting(result_at):
    return Setting(result_at)


def stamps(results):
    return [one.stamp_ns / SECOND for one in results]


def test_results_come_in_the_order_of_stamps(setting):
    assert stamps(setting.see(2.0, 1.0, 3.0)) == [1.0, 2.0, 3.0]
    assert setting.see(2.5) == []
    assert setting.dropped == {"out_of_order": 1}
    assert setting.frames.results.boxes == 9


@pytest.mark.parametrize(
    ("values", "scene_s", "later_s", "patience_s"),
    [
        ({"max_wait": 2.0}, 0.0, 0.0, 2.0),
        ({"max_wait": 2.0}, 1.5, 0.0, 2.0),
        ({"max_wait": 2.0}, -1.5, 0.0, 3.5),
        ({"max_wait": 2.0}, -1.5, 0.25, 3.75),
        ({"max_wait": 2.0}, -1.5, -0.25, 3.5),
        ({"max_wait": 2.0}, 0.0, 0.25, 2.25),
        ({"max_wait": 2.0, "fix.latency_s": 0.5, "height.latency_s": 0.25}, -1.5, 0.0, 4.0),
    ],
)
def test_an_image_waits_for_telemetry_that_may_come(
    result_at, values, scene_s, later_s, patience_s
):
    """Until the newest fix for its scene, where those are found to be late."""
    setting = Setting(result_at, values)
    setting.inputs.fix_later_ns = round(later_s * SECOND)
    setting.tracks.pipeline.latency.scene_ns = round(scene_s * SECOND)
    assert setting.frames.patience_ns == round(patience_s * SECOND)
    setting.tracks.missing = MissingTelemetry(Reason.no(Input.FIX), True)
    assert setting.see(10.0) == []
    assert setting.frames.advance(round((9.9 + patience_s) * SECOND)) == []
    assert stamps(setting.frames.advance(round((10.0 + patience_s) * SECOND))) == [10.0]


def test_an_image_does_not_wait_for_what_cannot_come_or_cannot_be_used(setting):
    setting.tracks.missing = MissingTelemetry(Reason.no(Input.FIX), False)
    assert stamps(setting.see(1.0)) == [1.0]
    setting.tracks.missing = ZeroDivisionError()
    assert stamps(setting.see(2.0)) == [2.0]


def test_an_image_whose_work_ends_the_program_stays_in_the_queue(setting, monkeypatch):
    def ends(*_):
        raise MemoryError

    with monkeypatch.context() as patch:
        patch.setattr(setting.tracks, "result", ends)
        with pytest.raises(MemoryError):
            setting.see(1.0)
    assert stamps(setting.frames.advance(SECOND)) == [1.0]


def test_the_end_gives_all_that_wait_and_decides_all_boxes(setting):
    setting.tracks.missing = MissingTelemetry(Reason.no(Input.FIX), True)
    assert setting.see(1.0, 2.0) == []
    assert stamps(setting.frames.flush()) == [1.0, 2.0]
    assert setting.kept[-1] == ("labels", 0)
    assert setting.frames.results.used == 2
    assert [one.u_px for one in setting.frames.results.ending] == [3.0]


def test_what_another_latency_decides_belongs_to_the_image_that_decided(setting):
    setting.tracks.decided = Settled(4, (Rejection(1, Reason.UNCONFIRMED, 3.0, 4.0),))
    (result,) = setting.see(1.0)
    assert (result.used, len(result.late)) == (4, 1)
    assert setting.frames.results.counts == {Reason.UNCONFIRMED: 1}


def test_a_prediction_is_after_the_last_image(setting):
    assert setting.frames.predicted(SECOND) is None
    setting.see(1.0)
    assert setting.frames.predicted(SECOND) is None
    assert setting.frames.predicted(2 * SECOND).stamp_ns == 2 * SECOND


def test_another_map_ends_tracks_and_the_same_one_does_not(setting):
    setting.see(1.0)
    setting.done.clear()
    setting.fix_trouble = "it is too far away"
    assert setting.frames.receive_fix("one") == "it is too far away"
    assert setting.done == [("one", 7.0, True)]

    def moves(*_):
        setting.origin.local = "there"
        return ""

    setting.origin.accept = moves
    setting.done.clear()
    assert setting.frames.receive_fix("two") == ""
    assert setting.done == ["pipeline", "forget"]


def test_a_drone_that_is_elsewhere_has_new_robots(setting):
    setting.frames.begin_elsewhere("The height is 500 m")
    setting.see(1.0)
    setting.frames.begin_elsewhere("The height is 500 m")
    assert setting.log.drain() == [
        "The height is 500 m.",
        "The height is 500 m: tracks are cleared, and robots get new labels.",
    ]
    assert setting.frames.results.robots == ()
    assert setting.done == ["reset", SECOND, "reset"]
    assert setting.log.counts["began_elsewhere"] == 2


def test_a_clock_of_one_input_that_was_set_ends_nothing(setting):
    setting.see(1.0)
    setting.done.clear()
    setting.frames.reset_time(Decision(False, ("fix",)), None)
    assert setting.done == [("forget", "fix")]
    assert setting.log.drain() == ["The clock of fix was set; its earlier telemetry is discarded."]


HOUR = Decision(True, ("fix",), ("gimbal",), 3600 * SECOND, 3602 * SECOND, timed=True)


def test_a_step_of_known_size_keeps_robots_and_their_times(setting):
    setting.tracks.missing = MissingTelemetry(Reason.no(Input.FIX), True)
    assert setting.see(1.0) == []
    setting.frames.reset_time(HOUR, None)  # what waits is of the time before
    assert setting.done == [SECOND, ("clear",), "forget"]
    assert setting.time.shift_ns == -3600 * SECOND
    (sentence,) = setting.log.drain()
    assert sentence.startswith("Time went forward by 3600.0 s (fix): telemetry is cleared; robots")
    assert setting.log.counts["time_went_forward"] == 1
    setting.tracks.missing = None
    assert stamps(setting.see(3602.0)) == [1.0, 3602.0]
    assert setting.done[-1] == 2 * SECOND


@pytest.mark.parametrize("searches", [False, True])
def test_a_step_of_unknown_size_or_with_a_latency_unknown_ends_tracks(setting, searches):
    setting.see(1.0)
    setting.done.clear()
    setting.tracks.pipeline.latency.searches = searches
    back = replace(HOUR, by_ns=-5 * SECOND, timed=searches)
    setting.frames.reset_time(back, None)
    assert setting.done == [("clear", "gimbal"), "reset"]
    assert setting.time.shift_ns == 0
    assert setting.kept[-1] == "reset"
    assert setting.frames.results.robots == ()
    assert setting.log.counts["time_went_backward"] == 1
    assert stamps(setting.see(0.5)) == [0.5]  # no image precedes it


def test_robots_that_are_not_found_after_a_step_were_another_scene(setting):
    setting.see(1.0)
    setting.frames.reset_time(HOUR, None)
    setting.log.drain()
    setting.tracks.names = ["c"]
    for i in range(TRIAL_IMAGES):
        assert "reset" not in setting.done
        setting.see(3602.0 + i)
    assert setting.done[-1] == "reset"
    (sentence,) = setting.log.drain()
    assert "it is another scene" in sentence


def test_a_file_that_fails_is_reported_once_and_costs_no_result(setting):
    def fails(*_):
        raise UnicodeError("no text")

    setting.names.keep = fails
    assert stamps(setting.see(1.0, 2.0)) == [1.0, 2.0]
    (sentence,) = setting.log.drain()
    assert isinstance(sentence, WarningText)
    assert sentence == "state_file cannot be written (UnicodeError: no text)."
