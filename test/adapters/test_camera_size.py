# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images of another size than the camera is described for."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from aerial_gnss_ros.adapters.camera_size import CameraSize


def info(width=640, height=480, focal=500.0, key="k"):
    return SimpleNamespace(width=width, height=height, **{key: [focal, *[0.0] * 8]})


@pytest.mark.parametrize("key", ["k", "K"], ids=["ROS 2", "ROS 1"])
@pytest.mark.parametrize(
    ("size", "word"), [((640, 480), None), ((640, 481), "size"), ((480, 640), "size")]
)
def test_an_image_must_have_the_size_of_the_camera(key, size, word):
    sizes = CameraSize("start it anew")
    assert sizes.refusal(*size, "/info") is None  # nothing is known yet
    sizes.update(info(key=key))
    found = sizes.refusal(*size, "/info")
    if word is None:
        assert found is None
    else:
        words = (
            f"images of {size[0]} x {size[1]} are refused: /info describes a camera of 640 x 480"
        )
        assert found == ("camera_info_size", f"{words}; start it anew")


@pytest.mark.parametrize("zeros", [{"width": 0}, {"height": 0}, {"focal": 0.0}])
def test_a_camera_that_is_not_calibrated_refuses_every_image(zeros):
    sizes = CameraSize("")
    sizes.update(info(**zeros))
    word, sentence = sizes.refusal(640, 480, "/info")
    assert word == "camera_info_zeros"
    assert "/info is unusable: its size or focal length is 0" in sentence
    sizes.update(info())
    assert sizes.refusal(640, 480, "/info") is None
