# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A flight is scored as pictures of a data set are: robots that do not count are no mistakes."""

from __future__ import annotations

import json

import numpy as np
import pytest

from aerial_gnss_ros.adapters.results import detection_array
from aerial_gnss_ros.adapters.stamps import header_fields
from aerial_gnss_ros.bags.typestore import serialize
from aerial_gnss_ros.bags.writer import BagWriter
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.simulation.labels import RobotLabel
from aerial_gnss_ros.training.labelled_bag import read_bag
from aerial_gnss_ros.training.score import score

STAMP = 1_000_000_000
STRING, BOXES = "std_msgs/msg/String", "vision_msgs/msg/Detection2DArray"


def label(name, box, long_px=40.0, short_px=25.0, contrast=0.3, visible=1.0):
    return RobotLabel(name, "aqua", *box, long_px, short_px, 0.0, contrast, visible, (0.0, 0.0))


ROBOTS = [
    label("whole", (10.0, 10.0, 50.0, 30.0)),
    label("cut_off", (-0.5, 50.0, 19.5, 70.0), visible=0.4),
    label("faint", (60.0, 50.0, 100.0, 70.0), contrast=0.05),
    # Turned by 45 deg its box is long enough, but the robot itself is not.
    label("small", (70.0, 10.0, 86.0, 26.0), long_px=15.0, short_px=7.0),
]


def found(*boxes):
    corners = np.array(boxes, dtype=np.float64)
    xywh = np.hstack([(corners[:, :2] + corners[:, 2:]) / 2, corners[:, 2:] - corners[:, :2]])
    return Detections(xywh, np.full(len(boxes), 0.9), np.zeros(len(boxes), np.int64), ("aqua",))


class Finder:
    """Finds all four robots, and one where there is nothing."""

    name, class_names = "finder", ("aqua",)

    def detect(self, _):
        boxes = [(robot.left, robot.top, robot.right, robot.bottom) for robot in ROBOTS]
        return found(*boxes, (10.0, 80.0, 50.0, 99.0))


def write(path, labels):
    """A bag of one image; `labels` is the text on truth/labels, None for a bag without."""
    header = header_fields(STAMP, "camera")
    image = {
        "header": header, "height": 100, "width": 120, "encoding": "mono8", "step": 120,
        "data": bytes(12_000),
    }  # fmt: skip
    seen = [(r.left, r.top, r.right, r.bottom) for r in ROBOTS if r.clear]
    messages = [
        ("camera/image_raw", "sensor_msgs/msg/Image", image),
        ("truth/detections", BOXES, detection_array(found(*seen), header)),
    ]
    if labels is not None:
        messages.append(("truth/labels", STRING, {"data": labels}))
    with BagWriter(path) as bag:
        for topic, kind, values in messages:
            bag.write(topic, kind, STAMP, serialize(kind, values))
    return path


def reported(robots=ROBOTS):
    rows = [{"robot_id": robot.robot_id, **robot.figures()} for robot in robots]
    return json.dumps({"stamp_ns": STAMP, "robots": rows})


def test_only_what_lies_on_no_robot_is_false(tmp_path):
    (image,) = read_bag(write(tmp_path / "flight", reported()))
    assert image.truth.counted.tolist() == [True, False, False, False]
    assert image.truth.contrast.tolist() == [0.3, 0.3, 0.05, 0.3]
    assert image.truth.corners[1].tolist() == [-0.5, 50.0, 19.5, 70.0]
    result = score(Finder(), [image])
    assert (result.overall.robots, result.overall.found, result.overall.false) == (1, 1, 1)
    contrasts = result.as_dict()["by_contrast"]
    assert contrasts["0.2 or more"] == {"robots": 1, "found": 1, "false": 0}


def test_a_bag_from_before_is_read_as_before(tmp_path):
    (image,) = read_bag(write(tmp_path / "flight", None))
    assert image.truth.counted.tolist() == [True, True]  # whole and small: 16 x 16 px
    assert np.isnan(image.truth.contrast).all()
    result = score(Finder(), [image])
    assert (result.overall.robots, result.overall.found, result.overall.false) == (2, 2, 3)


def test_an_image_without_robots_is_scored(tmp_path):
    (image,) = read_bag(write(tmp_path / "flight", reported([])))
    assert score(Finder(), [image]).overall.false == 5


@pytest.mark.parametrize(
    "text", ["no JSON", "{}", "[]", '{"stamp_ns": 1, "robots": [{"left": 3}]}']
)
def test_labels_that_are_none_are_refused(tmp_path, text):
    with pytest.raises(InputError, match="truth/labels must have stamp_ns"):
        list(read_bag(write(tmp_path / "flight", text)))
