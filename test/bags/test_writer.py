# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Bags appear whole or not at all, with the same bytes for the same input."""

from __future__ import annotations

import errno

import pytest
from rosbags.highlevel import AnyReader
from rosbags.interfaces import QosDurability, QosReliability

from aerial_gnss_ros.bags.writer import LATCHED, BagWriter
from aerial_gnss_ros.core.values.errors import InputError, OutputError

HEIGHT = "std_msgs/msg/Float64"


def write_heights(path, count=3, **options):
    with BagWriter(path, **options) as bag:
        for i in range(count):
            bag.write("height", HEIGHT, 1_000_000_000 + i, {"data": 10.0 + i}, LATCHED)


@pytest.mark.parametrize("compress", [False, True])
def test_an_independent_reader_reads_back_what_was_written(tmp_path, compress):
    write_heights(tmp_path / "flight", compress=compress, namespace="drone1")
    with AnyReader([tmp_path / "flight"]) as reader:
        [connection] = reader.connections
        read = [(t, reader.deserialize(raw, c.msgtype).data) for c, t, raw in reader.messages()]
    assert connection.topic == "/drone1/height"
    assert read == [(1_000_000_000, 10.0), (1_000_000_001, 11.0), (1_000_000_002, 12.0)]
    [qos] = connection.ext.offered_qos_profiles
    assert (qos.durability, qos.reliability, qos.depth) == (
        QosDurability.TRANSIENT_LOCAL,
        QosReliability.RELIABLE,
        1,
    )
    assert [path.name for path in tmp_path.iterdir()] == ["flight"]
    assert sorted(p.name for p in (tmp_path / "flight").iterdir()) == [
        "flight.mcap",
        "metadata.yaml",
    ]


@pytest.mark.parametrize(
    ("distribution", "version", "reliability"),
    [("humble", 8, "reliability: 1"), ("jazzy", 9, "reliability: reliable")],
)
def test_a_bag_is_one_that_the_distribution_reads(
    tmp_path, monkeypatch, distribution, version, reliability
):
    """Humble reads QoS as numbers, and ends at words."""
    monkeypatch.setenv("ROS_DISTRO", distribution)
    write_heights(tmp_path / "own")
    monkeypatch.setenv("ROS_DISTRO", "other")
    write_heights(tmp_path / "asked", version=version)
    for name in ("own", "asked"):
        metadata = (tmp_path / name / "metadata.yaml").read_text()
        assert f"version: {version}" in metadata
        assert reliability in metadata
        with AnyReader([tmp_path / name]) as reader:
            assert sum(1 for _ in reader.messages()) == 3


def test_the_same_input_gives_the_same_bytes(tmp_path):
    for folder in ("a", "b"):
        write_heights(tmp_path / folder / "flight", compress=True)
    for name in ("flight.mcap", "metadata.yaml"):
        assert (tmp_path / "a/flight" / name).read_bytes() == (
            tmp_path / "b/flight" / name
        ).read_bytes()


def test_an_existing_folder_is_refused_and_left_alone(tmp_path):
    (tmp_path / "flight").mkdir()
    (tmp_path / "flight" / "precious").write_text("x")
    with pytest.raises(OutputError, match="flight exists already; choose another name"):
        write_heights(tmp_path / "flight")
    assert (tmp_path / "flight" / "precious").read_text() == "x"
    assert [path.name for path in tmp_path.iterdir()] == ["flight"]


@pytest.mark.parametrize("error", [ValueError("x"), KeyboardInterrupt()])
def test_an_error_leaves_nothing(tmp_path, error):
    def fail():
        with BagWriter(tmp_path / "flight") as bag:
            bag.write("height", HEIGHT, 1, {"data": 1.0})
            raise error

    with pytest.raises(type(error)):
        fail()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("when", ["write", "close"])
def test_a_full_disk_is_one_sentence_and_leaves_nothing(tmp_path, monkeypatch, when):
    def full(*_args):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(f"rosbags.rosbag2.storage_mcap.McapWriter.{when}", full)
    with pytest.raises(OutputError, match=r"the disk is full: .*flight could not be written"):
        write_heights(tmp_path / "flight")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match=r"file/flight cannot be written: "):
        write_heights(tmp_path / "file" / "flight")


def test_unknown_types_and_fields_are_refused(tmp_path):
    with (
        pytest.raises(InputError, match="message type px4_msgs/msg/SensorGps is unknown"),
        BagWriter(tmp_path / "flight") as bag,
    ):
        bag.write("gps", "px4_msgs/msg/SensorGps", 1, {})
    with (
        pytest.raises(InputError, match="std_msgs/msg/Float64 has no field value"),
        BagWriter(tmp_path / "flight") as bag,
    ):
        bag.write("height", HEIGHT, 1, {"value": 1.0})
    assert list(tmp_path.iterdir()) == []
