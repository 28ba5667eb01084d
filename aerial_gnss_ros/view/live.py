# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The live source of the page: fetches from ROS while a browser watches, and sends to all."""

from __future__ import annotations

import dataclasses
import json
import time
from collections import deque
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from aerial_gnss_ros.adapters.overview import ERROR, Light
from aerial_gnss_ros.adapters.stamps import nanoseconds
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.view.page import hello
from aerial_gnss_ros.view.pictures import SAME_NS, jpeg, packed
from aerial_gnss_ros.view.recording import checked
from aerial_gnss_ros.view.scene import Box, Paths, boxes_of, named_boxes
from aerial_gnss_ros.view.server import Socket
from aerial_gnss_ros.view.tiles import Tiles

if TYPE_CHECKING:
    from aerial_gnss_ros.nodes.overviews import OverviewListener

STEP_S = 0.1
"""Interval of looking for news while somebody watches: overviews come as often at most."""
PICTURE_S = 0.4
WAIT_S = 0.5
"""Longest further wait for an image with boxes: a busy detector leaves many images out."""
KEPT_IMAGES = 8
"""Images kept until their boxes come, not decoded."""
NEWS_S = 1.0
"""Without an overview, the lights are sent as often."""
SILENT_S = 5.0
"""Diagnostics come every second; after this long without, their node has ended or hangs."""
KEPT = 30
"""Arrays of boxes and overviews kept for images that are shown later."""
_BACK_NS = 1_000_000_000


class Live:
    """Watches while at least one browser is there; `tick` must be called every `STEP_S`.

    Args:
        listener: fetches messages.
        title: of the page.
        tiles: the user's map.
        clock: monotonic, s.
    """

    def __init__(
        self,
        listener: OverviewListener,
        title: str,
        tiles: Tiles | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._listener, self._title, self._tiles, self._clock = listener, title, tiles, clock
        self._browsers: dict[Socket, bool] = {}  # whether it shows the image
        self._ready: set[Socket] = set()  # have received all that was sent before this tick
        self._paths = Paths(time.time_ns())
        self._known = False
        self._last: dict[str, Any] | None = None
        self._last_s = self._sent_s = self._began_s = 0.0
        self._lights: dict[str, tuple[float, Light]] = {}
        self._robots: deque[tuple[int, list[dict[str, Any]]]] = deque(maxlen=KEPT)
        self._boxes: deque[tuple[int, list[Box]]] = deque(maxlen=KEPT)
        self._images: deque[tuple[int, Any]] = deque(maxlen=KEPT_IMAGES)
        self._picture_s, self._shown_ns = 0.0, 0

    @property
    def watched(self) -> bool:
        """Whether a browser is there."""
        return bool(self._browsers)

    def joined(self, browser: Socket) -> None:
        """Begin to watch, and send what is known to a browser."""
        if not self._browsers:
            self._began_s = self._clock()
            self._lights.clear()
            self._listener.watch()
        self._browsers[browser] = False
        browser.send(self._hello())
        if self._last is not None:
            browser.send(self._scene(self._last))

    def left(self, browser: Socket) -> None:
        """End watching with the last browser."""
        if browser not in self._browsers:
            return
        self.looks(browser, wanted=False)
        del self._browsers[browser]
        if not self._browsers:
            self._listener.rest()

    def looks(self, browser: Socket, wanted: bool) -> None:
        """Begin or end to fetch images."""
        if browser not in self._browsers:
            return
        self._browsers[browser] = wanted
        if wanted:
            self._picture_s = self._clock() - PICTURE_S
            self._listener.look()
        elif not any(self._browsers.values()):
            self._listener.rest("image", "detections")
            self._images.clear()

    def tick(self) -> None:
        """Send news to all browsers."""
        if not self._browsers:
            return
        self._ready = {browser for browser in self._browsers if not browser.busy}
        for light in self._listener.lights():
            self._lights[light.name] = self._clock(), light
        text = self._listener.overview()
        if text is not None:
            self._take(text)
        elif self._clock() - self._sent_s >= NEWS_S:
            self._send({"kind": "silence", "lights": self.lights()})
        if any(self._browsers.values()):
            self._look()

    def lights(self) -> list[dict[str, str]]:
        """Return the lights of the nodes; one says that they are silent if they are."""
        now_s = self._clock()
        fresh = [light for at_s, light in self._lights.values() if now_s - at_s < SILENT_S]
        if not fresh and now_s - self._began_s >= SILENT_S:
            words = f"no diagnostics for {SILENT_S:.0f} s: it does not run, or not in this network"
            fresh = [Light(self._estimating, ERROR, words)]
        elif not any(light.name == "positions" for light in fresh) and fresh:
            fresh.append(Light(self._estimating, ERROR, "only the detector reports"))
        return [dataclasses.asdict(light) for light in fresh]

    @property
    def _estimating(self) -> str:
        """Name of the node that should send positions, by the last overview."""
        if self._last is None:
            return "estimator or fleet"
        return "fleet" if self._last.get("drones") else "estimator"

    def _hello(self) -> dict[str, Any]:
        fields = {
            "live": True,
            "title": self._title,
            "begin_ns": self._paths.begin_ns,
            "end_ns": self._paths.begin_ns,
            "paths": self._paths.robots(),
            "drone_path": self._paths.drone(),
            "drone_paths": self._paths.drones(),
        }
        return hello(fields, pictures=True, tiles=self._tiles)

    def _take(self, text: str) -> None:
        """Take an overview; where time went back, a recording begins anew, and paths with it."""
        try:
            fields = checked(text)
        except InputError as error:
            self._lights["overview"] = self._clock(), Light("overview", ERROR, str(error))
            return
        stamp_ns = fields["stamp_ns"]
        if not self._known or stamp_ns < (self._last or fields)["stamp_ns"] - _BACK_NS:
            self._known = True
            self._paths = Paths(stamp_ns)
            self._paths.add(fields)
            self._send(self._hello())
        else:
            self._paths.add(fields)
        self._last, self._last_s = fields, self._clock()
        self._robots.append((stamp_ns, fields["robots"]))
        self._send(self._scene(fields))

    def _scene(self, fields: Mapping[str, Any]) -> dict[str, Any]:
        """Return the newest overview as of now."""
        silent_s = self._clock() - self._last_s
        now_ns = fields["now_ns"] + round(silent_s * 1e9)
        return {
            **fields,
            "kind": "scene",
            "now_ns": now_ns,
            "silent_s": silent_s,
            "robots": [*fields["robots"], *self._paths.lost(fields, now_ns)],
            "lights": self.lights() or fields["lights"],
        }

    def _send(self, message: dict[str, Any] | bytes, only_lookers: bool = False) -> None:
        """Send to all browsers but those that still receive what an earlier tick sent."""
        self._sent_s = self._clock()
        whole = json.dumps(message) if isinstance(message, dict) else message
        first = isinstance(message, dict) and message["kind"] == "hello"
        for browser, looks in list(self._browsers.items()):
            if (looks or not only_lookers) and (first or browser in self._ready):
                browser.send(whole)

    def _look(self) -> None:
        """Send an image every `PICTURE_S`: the newest with boxes and names, else the newest."""
        for array in self._listener.detections():
            self._boxes.append((nanoseconds(array.header.stamp), boxes_of(array)))
        message = self._listener.image()
        if message is not None:
            self._images.append((nanoseconds(message.header.stamp), message))
        chosen = self._chosen(self._clock() - self._picture_s)
        if chosen is None:
            return
        stamp_ns, message = chosen
        self._picture_s, self._shown_ns = self._clock(), stamp_ns
        try:
            content, width, height = jpeg(message)
        except InputError as error:
            self._send({"kind": "no picture", "words": str(error)}, only_lookers=True)
            return
        boxes, robots = _at(self._boxes, stamp_ns), _at(self._robots, stamp_ns)
        header = {
            "stamp_ns": stamp_ns,
            "width": width,
            "height": height,
            "boxes_known": boxes is not None,
            "boxes": named_boxes(boxes or [], robots or []),
        }
        self._send(packed(content, header), only_lookers=True)

    def _chosen(self, passed_s: float) -> tuple[int, Any] | None:
        """Return the image to show now with its stamp, or None.

        Args:
            passed_s: time since the last one, s.
        """
        new: list[tuple[int, Any]] = [
            (stamp_ns, message)
            for stamp_ns, message in reversed(self._images)
            if stamp_ns != self._shown_ns
        ]
        if passed_s < PICTURE_S or not new:
            return None
        complete = (
            (stamp_ns, message)
            for stamp_ns, message in new
            if _at(self._boxes, stamp_ns) is not None and _at(self._robots, stamp_ns) is not None
        )
        last = new[0] if passed_s >= PICTURE_S + WAIT_S else None
        return next(complete, last)


def _at(kept: deque[tuple[int, Any]], stamp_ns: int) -> Any:
    """Return what is kept of a stamp, or None."""
    for own_ns, value in reversed(kept):
        if abs(own_ns - stamp_ns) < SAME_NS:
            return value
    return None
