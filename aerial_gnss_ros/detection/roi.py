# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Follows the robots: looks closely where they must be, and at one part of the rest at a time.

A network's time grows with the pixels that it is shown, and a robot covers a thousandth of them. So
an image costs a window round each robot (or one for several that are close) and one part of a scan
that goes over the whole image every `search.scan_images` images: all images cost about the same,
and no slow one among them holds the others up. The whole image is looked at when nothing is
followed, and when a robot that was sure has not been found twice, nor any other now: the camera
jolted. Where others are still found, the scan goes faster once instead: the whole image would make
a live camera's next images wait or be dropped.
"""

from __future__ import annotations

import time

from aerial_gnss_ros.detection.base import Detections, Detector, Image
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.following import Follower
from aerial_gnss_ros.detection.pieces import Piece, detections
from aerial_gnss_ros.detection.second_look import SecondLook
from aerial_gnss_ros.detection.windowed import WindowedDetector
from aerial_gnss_ros.detection.windows import Window, around, split

_HURRIED = 2  # parts of the scan an image while a sure robot is missed
_WORTHWHILE = 0.6  # windows with more than this share of the image cost as much as all of it


class FollowingDetector(WindowedDetector):
    """A Detector that shows another one the parts of an image that matter.

    It expects the images of one flight in their order; what it finds in one depends on those
    before. Equal images give equal boxes.

    Args:
        inner: looks at what it is shown.
        config: how to search, the number of boxes, and with a second look their least score.
        second: looks again at what is found.
    """

    def __init__(
        self, inner: Detector, config: DetectorConfig, second: SecondLook | None = None
    ) -> None:
        super().__init__(inner, config, second)
        self._follower = Follower(config.search.margin)
        self._size = (0, 0)
        self._parts: list[Window] = []
        self._next = 0
        self._whole_wanted = False
        self._hurried = 0  # parts that are still to be looked at faster
        self._since_loss = 0

    @property
    def name(self) -> str:
        """The inner detector's, and how it is used."""
        scan = self._config.search.scan_images
        return f"{self._looking}, following the robots, the rest once in {scan} images"

    def detect(self, image: Image) -> Detections:
        """Return the boxes found in `image` (height, width, 3), blue, green, red."""
        started = time.perf_counter()
        self._take_size((image.shape[1], image.shape[0]))
        windows = self._windows()
        found, spent = self._look(image, windows)
        self._learn(found, whole=windows == [self._whole])
        # What an edge cuts is followed, and reported when it has been seen whole: its middle is
        # not the robot's.
        reported = [piece for piece in found if piece.whole]
        most = self._config.max_detections
        made = detections(reported, self.class_names, most, spent)
        rest = 1e3 * (time.perf_counter() - started) - sum(spent.values())
        spent["post"] = spent.get("post", 0.0) + rest
        return made

    @property
    def _whole(self) -> Window:
        return Window(0, 0, *self._size)

    def _take_size(self, size: tuple[int, int]) -> None:
        if size == self._size:
            return
        search = self._config.search
        self._size, self._next, self._hurried = size, 0, 0
        self._parts = split(size, search.scan_images, search.overlap)
        self._follower.forget()

    def _windows(self) -> list[Window]:
        """Return where to look in this image."""
        whole = [self._whole]
        likely = self._follower.predict(self._size)
        if self._whole_wanted or not len(likely):
            self._whole_wanted = False
            return whole
        windows = around(likely, self._size)
        count = min(self._hurried, _HURRIED) or 1
        windows += [self._parts[(self._next + i) % len(self._parts)] for i in range(count)]
        self._next = (self._next + count) % len(self._parts)
        self._hurried = max(0, self._hurried - count)
        cost = sum(window.cost for window in windows)
        return windows if cost < _WORTHWHILE * self._whole.cost else whole

    def _learn(self, found: list[Piece], *, whole: bool) -> None:
        """Follow what was found, and decide whether to look for what was lost."""
        missed = self._follower.update(found)
        self._since_loss += 1
        # A box that comes and goes, such as a wave's, must not have it hurry every time.
        if missed and not whole and self._since_loss >= self._config.search.scan_images:
            self._since_loss = 0
            self._whole_wanted = self._follower.blind
            self._hurried = 0 if self._whole_wanted else len(self._parts)
