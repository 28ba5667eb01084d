# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images from any source: image files, folders, videos, bags."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.bags.plan import COMPRESSED, IMAGE
from aerial_gnss_ros.bags.reader import BAG_ENDINGS, Recorded, open_bag
from aerial_gnss_ros.bags.video import open_video
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.image_header import MAX_PIXELS
from aerial_gnss_ros.detection.images import decode, read_image

IMAGE_ENDINGS = (".jpg", ".jpeg", ".png", ".bmp", ".webp", ".tif", ".tiff")
_KINDS = "images, a folder, a video or a bag"


@dataclass(frozen=True)
class Picture:
    """One image, not yet read.

    Attributes:
        name: of its file, or a file name for it.
        stamp_ns: its stamp in a bag, its time in a video; None of an image file.
        read: returns (height, width, 3) blue, green, red; InputError if it is not an image.
    """

    name: str
    stamp_ns: int | None
    read: Callable[[], Image]


@dataclass(frozen=True)
class Source:
    """Images of one source.

    Attributes:
        name: of the file or folder.
        count: number of images.
        pictures: yields them in order.
        rate_hz: of a video; 0 of anything else.
    """

    name: str
    count: int
    pictures: Callable[[], Iterator[Picture]]
    rate_hz: float = 0.0


def open_pictures(path: Path, max_pixels: int = MAX_PIXELS) -> Source:
    """Open an image, a folder of images, a video or a bag.

    Args:
        path: the file or folder.
        max_pixels: larger images are refused when they are read.

    Raises:
        InputError: no such path, or no image in it.
    """
    if path.is_dir():
        if (path / "metadata.yaml").is_file():
            return _bag(path, max_pixels)
        return _folder(path, max_pixels)
    if not path.exists():
        raise InputError(f"{path} does not exist; give {_KINDS}.")
    if not path.is_file():
        raise InputError(f"{path} is a device or a pipe, not a file; give {_KINDS}.")
    ending = path.suffix.lower()
    if ending in BAG_ENDINGS:
        return _bag(path, max_pixels)
    if ending in IMAGE_ENDINGS:
        return _files(path.name, [path], path.parent, max_pixels)
    return _video(path)


def _folder(path: Path, max_pixels: int) -> Source:
    files = sorted(file for file in path.iterdir() if file.suffix.lower() in IMAGE_ENDINGS)
    if not files:
        raise InputError(f"{path} has no images ({', '.join(IMAGE_ENDINGS)}) and is not a bag.")
    return _files(path.name, files, path, max_pixels)


def _files(name: str, files: Sequence[Path], root: Path, max_pixels: int) -> Source:
    def pictures() -> Iterator[Picture]:
        for file in files:
            yield Picture(str(file.relative_to(root)), None, partial(read_image, file, max_pixels))

    return Source(name, len(files), pictures)


def _video(path: Path) -> Source:
    video = open_video(path)

    def pictures() -> Iterator[Picture]:
        for number, (seconds, image) in enumerate(video.frames()):
            stamp_ns = round(seconds * 1e9)
            yield Picture(f"{path.stem}_{number:06d}.jpg", stamp_ns, partial(_same, image))

    return Source(path.name, video.count, pictures, video.rate_hz)


def _same(image: Image) -> Image:
    return image


def _bag(path: Path, max_pixels: int) -> Source:
    with open_bag(path) as bag:
        found = {
            name: topic.count
            for name, topic in bag.topics.items()
            if topic.msgtype in (IMAGE, COMPRESSED) and topic.count
        }
    if not found:
        raise InputError(f"{path} has no images; it may be a simulated flight with boxes only.")
    if len(found) > 1:
        raise InputError(
            f"{path} has images on several topics ({', '.join(found)}); give a bag with one of "
            "them."
        )
    ((topic, count),) = found.items()

    def pictures() -> Iterator[Picture]:
        with open_bag(path) as bag:
            for recorded in bag.messages([topic]):
                yield _recorded(recorded, max_pixels)

    return Source(path.name, count, pictures)


def _recorded(recorded: Recorded, max_pixels: int) -> Picture:
    message = recorded.message()
    stamp_ns = nanoseconds(message.header.stamp)
    return Picture(f"{stamp_ns}.jpg", stamp_ns, partial(decode, message, max_pixels))
