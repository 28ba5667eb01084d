# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A reference of a class that the detector does not know is reported."""

from __future__ import annotations

from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.estimation.reference_classes import WAITS_S, ReferenceClasses
from aerial_gnss_ros.core.values.events import Events

PIER = {"class": "Mooring buoy", "position": [13.1939, -59.6415], "sigma_m": 0.05}


def told(sea, *class_ids, ended=False):
    """Return what is said of a reference where images each 10 s have boxes of these classes."""
    log = Events()
    known = estimator_config({"references": {"pier": PIER}}).references
    monitor = ReferenceClasses(known, log)
    for i, class_id in enumerate(class_ids):
        monitor.update(sea.boxes(10.0 * i, [(1.0, 2.0)] if class_id else [], class_id))
    if ended:
        monitor.end()
    return log.drain()


def test_a_class_that_no_box_has_is_reported_once(sea):
    (sentence,) = told(sea, *["aqua"] * 9)
    assert "references.pier.class is 'Mooring buoy'" in sentence
    assert "'aqua'" in sentence


def test_nothing_is_said_before_it_had_time_to_come_into_view(sea):
    assert told(sea, *["aqua"] * round(WAITS_S / 10.0)) == []
    assert told(sea, *[""] * 9) == []


def test_a_short_recording_says_it_at_its_end(sea):
    assert len(told(sea, "aqua", ended=True)) == 1
    assert told(sea, "", ended=True) == told(sea, "mooring_buoy", ended=True) == []


def test_a_class_is_known_however_it_is_written(sea):
    assert told(sea, "mooring_buoy", *["aqua"] * 9) == []


def test_an_estimator_reports_it(sea):
    world = sea.World(robots={"a": lambda _t: (0.0, 17.0)})
    engine = sea.estimator({"references": {"pier": PIER}, "camera.find_latency": False})
    sea.play(engine, world, WAITS_S + 1.0, images=2, telemetry=4)
    assert [one for one in engine.events if "pier has not been seen" in one]
