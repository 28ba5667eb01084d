# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Bags of both generations, alone and together, whole and broken."""

from __future__ import annotations

import sqlite3
from contextlib import closing

import numpy as np
import pytest
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.writer import SENSOR, BagWriter
from aerial_gnss_ros.core.values.errors import InputError

FLOAT = "std_msgs/msg/Float64"


def write_floats(path, topic, log_times, **options):
    with BagWriter(path, **options) as bag:
        for time in log_times:
            bag.write(topic, FLOAT, time, {"data": float(time)}, SENSOR)
    return path


def read_all(paths, topics=None):
    with open_bag(paths) as bag:
        return [(m.topic, m.log_ns, m.message().data) for m in bag.messages(topics)]


def write_ros1(path):
    store = get_typestore(Stores.ROS1_NOETIC)
    header = store.types["std_msgs/msg/Header"]
    time = store.types["builtin_interfaces/msg/Time"]
    info = store.types["sensor_msgs/msg/CameraInfo"]
    region = store.types["sensor_msgs/msg/RegionOfInterest"](0, 0, 0, 0, False)
    message = info(
        header(9, time(5, 6), "camera"), 480, 640, "plumb_bob", np.zeros(5), np.arange(9.0),
        np.eye(3).ravel(), np.zeros(12), 0, 0, region,
    )  # fmt: skip
    with Writer1(path) as writer:
        connection = writer.add_connection(
            "/camera/camera_info", "sensor_msgs/msg/CameraInfo", typestore=store
        )
        raw = store.serialize_ros1(message, "sensor_msgs/msg/CameraInfo")
        writer.write(connection, 5_000_000_007, raw)
    return path


def test_several_bags_are_merged_in_the_order_of_recording(tmp_path):
    a = write_floats(tmp_path / "a", "height", [10, 30, 50])
    b = write_floats(tmp_path / "b", "water_level", [20, 30, 60], compress=True)
    assert read_all([a, b]) == [
        ("/height", 10, 10.0), ("/water_level", 20, 20.0), ("/height", 30, 30.0),
        ("/water_level", 30, 30.0), ("/height", 50, 50.0), ("/water_level", 60, 60.0),
    ]  # fmt: skip
    assert [row[0] for row in read_all([a, b], {"/height"})] == ["/height"] * 3
    with open_bag([a, b]) as bag:
        assert {t.name: (t.msgtype, t.count) for t in bag.topics.values()} == {
            "/height": (FLOAT, 3),
            "/water_level": (FLOAT, 3),
        }
        assert (bag.start_ns, bag.end_ns, bag.message_count) == (10, 61, 6)


def test_a_file_inside_the_folder_and_the_folder_are_the_same(tmp_path):
    folder = write_floats(tmp_path / "a", "height", [10, 30])
    assert read_all(folder / "a.mcap") == read_all(folder)


def test_sqlite_without_definitions_is_read_with_the_common_types(tmp_path):
    with Writer(tmp_path / "a", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        store = get_typestore(Stores.ROS2_HUMBLE)
        connection = writer.add_connection("/height", FLOAT, typestore=store)
        message = store.types[FLOAT](4.5)
        writer.write(connection, 7, store.serialize_cdr(message, FLOAT))
    assert read_all(tmp_path / "a") == [("/height", 7, 4.5)]


def test_a_type_that_only_the_bag_describes_is_read(tmp_path):
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg("float32 depth\nstring[] names", "acme_msgs/msg/Sonar"))
    with Writer(tmp_path / "a", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/sonar", "acme_msgs/msg/Sonar", typestore=store)
        message = store.types["acme_msgs/msg/Sonar"](2.5, ["x"])
        writer.write(connection, 7, store.serialize_cdr(message, "acme_msgs/msg/Sonar"))
    with open_bag(tmp_path / "a") as bag:
        [recorded] = bag.messages()
        assert (recorded.message().depth, recorded.message().names) == (2.5, ["x"])


def test_a_ros_1_bag_is_read_with_its_own_definitions(tmp_path):
    with open_bag(write_ros1(tmp_path / "a.bag")) as bag:
        [recorded] = bag.messages()
        info = recorded.message()
    assert recorded.log_ns == 5_000_000_007
    assert (info.header.stamp.sec, info.header.stamp.nanosec, info.width) == (5, 6, 640)
    np.testing.assert_array_equal(info.K, np.arange(9.0))


def test_every_missing_path_is_named(tmp_path):
    here = write_floats(tmp_path / "a", "height", [1])
    with pytest.raises(InputError, match=r"no_1, .*no_2 do not exist; give a rosbag2 folder"):
        open_bag([tmp_path / "no_1", here, tmp_path / "no_2"])


def test_what_is_not_a_bag_is_refused(tmp_path):
    (tmp_path / "notes.txt").write_text("hello")
    (tmp_path / "folder").mkdir()
    (tmp_path / "empty.mcap").write_bytes(b"")
    (tmp_path / "text.bag").write_text("hello")
    with pytest.raises(InputError, match=r"notes.txt is not a bag; give a rosbag2 folder"):
        open_bag(tmp_path / "notes.txt")
    with pytest.raises(InputError, match=r"folder is not a bag: the folder has no metadata"):
        open_bag(tmp_path / "folder")
    for name in "ab":
        (tmp_path / f"folder/{name}").mkdir()
        (tmp_path / f"folder/{name}/metadata.yaml").write_text("")
    (tmp_path / "folder/c.mcap").write_text("")
    with pytest.raises(InputError, match=r"It holds .*folder/a, .*folder/b, .*folder/c.mcap: give"):
        open_bag(tmp_path / "folder")
    with pytest.raises(InputError, match=r"is given twice"):
        open_bag([tmp_path / "text.bag", tmp_path / "text.bag"])
    for name in ("empty.mcap", "text.bag"):
        with (
            pytest.raises(InputError, match=rf"{name} cannot be read as a bag; it is truncated"),
            open_bag(tmp_path / name),
        ):
            pass


@pytest.mark.parametrize("kept", [0.0, 0.3, 0.6, 0.9, 0.99])
@pytest.mark.parametrize("kind", ["mcap", "db3", "bag"])
def test_a_truncated_bag_is_one_sentence(tmp_path, kind, kept):
    if kind == "bag":
        target = file = write_ros1(tmp_path / "a.bag")
    elif kind == "mcap":
        target = write_floats(tmp_path / "a", "height", range(5000))
        file = target / "a.mcap"
    else:
        target = file = tmp_path / "a" / "a.db3"
        with Writer(tmp_path / "a", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
            store = get_typestore(Stores.ROS2_HUMBLE)
            connection = writer.add_connection("/height", FLOAT, typestore=store)
            for i in range(5000):
                writer.write(connection, i, store.serialize_cdr(store.types[FLOAT](4.5), FLOAT))
    content = file.read_bytes()
    file.write_bytes(content[: int(len(content) * kept)])
    with pytest.raises(InputError, match=r"cannot be read as a bag; it is truncated or damaged"):
        read_all(target)


def test_damaged_content_is_one_sentence(tmp_path):
    file = write_floats(tmp_path / "a", "height", range(100)) / "a.mcap"
    content = bytearray(file.read_bytes())
    content[1000:1200] = b"\xff" * 200
    file.write_bytes(content)
    with pytest.raises(InputError, match="damaged"):
        read_all(tmp_path / "a")


def test_metadata_that_nests_deep_is_refused_before_it_is_parsed(tmp_path):
    (tmp_path / "metadata.yaml").write_text("a: 1\nb: " + "[" * 5000, encoding="utf-8")
    with pytest.raises(InputError, match=r"metadata\.yaml: line 2 nests deeper than 32 levels"):
        open_bag(tmp_path).__enter__()


def test_an_unknown_type_is_named_when_it_is_read(tmp_path):
    # As Humble records: sqlite3 without definitions.
    with Writer(tmp_path / "a", version=8, storage_plugin=StoragePlugin.SQLITE3) as writer:
        store = get_typestore(Stores.ROS2_HUMBLE)
        connection = writer.add_connection("/sonar", FLOAT, typestore=store)
        writer.write(connection, 7, store.serialize_cdr(store.types[FLOAT](4.5), FLOAT))
    with closing(sqlite3.connect(tmp_path / "a/a.db3")) as base, base:
        base.execute("UPDATE topics SET type = 'acme_msgs/msg/Sonar'")
        base.execute("DELETE FROM message_definitions")
    metadata = tmp_path / "a/metadata.yaml"
    metadata.write_text(metadata.read_text().replace(FLOAT, "acme_msgs/msg/Sonar"))
    with open_bag(tmp_path / "a") as bag:
        [recorded] = bag.messages()
        with pytest.raises(InputError, match="topic /sonar has message type acme_msgs/msg/Sonar"):
            recorded.message()
