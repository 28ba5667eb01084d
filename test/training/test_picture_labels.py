# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labels by picture and what false boxes lie on, with boxes whose overlap is known by hand."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.base import Detections
from aerial_gnss_ros.training.picture_labels import Comparison, PictureLabels

SIZE = (200, 100)
HEADER = "file_name,class,x_px,y_px,width_px,height_px\n"


def found(*boxes, names=("aqua",)):
    """Boxes of left, top, width, height, where the first pixel reaches from 0 to 1."""
    array = np.array(boxes, dtype=float).reshape(-1, 4)
    xywh = np.hstack([array[:, :2] + array[:, 2:] / 2 - 0.5, array[:, 2:]])
    count = len(array)
    scores = 0.9 - 0.1 * np.arange(count)
    return Detections(xywh, scores, np.zeros(count, np.int64), names)


@pytest.mark.parametrize(
    "content",
    [
        HEADER + "a.jpg,aqua,10,20,30,40\n",
        "file_name,class_id,x_px,y_px,width_px,height_px\nsub/a.jpg,aqua,10,20,30,40\n",
        (
            "file_name,width_px,height_px,class,x_px,y_px,width_box_px,height_box_px\n"
            "a.jpg,200,100,aqua,10,20,30,40\n"
        ),
    ],
)
def test_reads_a_table_with_boxes_where_they_are(tmp_path, content):
    path = tmp_path / "labels.csv"
    path.write_text(content)
    labels = PictureLabels(path, ("aqua",)).of("elsewhere/a.jpg", SIZE)
    assert labels.classes == ("aqua",)
    assert labels.corners.tolist() == [[9.5, 19.5, 39.5, 59.5]]
    comparison = Comparison()
    comparison.add(found((10, 20, 30, 40)), labels)
    assert comparison.score.offset_px == [(0.0, 0.0)]


def test_reads_yolos_text_files(tmp_path):
    (tmp_path / "a.txt").write_text("1 0.125 0.4 0.15 0.4\n\n")
    (tmp_path / "b.txt").write_text("")
    labels = PictureLabels(tmp_path, ("buoy", "aqua"))
    assert labels.of("a.png", SIZE).classes == ("aqua",)
    assert labels.of("a.png", SIZE).corners == pytest.approx(np.array([[9.5, 19.5, 39.5, 59.5]]))
    assert labels.of("b.png", SIZE).classes == ()
    assert labels.of("c.png", SIZE) is None


def test_says_what_false_boxes_lie_on(tmp_path):
    path = tmp_path / "labels.csv"
    path.write_text(
        HEADER
        + "a.jpg,aqua,0,0,20,20\na.jpg,aqua,100,0,20,20\na.jpg,boat,40,0,20,20\n"
        + "a.jpg,swimmer,40,40,10,10\nempty.jpg,,,,,\n"
    )
    labels = PictureLabels(path, ("aqua",))
    comparison = Comparison()
    comparison.add(
        found(
            (0, 0, 20, 21),  # the first robot
            (42, 2, 4, 4),  # small, but with its middle in the boat
            (51, 15, 20, 20),  # 5 of 75 px, less than a tenth
            (41, 41, 10, 10),  # most of the swimmer
        ),
        labels.of("a.jpg", SIZE),
    )
    comparison.add(found((5, 5, 30, 30)), labels.of("empty.jpg", SIZE))
    overall = comparison.score.overall
    assert (overall.robots, overall.found, overall.false) == (2, 1, 4)
    assert comparison.false_on == {"boat": 1, "nothing": 2, "swimmer": 1}
    assert comparison.others == {"boat": 1, "swimmer": 1}
    assert comparison.labelled == 2
    assert comparison.right_scores == pytest.approx([0.9])
    assert comparison.false_scores == pytest.approx([0.8, 0.7, 0.6, 0.9])
    assert labels.of("unknown.jpg", SIZE) is None


@pytest.mark.parametrize(("least_iou", "hits"), [(0.5, 0), (0.3, 1)])
def test_labels_of_all_classes_can_count_at_any_overlap(tmp_path, least_iou, hits):
    path = tmp_path / "labels.csv"
    path.write_text(HEADER + "a.jpg,boat,0,0,20,20\n")
    labels = PictureLabels(path, ("object",)).of("a.jpg", SIZE)
    comparison = Comparison(least_iou, any_class=True)
    comparison.add(found((0, 0, 40, 25), names=("object",)), labels)  # IoU 0.4
    overall = comparison.score.overall
    assert (overall.robots, overall.found, overall.false) == (1, hits, 1 - hits)
    assert not comparison.others
    assert comparison.false_on == ({} if hits else {"a robot, but off": 1})


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (None, "cannot be read"),
        ("file_name,class\n", r"lacks the columns x_px, y_px; it is not a table of labels"),
        (HEADER, "has no rows; there is nothing to compare with"),
        (HEADER + "a.jpg,aqua,1,2,3,four\n", r"line 2: \['1', '2', '3', 'four'\] must be left"),
        (HEADER + "a.jpg,aqua,1,2,-3,4\n", r"line 2: .* is not a box"),
        (HEADER + "a.jpg,aqua,1,nan,3,4\n", r"line 2: .* is not a box"),
        ("file_name,class,x_px,y_px\na.jpg,aqua,1,2\n", "lacks the columns width_px, height_px"),
    ],
)
def test_a_wrong_table_is_one_sentence(tmp_path, content, sentence):
    path = tmp_path / "labels.csv"
    if content is not None:
        path.write_text(content)
    with pytest.raises(InputError, match=sentence):
        PictureLabels(path, ("aqua",))


def test_wrong_text_files_are_one_sentence(tmp_path):
    with pytest.raises(InputError, match="holds no label files"):
        PictureLabels(tmp_path, ("aqua",))
    (tmp_path / "a.txt").write_text("0 0.5 0.5 0.1 0.1\n0 0.5 0.5\n")
    with pytest.raises(InputError, match=r"a\.txt, line 2: has 3 values, .*\.$"):
        PictureLabels(tmp_path, ("aqua",)).of("a.jpg", SIZE)
