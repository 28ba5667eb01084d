# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads rosbag2 (mcap, sqlite3) and ROS 1 bags, one or several that belong together."""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any

from rosbags.interfaces import Connection, ConnectionExtRosbag2, Qos
from rosbags.rosbag1 import Reader as Reader1
from rosbags.rosbag2 import Reader as Reader2

from aerial_gnss_ros.adapters.yaml_files import check_depth
from aerial_gnss_ros.bags.definitions import Definitions
from aerial_gnss_ros.core.values.errors import InputError

if TYPE_CHECKING:
    from typing_extensions import Self

BAG_ENDINGS = (".mcap", ".db3", ".bag")
_KINDS = "a rosbag2 folder, an .mcap, .db3 or ROS 1 .bag file"


@dataclass(frozen=True)
class Topic:
    """A recorded topic.

    Attributes:
        name: absolute, such as `/drone1/fix`.
        msgtype: such as `sensor_msgs/msg/NavSatFix`; «A and B» where bags disagree.
        count: number of messages.
        qos: as offered by the publishers; empty if the bag has none.
    """

    name: str
    msgtype: str
    count: int
    qos: tuple[Qos, ...] = ()


@dataclass(frozen=True)
class Recorded:
    """A recorded message.

    Attributes:
        topic: absolute name.
        msgtype: such as `sensor_msgs/msg/NavSatFix`.
        log_ns: time at which the recorder received it, ns.
        raw: the serialised message: CDR, or ROS 1's form.
    """

    topic: str
    msgtype: str
    log_ns: int
    raw: bytes
    _bag: _Bag
    _connection: Connection

    @property
    def path(self) -> Path:
        """The bag that it is from."""
        return self._bag.path

    def message(self) -> Any:
        """Return the message, with the same attributes as rclpy's.

        Raises:
            InputError: the type is unknown, or the bytes do not match it.
        """
        return self._bag.decode(self._connection, self.raw, self.log_ns)


_MOST_NAMED = 5  # bags in a folder
_MOST_METADATA = 50_000_000  # bytes; a bag split into thousands of files has megabytes


class _Bag:
    """One bag of ROS 1 or ROS 2."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.definitions = Definitions()
        with _bag_errors(path):
            if (metadata := path / "metadata.yaml").is_file():
                check_depth(metadata, _MOST_METADATA)  # rosbags is slow with such a file
            if path.suffix == ".bag":
                self.reader: Reader1 | Reader2 = Reader1(path)
            else:
                self.reader = Reader2(path)

    def decode(self, connection: Connection, raw: bytes, log_ns: int) -> Any:
        store = self.definitions.store(connection)
        if store is None:
            raise InputError(
                f"{self.path}: topic {connection.topic} has message type {connection.msgtype}, "
                "which neither the bag nor this program describes; record it as mcap, which "
                "keeps the definitions, or convert it to a canonical topic."
            )
        try:
            if isinstance(self.reader, Reader1):
                return store.deserialize_ros1(raw, connection.msgtype)
            return store.deserialize_cdr(raw, connection.msgtype)
        except Exception as error:  # generated code raises arbitrary exceptions on damaged bytes
            raise InputError(
                f"{self.path}: a message of {connection.topic} ({connection.msgtype}) at "
                f"{log_ns} ns cannot be read ({error}); the bag is damaged."
            ) from error

    def messages(
        self, topics: Collection[str] | None, start_ns: int | None, stop_ns: int | None
    ) -> Iterator[Recorded]:
        chosen = [c for c in self.reader.connections if topics is None or c.topic in topics]
        if not chosen:
            return
        with _bag_errors(self.path):
            for connection, log_ns, raw in self.reader.messages(
                connections=chosen, start=start_ns, stop=stop_ns
            ):
                yield Recorded(
                    connection.topic, connection.msgtype, log_ns, bytes(raw), self, connection
                )


class BagReader:
    """Recorded messages in the order in which they were received; use as a context manager.

    Args:
        paths: the bags; several are merged by the time of recording.

    Raises:
        InputError: a path is missing (all missing ones are named), not a bag, or damaged.
    """

    def __init__(self, paths: Sequence[Path]) -> None:
        self.paths = list(paths)
        self.topics: dict[str, Topic] = {}
        self._stack = ExitStack()
        self._bags: list[_Bag] = []
        _check_paths(self.paths)

    def __enter__(self) -> Self:
        """Open all bags."""
        with ExitStack() as stack:
            for path in self.paths:
                bag = _Bag(path)
                with _bag_errors(path):
                    stack.enter_context(bag.reader)
                self._bags.append(bag)
            self._stack = stack.pop_all()
        self.topics = dict(sorted(_topics(self._bags).items()))
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close all bags."""
        self._bags.clear()
        self._stack.__exit__(kind, error, trace)

    @property
    def message_count(self) -> int:
        """Number of messages on all topics."""
        return sum(topic.count for topic in self.topics.values())

    @property
    def start_ns(self) -> int:
        """Time of the first message, ns; 0 without messages."""
        return min((b.reader.start_time for b in self._bags if b.reader.message_count), default=0)

    @property
    def end_ns(self) -> int:
        """Time just after the last message, ns; 0 without messages."""
        return max((b.reader.end_time for b in self._bags if b.reader.message_count), default=0)

    @property
    def spans(self) -> dict[Path, tuple[int, int]]:
        """Times of the first message and just after the last one of each bag that has any, ns."""
        readers = {bag.path: bag.reader for bag in self._bags if bag.reader.message_count}
        return {path: (one.start_time, one.end_time) for path, one in readers.items()}

    def messages(
        self,
        topics: Collection[str] | None = None,
        start_ns: int | None = None,
        stop_ns: int | None = None,
    ) -> Iterator[Recorded]:
        """Yield messages in the order of recording; at equal times, in the order of the bags.

        Args:
            topics: absolute names; None for all.
            start_ns: log time of the first message, ns; None: from the beginning.
            stop_ns: log time before which all are, ns; None: to the end.

        Raises:
            InputError: a bag is damaged.
        """
        if len(self._bags) == 1:
            yield from self._bags[0].messages(topics, start_ns, stop_ns)
            return
        yield from heapq.merge(
            *(bag.messages(topics, start_ns, stop_ns) for bag in self._bags),
            key=lambda recorded: recorded.log_ns,
        )


def open_bag(paths: str | Path | Sequence[str | Path]) -> BagReader:
    """Return a reader of one bag, or of several that belong together.

    Args:
        paths: rosbag2 folders, or files .mcap, .db3 or (ROS 1) .bag.

    Raises:
        InputError: a path is missing (all missing ones are named) or is not a bag.
    """
    several = [paths] if isinstance(paths, str | Path) else paths
    return BagReader([Path(path) for path in several])


def _check_paths(paths: Sequence[Path]) -> None:
    if not paths:
        raise InputError(f"no bag given; give {_KINDS}.")
    missing = [str(path) for path in paths if not path.exists()]
    if missing:
        are = "does" if len(missing) == 1 else "do"
        raise InputError(f"{', '.join(missing)} {are} not exist; give {_KINDS}.")
    for path in paths:
        if path.is_dir() and not (path / "metadata.yaml").is_file():
            why = "the folder has no metadata.yaml"
            raise InputError(f"{path} is not a bag: {why}. {_inside(path)}")
        if path.is_file() and path.suffix not in BAG_ENDINGS:
            raise InputError(f"{path} is not a bag; give {_KINDS}.")
    seen = [path.resolve() for path in paths]
    twice = sorted({str(path) for path in seen if seen.count(path) > 1})
    if twice:
        raise InputError(f"{', '.join(twice)} is given twice; give each bag once.")


def _inside(folder: Path) -> str:
    """Return which bags a folder that is none holds."""
    bags = sorted(
        str(one)
        for one in folder.iterdir()
        if (one / "metadata.yaml").is_file() or (one.is_file() and one.suffix in BAG_ENDINGS)
    )
    if not bags:
        return "Nothing in it is a bag either."
    shown = ", ".join(bags[:_MOST_NAMED]) + (", …" if len(bags) > _MOST_NAMED else "")
    return f"It holds {shown}: give these, or those of one flight."


def _topics(bags: Sequence[_Bag]) -> dict[str, Topic]:
    topics: dict[str, Topic] = {}
    for bag in bags:
        for connection in bag.reader.connections:
            known = topics.get(connection.topic)
            types = {connection.msgtype} | (set(known.msgtype.split(" and ")) if known else set())
            offered = (
                tuple(connection.ext.offered_qos_profiles)
                if isinstance(connection.ext, ConnectionExtRosbag2)
                else ()
            )
            topics[connection.topic] = Topic(
                connection.topic,
                " and ".join(sorted(types)),
                connection.msgcount + (known.count if known else 0),
                known.qos if known and known.qos else offered,
            )
    return topics


@contextmanager
def _bag_errors(path: Path) -> Iterator[None]:
    """Convert a parser's exception into one sentence."""
    try:
        yield
    except InputError:
        raise
    except Exception as error:  # parsers raise arbitrary exceptions on damaged bytes
        reason = " ".join(str(error).split())[:200].rstrip(".") or type(error).__name__
        recover = {
            ".mcap": "; if the recording was cut off, `mcap recover` may recover the undamaged "
            "part",
            ".bag": "; if the recording was cut off, `rosbag reindex` may recover the undamaged "
            "part",
        }.get(path.suffix, "")
        raise InputError(
            f"{path} cannot be read as a bag; it is truncated or damaged ({reason}){recover}."
        ) from error
