# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Frames of a recording, copied to a folder once, and what is computed from them when needed."""

from __future__ import annotations

import json
from collections import OrderedDict
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.bags.partial import partial
from aerial_gnss_ros.bags.pictures import Source
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.images import read_image, write_jpeg
from aerial_gnss_ros.detection.outline import outlined
from aerial_gnss_ros.teaching.alignment import Transform, align, small
from aerial_gnss_ros.teaching.geometry import View, moved, view_of
from aerial_gnss_ros.teaching.proposals import Proposals, Proposer, clutter, looks

Array = NDArray[np.float64]

FOLDER, INDEX = "frames", "frames.json"
QUALITY = 95
INTERVAL_S = 0.5
"""Assumed between image files, which have no times."""
IN_MEMORY = 24
GEOMETRIC_SIGMA = 0.006
"""One sigma of positions moved by telemetry between two frames, share of the image's width."""
_METRE = 0.1  # m, over which the water is taken as seen in parallel perspective
_PROPOSALS = "proposals.npz"


def extract(
    source: Source,
    project: Path,
    most: int,
    views: Callable[[Sequence[int]], list[View | None]],
    report: Callable[[int], None],
) -> list[str]:
    """Copy frames of a recording into a project's folder.

    Args:
        source: of the images.
        project: folder, which exists.
        most: greatest number of frames; of more, every n-th is taken.
        views: returns the cameras at the stamps of images in a bag.
        report: called with the number of images read.

    Returns:
        Sentences on images that could not be read.

    Raises:
        InputError: no image can be read, or they differ in size.
    """
    every = max(1, -(-source.count // most))
    refused: dict[str, int] = {}
    entries: list[dict[str, Any]] = []
    size: tuple[int, int] | None = None
    with partial(project / FOLDER) as folder:
        folder.mkdir()
        for number, picture in enumerate(source.pictures()):
            report(number + 1)
            if number % every:
                continue
            try:
                image = picture.read()
            except InputError as error:
                refused[str(error)] = refused.get(str(error), 0) + 1
                continue
            own = (image.shape[1], image.shape[0])
            if size is None:
                size = own
            elif own != size:
                raise InputError(
                    f"{picture.name} has {own[0]}x{own[1]} px, but images before it "
                    f"{size[0]}x{size[1]}; give images of one camera and zoom setting."
                )
            file = f"{len(entries):06d}.jpg"
            write_jpeg(folder / file, image, QUALITY)
            stamp = picture.stamp_ns
            entries.append({"file": file, "name": picture.name, "stamp_ns": stamp})
        if size is None:
            raise InputError(next(iter(refused), f"{source.name} has no images."))
        stamps = [one["stamp_ns"] for one in entries]
        cameras = views(stamps) if None not in stamps else [None] * len(entries)
        for entry, view in zip(entries, cameras, strict=True):
            entry["view"] = None if view is None else view.as_dict()
        index = {"recording": source.name, "size": size, "frames": entries}
        (folder / INDEX).write_text(json.dumps(index), encoding="utf-8")
    return [f"{count} not read: {why}" for why, count in refused.items()]


class Recording:
    """The frames of a project.

    Args:
        project: folder in which `extract` has written frames.

    Attributes:
        name: of the recording.
        size: width and height of the images, px.
        names: of the images.
        files: of the frames.
        views: cameras; None where they are unknown.

    Raises:
        InputError: the folder is damaged.
    """

    def __init__(self, project: Path) -> None:
        self._folder = project / FOLDER
        self._project = project
        index = _read_index(self._folder / INDEX)
        entries = index["frames"]
        self.name: str = index["recording"]
        self.size: tuple[int, int] = (int(index["size"][0]), int(index["size"][1]))
        self.names = [str(one["name"]) for one in entries]
        self.files = [self._folder / str(one["file"]) for one in entries]
        self.views = [view_of(one["view"]) for one in entries]
        stamps = [one["stamp_ns"] for one in entries]
        self._times = (
            [INTERVAL_S * i for i in range(len(entries))]
            if None in stamps
            else [1e-9 * (stamp - stamps[0]) for stamp in stamps]
        )
        self._proposals: list[Proposals] | None = None
        self._images: OrderedDict[int, Image] = OrderedDict()
        self._outlines: dict[tuple[int, ...], Array | None] = {}
        self._looks: dict[tuple[int, ...], Array] = {}
        self._clutter: dict[tuple[int, ...], float] = {}
        self._steps: dict[int, Transform] = {}

    def __len__(self) -> int:
        return len(self.files)

    @property
    def posed(self) -> int:
        """Number of frames whose camera is known."""
        return sum(view is not None for view in self.views)

    def time(self, index: int) -> float:
        """Return a frame's time since the first, s."""
        return self._times[index]

    def image(self, index: int) -> Image:
        """Return a frame's image."""
        if index not in self._images:
            self._images[index] = read_image(self.files[index])
            if len(self._images) > IN_MEMORY:
                self._images.popitem(last=False)
        return self._images[index]

    def prepare(self, report: Callable[[int], None]) -> list[Proposals]:
        """Return what stands out in all frames: found now, or read where it was found before."""
        path = self._project / _PROPOSALS
        found = _read_proposals(path, len(self))
        if found is None:
            proposer, found = Proposer(), []
            for index in range(len(self)):
                found.append(proposer.propose(self.image(index)))
                report(index + 1)
            _write_proposals(path, found)
        self._proposals = found
        return found

    def proposals(self, index: int) -> Proposals:
        """Return what stands out in a frame."""
        if self._proposals is None:
            self._proposals = self.prepare(lambda _done: None)
        return self._proposals[index]

    def outline(self, index: int, box: Array) -> Array | None:
        """Return the box (4,) of what a rough box touches in a frame; None: nothing."""
        key = (index, *(int(value) for value in np.round(box)))
        if key not in self._outlines:
            self._outlines[key] = outlined(self.image(index), box)
        return self._outlines[key]

    def look(self, index: int, box: Array) -> Array:
        """Return the colours (k,) in a box of a frame, see `proposals.looks`."""
        key = (index, *(int(value) for value in np.round(box)))
        if key not in self._looks:
            self._looks[key] = looks(self.image(index), box[None])[0]
        return self._looks[key]

    def clutter(self, index: int, box: Array) -> float:
        """Return the share of the pixels round a box that are no water."""
        key = (index, *(int(value) for value in np.round(box)))
        if key not in self._clutter:
            self._clutter[key] = clutter(self.image(index), box)
        return self._clutter[key]

    def plane(self, index: int, point: Array) -> Array:
        """Return the pixels (2, 2) of a metre to the East and North; the identity if unknown."""
        view = self.views[index]
        if view is None:
            return np.eye(2)
        place = view.place(point[None])
        pixels = view.pixel(
            place + _METRE * np.array([[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]])
        )
        plane = np.asarray((pixels[1::2] - pixels[::2]).T / (2.0 * _METRE))
        return plane if np.isfinite(plane).all() else np.eye(2)

    def motion(self, first: int, second: int, points: Array) -> tuple[Array, float]:
        """Return where points (n, 2) px of one frame are in another, and one sigma, px."""
        by_water = moved(self.views, first, second, points)
        if by_water is not None:
            return by_water, GEOMETRIC_SIGMA * self.size[0]
        variance, step = 0.0, 1 if second > first else -1
        for index in range(first, second, step):
            transform = self._step(min(index, index + step))
            transform = transform if step > 0 else transform.inverse
            points = transform.move(points)
            variance += transform.sigma**2
        return points, float(np.sqrt(variance))

    def _step(self, index: int) -> Transform:
        """Return the image's motion from one frame to the next."""
        if index not in self._steps:
            smalls = small(self.image(index)), small(self.image(index + 1))
            one, two = self.proposals(index), self.proposals(index + 1)
            self._steps[index] = align(one, two, self.size[0], smalls)
        return self._steps[index]


def _read_index(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        whole = bool(content["frames"]) and len(content["size"]) == 2
    except (OSError, ValueError, KeyError, TypeError):
        whole = False
    if not whole:
        raise InputError(f"{path} is damaged or missing; give another folder.")
    return dict(content)


def _write_proposals(path: Path, found: Sequence[Proposals]) -> None:
    hidden = path.with_name(f".{path.name}.partial")
    counts = np.array([len(one.boxes) for one in found])
    with hidden.open("wb") as file:
        np.savez_compressed(
            file,
            counts=counts,
            boxes=np.concatenate([one.boxes for one in found]),
            looks=np.concatenate([one.looks for one in found]),
        )
    hidden.replace(path)


def _read_proposals(path: Path, count: int) -> list[Proposals] | None:
    """Return what was found before; None if there is nothing of these frames."""
    try:
        with np.load(path) as content:
            counts, boxes, colours = content["counts"], content["boxes"], content["looks"]
    except (OSError, ValueError, KeyError, EOFError):
        return None
    if len(counts) != count or counts.sum() != len(boxes):
        return None
    ends = np.cumsum(counts)[:-1]
    parts = zip(np.split(boxes, ends), np.split(colours, ends), strict=True)
    return [Proposals(own, look) for own, look in parts]
