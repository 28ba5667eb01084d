# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss replay` and bad input: one sentence, status 2, nothing lost and nothing left."""

from __future__ import annotations

import errno

import pytest


def test_an_existing_folder_is_refused_before_anything_is_read(tmp_path, refusal):
    out = tmp_path / "out"
    out.mkdir()
    assert "out exists already; choose another name" in refusal(tmp_path / "no", out)
    assert list(out.iterdir()) == []


@pytest.mark.parametrize("topic", ["fix", "gimbal", "height", "camera/camera_info"])
def test_a_missing_topic_is_named_with_those_that_are_there(tmp_path, flight, topic, refusal):
    bag = flight.write(tmp_path / "bag", without=(topic,))
    sentence = refusal(bag, tmp_path / "out")
    assert f"bag lacks /{topic} (" in sentence
    assert "It holds /" in sentence
    assert "/detections (vision_msgs/msg/Detection2DArray, 20)" in sentence
    assert "--namespace" in sentence


def test_all_missing_topics_are_named_and_the_namespace_is_found(tmp_path, flight, refusal):
    bag = flight.write(tmp_path / "bag", namespace="drone1")
    sentence = refusal(bag, tmp_path / "out", "--params", write_params(tmp_path))
    assert "try --namespace drone1" in sentence
    bag = flight.write(tmp_path / "b", without=("fix", "height"))
    sentence = refusal(bag, tmp_path / "out")
    assert "lacks /fix (fix, sensor_msgs/msg/NavSatFix), /height (height, std" in sentence


def write_params(tmp_path, text="estimator: {ros__parameters: {max_wait: 2}}\n"):
    path = tmp_path / "params.yaml"
    path.write_text(text)
    return path


def test_attitude_is_not_needed_with_an_earth_gimbal_but_is_with_a_body_one(
    tmp_path, flight, replay, refusal
):
    bag = flight.write(tmp_path / "bag", without=("attitude",))
    assert replay(bag, tmp_path / "out") == 0
    body = write_params(tmp_path, "estimator: {ros__parameters: {gimbal: {reference: body}}}\n")
    sentence = refusal(bag, tmp_path / "body", "--params", body)
    assert "lacks /attitude (attitude, sensor_msgs/msg/Imu)" in sentence


def test_a_bag_without_images_and_detections_is_refused(tmp_path, flight, refusal):
    bag = flight.write(tmp_path / "bag", without=("detections",))
    sentence = refusal(bag, tmp_path / "out")
    assert "neither detections on /detections nor images on /camera/image_raw or" in sentence


def test_a_model_for_a_bag_without_images_is_refused(tmp_path, flight, refusal):
    bag = flight.write(tmp_path / "bag")
    sentence = refusal(bag, tmp_path / "out", "--model", "mine.onnx")
    assert "has no images on /camera/image_raw" in sentence
    assert "without --model" in sentence


def test_another_message_type_is_named(tmp_path, flight, replay, refusal):
    def as_float32(topic, msgtype, fields):
        return topic, "std_msgs/msg/Float32" if topic == "height" else msgtype, fields

    bag = flight.write(tmp_path / "bag", change=as_float32)
    sentence = refusal(bag, tmp_path / "out")
    assert "/height has message type std_msgs/msg/Float32, but height is set to" in sentence
    text = "estimator: {ros__parameters: {height: {type: float32}}}\n"
    assert replay(bag, tmp_path / "out", "--params", write_params(tmp_path, text)) == 0


def test_a_depth_of_a_foreign_type_is_named(tmp_path, flight, refusal):
    text = "estimator: {ros__parameters: {depth: {topics: [camera/camera_info]}}}\n"
    params = write_params(tmp_path, text)
    sentence = refusal(flight.write(tmp_path / "bag"), tmp_path / "out", "--params", params)
    assert "but depths must be std_msgs/msg/Float64" in sentence


def test_boxes_of_a_foreign_type_are_named(tmp_path, flight, refusal):
    def foreign(topic, msgtype, fields):
        if topic == "detections":
            return topic, "std_msgs/msg/String", {"data": "aqua at 3, 4"}
        return topic, msgtype, fields

    sentence = refusal(flight.write(tmp_path / "bag", change=foreign), tmp_path / "out")
    assert "/detections has message type std_msgs/msg/String, but detections is set" in sentence
    assert "set detections.topic in --params" in sentence


def test_missing_and_truncated_bags_are_refused(tmp_path, flight, refusal):
    sentence = refusal([tmp_path / "a", tmp_path / "b"], tmp_path / "out")
    assert f"{tmp_path / 'a'}, {tmp_path / 'b'} do not exist" in sentence
    bag = flight.write(tmp_path / "bag")
    content = (bag / "bag.mcap").read_bytes()
    (bag / "bag.mcap").write_bytes(content[: len(content) // 2])
    assert "truncated or damaged" in refusal(bag, tmp_path / "out")


@pytest.mark.usefixtures("detector")
@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ({"encoding": "bayer_rggb8"}, "encoding 'bayer_rggb8' are not supported"),
        (
            {"width": 320, "step": 320, "data": bytes(320 * 480)},
            "images of 320 x 480 are refused: /camera/camera_info describes a camera of 640 x 480",
        ),
    ],
)
def test_images_that_can_never_be_used_are_refused(tmp_path, flight, fields, expected, refusal):
    def change(topic, msgtype, given):
        return topic, msgtype, given | fields if topic == "camera/image_raw" else given

    bag = flight.write(tmp_path / "bag", images=True, change=change)
    sentence = refusal(bag, tmp_path / "out")
    assert "/camera/image_raw: " in sentence
    assert expected in sentence


@pytest.mark.usefixtures("detector")
def test_images_of_another_size_than_the_parameters_describe_are_refused(
    tmp_path, flight, replay, refusal
):
    """A robot at the wrong distance from the middle of the image is a robot at a wrong place."""
    camera = "focal_length_mm: 9, sensor_width_mm: 12.8, image_height_px: 480, source: parameters"
    bag = flight.write(tmp_path / "bag", images=True)
    for width in (640, 1280):
        text = f"estimator: {{ros__parameters: {{camera: {{image_width_px: {width}, {camera}}}}}}}"
        options = (bag, tmp_path / f"out{width}", "--params", write_params(tmp_path, text))
        if width == 640:
            assert replay(*options) == 0
        else:
            assert "of 640 x 480 are refused: camera.image_width_px and" in refusal(*options)


def test_a_camera_info_of_zeros_is_refused(tmp_path, flight, refusal):
    def zeros(topic, msgtype, fields):
        return topic, msgtype, {"header": fields["header"]} if "info" in topic else fields

    bag = flight.write(tmp_path / "bag", change=zeros)
    assert "camera/camera_info: " in refusal(bag, tmp_path / "out")


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (None, "nothing.onnx"),
        (b"no model", "model.onnx"),
    ],
)
def test_a_model_that_is_none_is_refused(tmp_path, flight, content, expected, refusal):
    model = tmp_path / ("nothing.onnx" if content is None else "model.onnx")
    if content is not None:
        model.write_bytes(content)
    bag = flight.write(tmp_path / "bag", images=True)
    assert expected in refusal(bag, tmp_path / "out", "--model", model)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("estimator: {ros__parameters: {max_wiat: 2}}", "max_wiat is not a parameter; did you"),
        ("estimator: {ros__parameters: {max_wait: long}}", "max_wait must be a number"),
        ("estimator: {ros__parameters: {max_wait: 99}}", "max_wait must lie within 0 to 30"),
    ],
)
def test_bad_parameters_are_refused(tmp_path, flight, text, expected, refusal):
    bag = flight.write(tmp_path / "bag")
    sentence = refusal(bag, tmp_path / "out", "--params", write_params(tmp_path, text))
    assert expected in sentence


def test_an_unknown_vehicle_is_refused_with_the_known_ones(tmp_path, refusal):
    sentence = refusal(tmp_path / "bag", tmp_path / "out", "--vehicle", "submarine")
    assert "submarine" in sentence
    assert "generic" in sentence


@pytest.mark.parametrize("where", ["rosbags.rosbag2.storage_mcap.McapWriter.write",
                                   "pathlib.Path.write_text"])  # fmt: skip
def test_a_full_disk_leaves_nothing(tmp_path, flight, monkeypatch, where, refusal):
    bag = flight.write(tmp_path / "bag")

    def full(*_args, **_options):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(where, full)
    assert "the disk is full: " in refusal(bag, tmp_path / "out")
