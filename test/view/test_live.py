# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The live source: it fetches only while somebody watches, and old news looks old."""

from __future__ import annotations

import json
import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.adapters.overview import Light
from aerial_gnss_ros.view.live import NEWS_S, PICTURE_S, SILENT_S, WAIT_S, Live

MADE = runpy.run_path(str(Path(__file__).with_name("overviews.py")))
BEGIN, SECOND, overview, robot = (MADE[name] for name in ("BEGIN", "SECOND", "overview", "robot"))


class Ros:
    """Stands for the node that fetches; counts what is subscribed."""

    def __init__(self):
        self.subscribed = set()
        self.texts, self.images, self.arrays, self.news = [], [], [], []

    def watch(self):
        self.subscribed |= {"overview", "diagnostics"}

    def look(self):
        self.subscribed |= {"image", "detections"}

    def rest(self, *names):
        self.subscribed -= set(names or self.subscribed)

    def overview(self):
        return self.texts.pop() if self.texts else None

    def image(self):
        return self.images.pop() if self.images else None

    def detections(self):
        while self.arrays:
            yield self.arrays.pop(0)

    def lights(self):
        while self.news:
            yield self.news.pop(0)


class Browser:
    """Keeps what it is sent."""

    slow = False
    ticks = 0

    def __init__(self):
        self.messages, self.pictures = [], []
        self.sent_in = -1

    @property
    def busy(self):
        """Whether something is under way, as it always is within the tick that sent it."""
        return self.slow or self.sent_in == Browser.ticks

    def send(self, message):
        self.sent_in = Browser.ticks
        if isinstance(message, bytes):
            length = int.from_bytes(message[:4], "little")
            self.pictures.append(json.loads(message[4 : 4 + length]))
        else:
            self.messages.append(json.loads(message) if isinstance(message, str) else message)
        return True

    def last(self, kind="scene"):
        return next(one for one in reversed(self.messages) if one["kind"] == kind)


class Page:
    def __init__(self):
        self.now, self.ros, self.browser = 100.0, Ros(), Browser()
        self.live = Live(self.ros, "live", clock=lambda: self.now)

    def publish(self, seconds, *robots, after=0.1, **other):
        self.ros.texts.append(json.dumps(overview(seconds, *robots, **other)))
        self.tick(after)

    def tick(self, after=0.1):
        self.now += after
        Browser.ticks += 1
        self.live.tick()


@pytest.fixture
def page():
    """Return a live source with a browser that has not joined yet."""
    return Page()


def test_nothing_is_fetched_before_the_first_browser_and_after_the_last(page):
    page.publish(0.0)
    assert page.ros.texts, "an overview was fetched for nobody"
    page.live.joined(page.browser)
    assert page.ros.subscribed == {"overview", "diagnostics"}
    page.live.looks(page.browser, wanted=True)
    assert page.ros.subscribed == {"overview", "diagnostics", "image", "detections"}
    page.live.looks(page.browser, wanted=False)
    assert page.ros.subscribed == {"overview", "diagnostics"}
    page.live.looks(page.browser, wanted=True)
    page.live.left(page.browser)
    assert page.ros.subscribed == set()
    page.live.left(page.browser)  # some browsers leave twice


def test_a_browser_that_leaves_does_not_end_it_for_another(page):
    other = Browser()
    page.live.joined(page.browser)
    page.live.joined(other)
    page.live.looks(other, wanted=True)
    page.live.left(page.browser)
    page.publish(0.0, robot("a", 0.0))
    assert [one["id"] for one in other.last()["robots"]] == ["a"]
    assert "image" in page.ros.subscribed


def test_who_comes_later_learns_the_path_and_how_old_the_news_is(page):
    page.live.joined(page.browser)
    page.publish(0.0, robot("a", 0.0))
    page.publish(1.0, robot("a", 1.0))
    page.now += 7.0
    late = Browser()
    page.live.joined(late)
    assert len(late.last("hello")["paths"]["a"]) == 2
    scene = late.last()
    assert scene["silent_s"] == pytest.approx(7.0)
    assert scene["now_ns"] == pytest.approx(BEGIN + 8 * SECOND, abs=1000)


def test_a_robot_that_is_no_longer_published_is_lost(page):
    page.live.joined(page.browser)
    page.publish(0.0, robot("a", 0.0), robot("b", 0.0))
    page.publish(1.0, robot("a", 1.0))
    states = {one["id"]: one["state"] for one in page.browser.last()["robots"]}
    assert states == {"a": "confirmed", "b": "lost"}


def test_paths_begin_anew_where_a_recording_does(page):
    page.live.joined(page.browser)
    page.publish(50.0, robot("a", 50.0))
    page.publish(49.5, robot("a", 49.5))
    assert len([one for one in page.browser.messages if one["kind"] == "hello"]) == 2
    page.publish(0.0, robot("b", 0.0))
    assert list(page.browser.last("hello")["paths"]) == ["b"]
    assert [one["id"] for one in page.browser.last()["robots"]] == ["b"]


def test_lights_come_also_without_positions_and_go_out_with_their_node(page):
    page.live.joined(page.browser)
    page.ros.news.append(Light("positions", "error", "no image yet"))
    page.tick(NEWS_S)
    assert page.browser.last("silence")["lights"] == [
        {"name": "positions", "level": "error", "words": "no image yet"}
    ]
    page.tick(SILENT_S)
    (light,) = page.browser.last("silence")["lights"]
    assert (light["name"], light["level"]) == ("estimator or fleet", "error")
    assert "no diagnostics for 5 s" in light["words"]


@pytest.mark.parametrize(("drones", "name"), [([], "estimator"), (["a"], "fleet")])
def test_a_silent_node_is_called_by_what_it_sent(page, drones, name):
    place = [0.0, 0.0, 20.0]
    of = {"drones": [{"name": one, "place": place} for one in drones]} if drones else {}
    page.live.joined(page.browser)
    page.publish(0.0, **of)
    page.tick(SILENT_S)
    assert page.browser.last("silence")["lights"][0]["name"] == name


def test_a_detector_alone_is_not_enough(page):
    page.live.joined(page.browser)
    page.ros.news.append(Light("detector images", "ok", "received"))
    page.tick(NEWS_S)
    detector, estimator = page.browser.last("silence")["lights"]
    assert (detector["level"], estimator["level"]) == ("ok", "error")


def test_lights_of_the_overview_serve_where_there_are_no_diagnostics(page):
    page.live.joined(page.browser)
    own = {"name": "fix", "level": "ok", "words": "received"}
    page.publish(0.0, lights=[own])
    assert page.browser.last()["lights"] == [own]


def test_an_overview_of_another_version_is_said(page):
    page.live.joined(page.browser)
    page.ros.texts.append('{"a": 1}')
    page.tick(NEWS_S)
    assert "does not hold what this version writes" in page.live.lights()[0]["words"]


def test_a_browser_that_is_slow_misses_news_and_nobody_waits(page):
    page.live.joined(page.browser)
    page.browser.slow = True
    page.publish(0.0)
    page.publish(1.0)
    kinds = [one["kind"] for one in page.browser.messages]
    assert kinds == ["hello", "hello"]


def stamped(seconds, **fields):
    ns = BEGIN + round(seconds * SECOND)
    stamp = SimpleNamespace(sec=ns // SECOND, nanosec=ns % SECOND)
    return SimpleNamespace(header=SimpleNamespace(stamp=stamp), **fields)


def image(seconds, encoding="bgr8"):
    data = np.zeros(30 * 40 * 3, np.uint8)
    return stamped(seconds, height=30, width=40, encoding=encoding, step=120, data=data)


def array(seconds):
    hypothesis = SimpleNamespace(class_id="aqua", score=0.8)
    centre = SimpleNamespace(position=SimpleNamespace(x=100.0, y=50.0))
    box = SimpleNamespace(center=centre, size_x=9.0, size_y=9.0)
    one = SimpleNamespace(results=[SimpleNamespace(hypothesis=hypothesis)], bbox=box)
    return stamped(seconds, detections=[one])


def test_an_image_waits_for_its_boxes_and_names(page):
    page.live.joined(page.browser)
    page.live.looks(page.browser, wanted=True)
    page.ros.images.append(image(1.0))
    page.tick()
    assert page.browser.pictures == []
    page.ros.arrays += [array(0.9), array(1.0)]
    page.publish(1.0, robot("a", 1.0))
    (shown,) = page.browser.pictures
    assert (shown["boxes_known"], [box["name"] for box in shown["boxes"]]) == (True, ["a"])


def test_an_image_without_boxes_is_shown_as_such(page):
    page.live.joined(page.browser)
    page.live.looks(page.browser, wanted=True)
    page.ros.arrays.append(array(0.9))
    page.ros.images.append(image(1.0))
    page.tick()
    page.tick(WAIT_S)
    (shown,) = page.browser.pictures
    assert (shown["boxes_known"], shown["boxes"]) == (False, [])


def test_images_are_few_and_only_for_those_who_look(page):
    other = Browser()
    for browser in (page.browser, other):
        page.live.joined(browser)
    page.live.looks(other, wanted=True)
    for i in range(60):
        page.ros.images[:] = [image(0.1 * i)]
        page.ros.arrays.append(array(0.1 * i))
        page.publish(0.1 * i, robot("a", 0.1 * i))
    assert page.browser.pictures == []
    assert 6.0 / PICTURE_S * 0.7 < len(other.pictures) <= 6.0 / PICTURE_S


def test_an_image_that_cannot_be_decoded_is_said(page):
    page.live.joined(page.browser)
    page.live.looks(page.browser, wanted=True)
    page.ros.images.append(image(1.0, "16UC1"))
    page.tick()
    page.tick(WAIT_S)
    assert "16UC1" in page.browser.last("no picture")["words"]
