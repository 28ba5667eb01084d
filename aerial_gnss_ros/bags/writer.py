# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Writes rosbag2 folders (mcap), completely or not at all; the same input gives the same bytes."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, get_args

from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from aerial_gnss_ros.bags.partial import partial
from aerial_gnss_ros.bags.typestore import serialize, typestore
from aerial_gnss_ros.resources import ros_distribution

if TYPE_CHECKING:
    from typing_extensions import Self


def _qos(reliability: QosReliability, durability: QosDurability, depth: int) -> Qos:
    forever = QosTime(2147483647, 4294967295)  # how rosbag2 itself records «no limit»
    return Qos(
        QosHistory.KEEP_LAST,
        depth,
        reliability,
        durability,
        forever,
        forever,
        QosLiveliness.AUTOMATIC,
        forever,
        avoid_ros_namespace_conventions=False,
    )


SENSOR = _qos(QosReliability.BEST_EFFORT, QosDurability.VOLATILE, 10)
"""Offered by cameras and telemetry."""

RELIABLE = _qos(QosReliability.RELIABLE, QosDurability.VOLATILE, 10)
"""Offered for detections and truth."""

LATCHED = _qos(QosReliability.RELIABLE, QosDurability.TRANSIENT_LOCAL, 1)
"""Offered for results: late subscribers receive the last one."""


BagVersion = Literal[8, 9]
VERSIONS: tuple[BagVersion, ...] = get_args(BagVersion)


def bag_version() -> BagVersion:
    """Return the version of rosbag2's files that the ROS found here reads."""
    return 8 if ros_distribution() in ("humble", "iron") else 9


class BagWriter:
    """A new bag; use it as a context manager.

    Args:
        path: the bag's folder; must not exist. It appears when the block ends without error.
        compress: zstd compression of chunks; useless for JPEG images.
        namespace: of relative topics, such as `drone1`.
        version: of rosbag2's files: 9 for Jazzy and later, 8 for Humble and Iron, which cannot
            read the QoS of a 9; None: for the distribution that is found.

    Raises:
        OutputError: the folder exists already, cannot be written, or the disk is full.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        compress: bool = False,
        namespace: str = "",
        version: BagVersion | None = None,
    ) -> None:
        self.path = Path(path)
        self.counts: dict[str, int] = {}
        self._compress = compress
        self._version = bag_version() if version is None else version
        self._prefix = "/" + namespace.strip("/") + "/" if namespace.strip("/") else "/"
        self._stack = ExitStack()
        self._writer: Writer | None = None
        self._connections: dict[str, Connection] = {}

    def __enter__(self) -> Self:
        """Create the bag under its temporary name."""
        with ExitStack() as stack:
            temporary = stack.enter_context(partial(self.path))
            writer = Writer(temporary, version=self._version, storage_plugin=StoragePlugin.MCAP)
            if self._compress:
                writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
            self._writer = stack.enter_context(writer)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Give the bag its final name, or remove it if the block failed."""
        self._writer = None
        self._stack.__exit__(kind, error, trace)

    def write(
        self,
        topic: str,
        msgtype: str,
        log_ns: int,
        fields: Mapping[str, Any] | bytes,
        qos: Qos = RELIABLE,
    ) -> None:
        """Write one message.

        Args:
            topic: relative to the namespace, or absolute.
            msgtype: such as `sensor_msgs/msg/NavSatFix`.
            log_ns: time of its arrival, ns.
            fields: nested dicts in ROS field names, or the message as CDR bytes.
            qos: offered by its publisher; that of the topic's first message is recorded.

        Raises:
            InputError: unknown type or field.
            OutputError: the disk is full (raised at the end of the `with` block).
        """
        if self._writer is None:
            raise RuntimeError("BagWriter.write needs the writer's `with` block.")
        data = fields if isinstance(fields, bytes) else serialize(msgtype, fields)
        name = topic if topic.startswith("/") else self._prefix + topic
        if name not in self._connections:
            self._connections[name] = self._writer.add_connection(
                name, msgtype, typestore=typestore(), offered_qos_profiles=[qos]
            )
            self.counts[name] = 0
        self._writer.write(self._connections[name], log_ns, data)
        self.counts[name] += 1
