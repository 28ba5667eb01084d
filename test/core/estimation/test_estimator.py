# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The engine: every refusal by the smallest scene that has it."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.telemetry.input_status import InputState
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.rejection import Reason
from aerial_gnss_ros.core.values.samples import Fix, Orientation, Scalar

NAN4 = np.full(4, math.nan)
ELSEWHERE = '{"type": "Polygon", "coordinates": [[[-59.6, 13.2], [-59.5, 13.2], [-59.5, 13.3]]]}'
BODY = {"gimbal.reference": "heading"}


def _without(name):
    def change(scene):
        scene.samples[name] = ()

    return change


def _late(name):
    def change(scene):
        scene.samples[name] = (0.5, 0.9)

    return change


def _gap(name):
    def change(scene):
        scene.samples[name] = (-2.0, 2.0)

    return change


def _value(name, make):
    def change(scene):
        scene.change[name] = make

    return change


def _boxes(**fields):
    def change(scene):
        scene.boxes = replace(scene.boxes, **fields)

    return change


def _camera(value):
    def change(scene):
        scene.camera = value

    return change


def _nothing(_scene):
    pass


REFUSALS = [
    (Reason.LOW_SCORE, {"detections.min_score": 0.95}, _nothing),
    (Reason.WRONG_CLASS, {"detections.classes": ["boat"]}, _nothing),
    (Reason.BAD_DETECTIONS, {}, _boxes(centers=np.array([[math.nan, 1.0]]))),
    (Reason.BAD_DETECTIONS, {}, _boxes(scores=np.array([math.nan]))),
    (Reason.BAD_DETECTIONS, {}, _boxes(sizes=np.array([[-1.0, 3.0]]))),
    (Reason.NO_CAMERA_INFO, {}, _camera(None)),
    (Reason.NO_CAMERA_INFO, {}, lambda s: setattr(s, "camera", (1.5, s.camera[1]))),
    (Reason.BAD_CAMERA_INFO, {}, _camera((0.0, None))),
    (Reason.OUTSIDE_CALIBRATED_IMAGE, {}, _boxes(centers=np.array([[1500.0, 360.0]]))),
    (
        Reason.ABOVE_HORIZON,
        {},
        lambda s: setattr(s.world, "rpy_deg", lambda _t: (0.0, -5.0, 90.0)),
    ),
    (Reason.OUT_OF_RANGE, {"surface.max_range": 20.0}, _nothing),
    (Reason.OUTSIDE_AREA, {"detections.area": ELSEWHERE}, _nothing),
    (Reason.WRONG_SIZE, {"classes.aqua.length_m": [3.0, 4.0]}, _nothing),
    (Reason.NO_FIX, {}, _without("fix")),
    (Reason.NO_ATTITUDE, BODY, _without("attitude")),
    (Reason.NO_GIMBAL, {}, _without("gimbal")),
    (Reason.NO_HEIGHT, {}, _without("height")),
    (Reason.STALE_FIX, {}, _late("fix")),
    (Reason.STALE_ATTITUDE, BODY, _late("attitude")),
    (Reason.STALE_GIMBAL, {}, _late("gimbal")),
    (Reason.STALE_HEIGHT, {}, _late("height")),
    (Reason.GAP_FIX, {}, _gap("fix")),
    (Reason.GAP_ATTITUDE, BODY, _gap("attitude")),
    (Reason.GAP_GIMBAL, {}, _gap("gimbal")),
    (Reason.GAP_HEIGHT, {}, _gap("height")),
    (Reason.BAD_FIX, {}, _value("fix", lambda ns: Fix(ns, 0.2, -1.0, 3.0, valid=False))),
    (Reason.BAD_FIX, {}, _value("fix", lambda ns: Fix(ns, math.nan, -1.0, 3.0))),
    (Reason.BAD_FIX, {}, _value("fix", lambda ns: Fix(ns, 13.194, -1.0, 3.0))),  # degrees
    (Reason.BAD_ATTITUDE, BODY, _value("attitude", lambda ns: Orientation(ns, np.zeros(4)))),
    (Reason.BAD_GIMBAL, {}, _value("gimbal", lambda ns: Orientation(ns, NAN4))),
    (Reason.BAD_GIMBAL, {}, _value("gimbal", lambda ns: Orientation(ns, np.full(4, 0.6)))),
    (Reason.BAD_HEIGHT, {}, _value("height", lambda ns: Scalar(ns, math.nan))),
    (Reason.BAD_HEIGHT, {}, _value("height", lambda ns: Scalar(ns, -2.0))),
]


@pytest.mark.parametrize(
    ("reason", "values", "change"), REFUSALS, ids=[f"{i}-{r[0]}" for i, r in enumerate(REFUSALS)]
)
def test_every_refusal_by_its_smallest_scene(sea, reason, values, change):
    scene = sea.Scene(values)
    change(scene)
    result = scene.run()
    assert [rejection.reason for rejection in result.rejections] == [reason]
    assert scene.engine.counts == Counter({reason: 1})
    u, v = result.rejections[0].u_px, result.rejections[0].v_px
    assert [u, v] == pytest.approx(scene.boxes.centers[0], nan_ok=True)
    assert result.estimates == ()


def test_the_table_above_leaves_out_no_reason():
    reported = {reason for reason, _, _ in REFUSALS}
    assert set(Reason) - reported == {
        Reason.GATED,  # in test_tracks: a second box on a robot
        Reason.INTERNAL,  # in test_guard
        Reason.TOO_FAST,  # in test_account, as the next
        Reason.UNCONFIRMED,
    }


def test_boxes_of_other_classes_only_are_reported_with_both_names(sea):
    def reported(classes):
        engine = sea.estimator({"detections.classes": ["boat", "ship"]})
        for i, name in enumerate(classes):
            engine.add_detections(sea.boxes(0.1 * i, [sea.middle], name))
        engine.flush()
        return [sentence for sentence in engine.events if "wrong_class" in sentence]

    assert reported(["aqua"] * 9) == []  # may still be chance
    (sentence,) = reported(["aqua"] * 7 + ["buoy"] * 7)
    assert sentence.startswith("All boxes so far are of class 'aqua', 'buoy' and refused as wrong")
    assert "detections.classes is 'boat', 'ship'; enter the class" in sentence
    assert reported(["boat"] + ["aqua"] * 20) == []


def test_nothing_is_refused_where_nothing_is_missing(sea):
    result = sea.Scene({"tracks.confirm_hits": 1}).run()
    assert result.rejections == ()
    # 30 m up, 60 deg below the horizon: 30 / tan 60 deg = 17.3205 m ahead (north)
    assert result.estimates[0].position == pytest.approx([0.0, 17.3205], abs=1e-3)
    assert result.estimates[0].state is State.CONFIRMED
    assert result.pose.oldest_age_s == pytest.approx(0.1)


def test_one_bad_neighbour_refuses_the_scene_between(sea):
    scene = sea.Scene()
    scene.change["gimbal"] = lambda ns: (
        scene.world.gimbal(0.9) if ns < sea.stamp(1.0) else Orientation(ns, NAN4)
    )
    assert [r.reason for r in scene.run().rejections] == [Reason.BAD_GIMBAL]


def test_what_can_never_come_is_reported_at_once_and_waits_for_nothing_late(sea):
    scene = sea.Scene({"height.max_gap": 1.5})
    scene.samples |= {"fix": (0.9,), "height": (0.2, 2.0)}
    scene.feed()
    result = scene.engine.advance(sea.stamp(2.0))[0]
    assert [r.reason for r in result.rejections] == [Reason.GAP_HEIGHT]


def test_constants_need_no_messages(sea):
    values = {
        "fix.source": "constant",
        "fix.latitude_deg": sea.origin["map.latitude_deg"],
        "fix.longitude_deg": sea.origin["map.longitude_deg"],
        "gimbal.source": "constant",
        "gimbal.rpy_deg": [0.0, 60.0, 90.0],
        "height.source": "constant",
        "height.value_m": 30.0,
        "camera.source": "parameters",
        "camera.focal_length_mm": 9.0,
        "camera.sensor_width_mm": 12.8,
        "camera.image_width_px": 1280,
        "camera.image_height_px": 720,
        "tracks.confirm_hits": 1,
    }
    engine = sea.estimator(values)
    engine.add_detections(sea.boxes(1.0, [sea.middle]))
    results = engine.advance(sea.stamp(1.0))
    assert results[0].estimates[0].position == pytest.approx([0.0, 17.3205], abs=1e-3)
    states = {name: status.state for name, status in engine.inputs.items()}
    assert states.pop("detections") is InputState.OK
    assert states.pop("attitude") is InputState.UNUSED
    assert set(states.values()) == {InputState.CONSTANT}


def test_a_mast_without_a_map_origin_has_its_own_place(sea):
    engine = sea.estimator(
        {"map.latitude_deg": math.nan, "map.longitude_deg": math.nan}
        | {"fix.source": "constant", "fix.latitude_deg": 10.0, "fix.longitude_deg": 20.0}
    )
    engine.add_detections(sea.boxes(1.0, []))
    datum = engine.flush()[0].datum
    assert math.degrees(datum.latitude) == pytest.approx(10.0)
