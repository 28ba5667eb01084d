# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Bags of simulated flights: what is in them, the same bytes twice, and nothing left half made."""

from __future__ import annotations

import errno
import hashlib
import json

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.adapters import canonical
from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.bags.typestore import typestore
from aerial_gnss_ros.bags.writer import BagWriter
from aerial_gnss_ros.core.values.errors import OutputError
from aerial_gnss_ros.simulation.bag import write_bag
from aerial_gnss_ros.simulation.boxes import DetectorPlan
from aerial_gnss_ros.simulation.experiment import CameraClock, Experiment, default_camera
from aerial_gnss_ros.simulation.flight import FlightPlan, GeneratedFlight
from aerial_gnss_ros.simulation.scene import demo_scene
from aerial_gnss_ros.simulation.sensors import START_NS, sensor_plan
from aerial_gnss_ros.simulation.view import project_points

TELEMETRY = {"/fix", "/attitude", "/gimbal", "/height", "/camera/camera_info"}
TRUTH = {
    "/truth/scenario", "/truth/fix", "/truth/attitude", "/truth/gimbal", "/truth/height",
    "/truth/detections", "/truth/robots/aqua_1/fix", "/truth/robots/aqua_2/fix",
}  # fmt: skip


def small(duration=0.4, noise="consumer", latency=0.0, detector=None, width=320, height=180):
    plan = FlightPlan(kind="orbit", duration_s=duration, height_m=6.0)
    return Experiment(
        GeneratedFlight(plan, 3),
        default_camera(width, height),
        sensor_plan(noise),
        CameraClock(latency_s=latency),
        robots=2,
        detector=detector or DetectorPlan(),
        seed=3,
    )


def read(path):
    """All messages by topic as (log time, message), read with rosbags itself."""
    from rosbags.rosbag2 import Reader

    found = {}
    with Reader(path) as reader:
        last = 0
        for connection, log_ns, data in reader.messages():
            assert log_ns >= last
            last = log_ns
            message = typestore().deserialize_cdr(data, connection.msgtype)
            found.setdefault(connection.topic, []).append((log_ns, message))
    return found


def digest(path):
    files = sorted(file for file in path.rglob("*") if file.is_file())
    return [(f.name, hashlib.sha256(f.read_bytes()).hexdigest()) for f in files]


@pytest.fixture(scope="module")
def rendered(tmp_path_factory):
    path = tmp_path_factory.mktemp("bags") / "one" / "flight"
    write_bag(path, small(), demo_scene(3), scenario={"a": 1}, workers=0)
    return path


def test_a_rendered_bag_has_images_telemetry_and_truth(rendered):
    found = read(rendered)
    assert set(found) == TELEMETRY | TRUTH | {"/camera/image_raw/compressed", "/truth/labels"}
    assert json.loads(found["/truth/scenario"][0][1].data) == {"a": 1}
    images = found["/camera/image_raw/compressed"]
    assert [nanoseconds(m.header.stamp) - START_NS for _, m in images] == [
        0, 100_000_000, 200_000_000, 300_000_000,
    ]  # fmt: skip
    for log_ns, message in images:
        assert log_ns - nanoseconds(message.header.stamp) == 80_000_000
        image = cv2.imdecode(message.data, cv2.IMREAD_COLOR)
        assert image.shape == (180, 320, 3)
        assert image.std() > 2.0
    infos = [nanoseconds(m.header.stamp) for _, m in found["/camera/camera_info"]]
    assert infos == [nanoseconds(m.header.stamp) for _, m in images]
    assert {m.header.frame_id for _, m in images} == {"camera"}


def test_true_boxes_in_the_bag_surround_the_projected_robots(rendered):
    """From the bag alone: true pose and true robot, projected, lie in the box of that name."""
    made = small()
    found = read(rendered)
    by_stamp = {frame.stamp_ns: frame for frame in made.frames()}
    count = 0
    for _, message in found["/truth/detections"]:
        frame = by_stamp[nanoseconds(message.header.stamp)]
        boxes = canonical.detection_frame(message)
        names = [detection.id for detection in message.detections]
        for name, center, size in zip(names, boxes.centers, boxes.sizes, strict=True):
            index = made.swarm.names.index(name)
            body = made.swarm.positions([frame.t])[index]
            pixel, _ = project_points(made.camera, frame.pose, body)
            assert (np.abs(pixel[0] - center) < 0.35 * size + 1.0).all()
            count += 1
    assert count >= 6


def test_labels_tell_of_all_robots_in_an_image_and_boxes_of_the_clear_ones(rendered):
    found = read(rendered)
    labels = [json.loads(message.data) for _, message in found["/truth/labels"]]
    boxes = [message for _, message in found["/truth/detections"]]
    assert [one["stamp_ns"] for one in labels] == [nanoseconds(m.header.stamp) for m in boxes]
    clear = 0
    for reported, message in zip(labels, boxes, strict=True):
        robots = {robot["robot_id"]: robot for robot in reported["robots"]}
        for box in message.detections:
            robot = robots[box.id]
            assert robot["contrast"] >= 0.06
            assert robot["visible"] >= 0.5
            u = (robot["left"] + robot["right"]) / 2
            assert box.bbox.center.position.x == pytest.approx(u, abs=0.011)  # rounded
            clear += 1
    assert clear == sum(
        robot["contrast"] >= 0.06 and robot["visible"] >= 0.5
        for reported in labels for robot in reported["robots"]
    ) > 5  # fmt: skip


def test_telemetry_is_late_by_its_latency_and_truth_at_once(rendered):
    found = read(rendered)
    for topic, delay in (("/fix", 0.05), ("/attitude", 0.01), ("/gimbal", 0.02), ("/truth/fix", 0)):
        late = {log_ns - nanoseconds(m.header.stamp) for log_ns, m in found[topic]}
        assert late == {round(delay * 1e9)}, topic
    heights = dict(found["/truth/height"])
    assert {log_ns - 20_000_000 for log_ns, _ in found["/height"]} == set(heights)


def test_the_same_seed_gives_the_same_bytes_in_any_number_of_processes(rendered, tmp_path):
    again = tmp_path / "two" / "flight"
    write_bag(again, small(), demo_scene(3), scenario={"a": 1}, workers=2)
    assert digest(again) == digest(rendered)


def test_raw_images_are_in_a_compressed_bag(tmp_path):
    path = tmp_path / "flight"
    write_bag(path, small(duration=0.1), demo_scene(3), images="raw", workers=0)
    ((_, message),) = read(path)["/camera/image_raw"]
    assert (message.width, message.height, message.step, message.encoding) == (
        320, 180, 960, "bgr8",
    )  # fmt: skip
    assert len(message.data) == 960 * 180
    (file,) = path.glob("*.mcap")
    assert b"zstd" in file.read_bytes()  # the name of the chunks' compression


def test_without_images_the_bag_holds_simulated_detections(tmp_path):
    made = small(duration=5.0, detector=DetectorPlan(center_px=0.0), latency=0.2)
    write_bag(tmp_path / "flight", made, None)
    found = read(tmp_path / "flight")
    assert set(found) == TELEMETRY | TRUTH | {"/detections"}
    assert len(found["/detections"]) == 50
    for (_, detections), (_, truth) in zip(
        found["/detections"], found["/truth/detections"], strict=True
    ):
        got, true = canonical.detection_frame(detections), canonical.detection_frame(truth)
        assert sorted(map(tuple, got.centers)) == sorted(map(tuple, true.centers))
        assert set(got.class_ids) <= {"aqua"}
    (name, path), *_ = made.robot_fixes()
    recorded = [
        canonical.fix(m, nanoseconds(m.header.stamp)) for _, m in found[f"/truth/robots/{name}/fix"]
    ]
    np.testing.assert_allclose(
        [f.latitude for f in recorded], [f.latitude for f in path], atol=1e-15
    )


def fail_after_ten(error):
    """A BagWriter.write that fails as a full disk would."""
    original, count = BagWriter.write, iter(range(100_000))

    def write(self, *args, **kwargs):
        if next(count) > 10:
            raise error
        return original(self, *args, **kwargs)

    return write


def test_a_full_disk_or_an_interrupt_leaves_nothing(tmp_path, monkeypatch):
    full = OSError(errno.ENOSPC, "No space left on device")
    for error, raised in ((full, OutputError), (KeyboardInterrupt(), KeyboardInterrupt)):
        with monkeypatch.context() as patch:
            patch.setattr(BagWriter, "write", fail_after_ten(error))
            with pytest.raises(raised):
                write_bag(tmp_path / "flight", small(), None)
        assert list(tmp_path.iterdir()) == []


def test_an_existing_bag_is_kept(tmp_path):
    kept = tmp_path / "flight"
    kept.mkdir()
    (kept / "mine").write_text("precious")
    with pytest.raises(OutputError, match="exists already"):
        write_bag(kept, small(), None)
    assert (kept / "mine").read_text() == "precious"
