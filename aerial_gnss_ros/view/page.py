# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What the server and the page of `aerial-gnss view` say to each other.

The page opens a WebSocket, receives `hello`, and from then on `scene`s and pictures. It sends
`{"at_s": S}` for another time of a recording, and `{"picture": true}` while it shows the image.
"""

from __future__ import annotations

from typing import Any, Protocol

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.view.pictures import RecordedPictures, packed
from aerial_gnss_ros.view.recording import Recording
from aerial_gnss_ros.view.scene import named_boxes
from aerial_gnss_ros.view.server import Answer, Route, Socket, begin, result_of
from aerial_gnss_ros.view.tiles import Tiles

PAGE = "view.html"
SOCKET = "/socket"
_LONGEST_S = 1e9  # of a recording: whatever is larger is not from our page


class Watchers(Protocol):
    """What a live source is told of browsers."""

    def joined(self, browser: Socket) -> None:
        """Called when a browser has connected."""

    def left(self, browser: Socket) -> None:
        """Called when it has left."""

    def looks(self, browser: Socket, wanted: bool) -> None:
        """Called when it opens or closes the camera's image."""


class LiveSocket(Socket):
    """A browser that watches a live estimator."""

    def initialize(self, source: Watchers) -> None:
        """Tornado's constructor."""
        self._source = source

    def opened(self) -> None:
        """Begin to watch."""
        self._source.joined(self)

    def received(self, fields: dict[str, Any]) -> None:
        """Begin or end to look at the image."""
        if "picture" in fields:
            self._source.looks(self, bool(fields["picture"]))

    def closed(self) -> None:
        """End watching."""
        self._source.left(self)


class RecordingSocket(Socket):
    """A browser that moves through a recording."""

    def initialize(
        self, recording: Recording, pictures: RecordedPictures | None, tiles: Tiles | None
    ) -> None:
        """Tornado's constructor."""
        self._recording, self._pictures = recording, pictures
        self._tiles = tiles
        self._looks = False
        self._wanted_s = recording.opening_s
        self._shown_ns: int | None = None
        self._work: Any = None

    def opened(self) -> None:
        """Send what the page needs once, and the first scene."""
        self.send(hello(self._recording.hello(), self._pictures is not None, self._tiles))
        self.send({"kind": "scene", **self._recording.at(self._wanted_s)})

    def received(self, fields: dict[str, Any]) -> None:
        """Show another time, or begin or end to show the image."""
        if "picture" in fields:
            self._looks = bool(fields["picture"])
            self._shown_ns = None
        seconds = fields.get("at_s")
        if isinstance(seconds, int | float) and abs(seconds) < _LONGEST_S:
            self._wanted_s = float(seconds)
            self.send({"kind": "scene", **self._recording.at(self._wanted_s)})
        if self._looks and self._pictures is not None and (self._work is None or self._work.done()):
            self._work = begin(self._send_pictures())

    async def _send_pictures(self) -> None:
        """Send the image of the wanted time until the page has it."""
        while self._looks and self._pictures is not None:
            wanted_s = self._wanted_s
            scene = self._recording.at(wanted_s)
            if scene["stamp_ns"] != self._shown_ns:
                self._shown_ns = scene["stamp_ns"]
                try:
                    found = await result_of(self._pictures.at(scene["stamp_ns"]))
                except InputError as error:
                    self.send({"kind": "no picture", "words": str(error)})
                    found = None
                if found is not None:
                    content, header, boxes = found
                    same = abs(header["stamp_ns"] - scene["stamp_ns"]) < 1_000_000
                    robots = scene["robots"] if same else []
                    header["boxes"] = named_boxes(boxes, robots)
                    if not self.send(packed(content, header)):
                        return
            if self._wanted_s == wanted_s:
                return


class TileAnswer(Answer):
    """A tile of the user's map."""

    def initialize(self, tiles: Tiles) -> None:
        """Tornado's constructor."""
        self._tiles = tiles

    def get(self, zoom: str, column: str, row: str) -> None:
        """Answer with a picture, or nothing where the map ends."""
        found = self._tiles.tile(int(zoom), int(column), int(row))
        if found is None:
            self.set_status(204)
            return
        self.set_header("Content-Type", self._tiles.type)
        self.set_header("Cache-Control", "max-age=3600")
        self.write(found)


def hello(fields: dict[str, Any], pictures: bool, tiles: Tiles | None) -> dict[str, Any]:
    """Return the first message to a page.

    Args:
        fields: of the source.
        pictures: whether there are images.
        tiles: the user's map.
    """
    described = None if tiles is None else tiles.description()
    return {"kind": "hello", "pictures": pictures, "tiles": described, **fields}


def tile_routes(tiles: Tiles | None) -> list[Route]:
    """Return the routes of the user's map."""
    if tiles is None:
        return []
    return [(r"/tiles/(\d{1,2})/(\d{1,9})/(\d{1,9})", TileAnswer, {"tiles": tiles})]
