# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What drones and fleet tell one another besides sightings comes across, or is refused."""

from __future__ import annotations

import json
import math

import pytest

from aerial_gnss_ros.adapters.fleet_messages import (
    Request,
    drone_parameters,
    parameters_text,
    request,
    request_text,
)
from aerial_gnss_ros.core.config.estimator import estimator_config
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.core.values.estimates import MapDatum

VALUES = {
    "noise.set": "rtk", "camera.offset_m": (0.1, 0.0, -0.2), "detections.classes": ("aqua",),
    "noise.heading_deg": math.nan, "classes.aqua.coast_s": 7.0, "gimbal.reference": "earth",
}  # fmt: skip


def test_the_fleet_uses_the_parameters_of_the_drone():
    values = VALUES | {"state_file": "/home/x.json", "detections.area": "area.geojson"}
    told = drone_parameters(parameters_text("b", values, MapDatum(0.1, -0.2, math.nan)))
    assert told.drone == "b"
    assert repr(told.config) == repr(estimator_config(VALUES))
    assert repr(told.datum) == repr(MapDatum(0.1, -0.2, math.nan))
    assert drone_parameters(parameters_text("b", {}, None)).datum is None


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"version": 0}, "version 0"),
        ({"drone": "B"}, "'B'"),
        ({"parameters": []}, "drone b sends no parameters"),
        ({"parameters": {"noise.sett": "rtk"}}, "drone b cannot be used: .*noise.sett"),
        ({"datum": {"latitude": 9.0, "longitude": 0.0, "altitude": None}}, "origin of map"),
        ({"datum": {"latitude": 0.0, "longitude": "x", "altitude": None}}, "origin of map"),
        ({"datum": 3}, "origin of map"),
    ],
)
def test_parameters_that_cannot_be_are_refused(change, sentence):
    document = json.loads(parameters_text("b", VALUES, None)) | change
    with pytest.raises(InputError, match=sentence):
        drone_parameters(json.dumps(document))


def test_a_request_comes_across():
    wanted = Request("b", 17, ((3, 5), (9, 9)))
    assert request(request_text(wanted)) == wanted


@pytest.mark.parametrize(
    "change", [{"ranges": 3}, {"ranges": [[1]]}, {"ranges": [[1, -2]]}, {"session": "x"}]
)
def test_a_request_of_another_form_is_refused(change):
    document = json.loads(request_text(Request("b", 17, ((3, 5),)))) | change
    with pytest.raises(InputError):
        request(json.dumps(document))
