# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Orientation of the camera in a base frame, composed of the transforms of a tree of frames (TF).

Transforms arrive one by one, each with its own stamp; static ones hold at any time. Whenever all
moving transforms between base and camera have a sample on both sides of a time, they are
interpolated to it and composed: at the stamps of all of them, so that interpolation between results
loses nothing.
"""

from __future__ import annotations

from bisect import insort
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.geometry.frames import quaternion_product
from aerial_gnss_ros.core.telemetry.series import Sample, Series, orientation_series
from aerial_gnss_ros.core.values.samples import Orientation

Array = NDArray[np.float64]

MAX_FRAMES = 1000
"""Greatest number of frames; further ones are ignored, so that memory is bounded."""
MAX_PENDING = 1000
"""Greatest number of times that wait for another transform: 5 s at 200 Hz."""
KEEP_S = 10.0
MAX_LISTED = 8
"""Greatest number of frames in a sentence."""


@dataclass(frozen=True)
class _Link:
    """A transform between base and camera, from a frame to its parent or the other way."""

    child: str
    inverse: bool


class FrameTree:
    """Transforms by child frame.

    Args:
        base: the frame in which the camera's orientation is wanted.
        camera: the camera's frame.
        max_gap_s: samples of one transform farther apart are not interpolated, s.
    """

    def __init__(self, base: str, camera: str, max_gap_s: float) -> None:
        self._base, self._camera, self._max_gap_s = base, camera, max_gap_s
        self._parents: dict[str, str] = {}
        self._last: dict[str, Orientation] = {}
        self._static: set[str] = set()
        self._links: tuple[_Link, ...] | None = None
        self._moving: dict[str, Series[Orientation]] = {}
        self._pending: list[int] = []
        self._heard_ns: dict[str, int] = {}
        self._disconnected = self._disconnection()

    def add(
        self, parent: str, child: str, turn: Orientation, static: bool, arrival_ns: int
    ) -> None:
        """Take a transform.

        Args:
            parent: frame.
            child: frame.
            turn: orientation of the child in its parent.
            static: whether it holds at any time.
            arrival_ns: when it arrived, ns.
        """
        if child not in self._parents and len(self._parents) >= MAX_FRAMES:
            return
        new = self._parents.get(child) != parent or (child in self._static) != static
        self._parents[child], self._last[child] = parent, turn
        (self._static.add if static else self._static.discard)(child)
        if new:
            self._connect()
        self._heard_ns[child] = arrival_ns
        series = self._moving.get(child)
        if series is None:
            return
        if (series.last_stamp_ns or 0) - turn.stamp_ns > KEEP_S * 1e9:  # time was set back
            self._pending = []
            for one in self._moving.values():
                one.clear()
        series.add(turn)
        insort(self._pending, turn.stamp_ns)
        del self._pending[:-MAX_PENDING]

    def ready(self) -> list[Orientation]:
        """Return the camera's orientations in the base frame that have become known since."""
        found: list[Orientation] = []
        if not self._moving:
            return found
        ends = [one.last_stamp_ns for one in self._moving.values()]
        until_ns = min(-1 if one is None else one for one in ends)
        while self._pending and self._pending[0] <= until_ns:
            stamp_ns = self._pending.pop(0)
            if found and found[-1].stamp_ns == stamp_ns:
                continue
            composed = self._composed(stamp_ns)
            if composed is not None:
                found.append(Orientation(stamp_ns, composed))
        return found

    @property
    def is_static(self) -> bool:
        """Whether only static transforms lie between base and camera."""
        return self._links is not None and not self._moving

    def static(self, stamp_ns: int) -> Orientation | None:
        """Return the orientation of a camera that does not move in the base frame, else None."""
        composed = self._composed(stamp_ns) if self.is_static else None
        return None if composed is None else Orientation(stamp_ns, composed)

    def trouble(self, now_ns: int) -> str:
        """Return why there is no orientation, a sentence without its stop; empty if there is one.

        Args:
            now_ns: present time on the clock of arrivals, ns.
        """
        if self._disconnected:
            return self._disconnected
        for child in self._moving:
            silent_s = (now_ns - self._heard_ns[child]) * 1e-9
            if silent_s > self._max_gap_s:
                link = f"{self._parents[child]} -> {child}"
                return f"the transform {link} stopped {silent_s:.1f} s ago"
        return ""

    def _composed(self, stamp_ns: int) -> Array | None:
        """Return the quaternion (4,) at a time, None if a transform is not known then."""
        whole = np.array([0.0, 0.0, 0.0, 1.0])
        for link in self._links or ():
            own = self._last[link.child].quaternion
            if link.child in self._moving:
                sample = self._moving[link.child].at(stamp_ns)
                if not isinstance(sample, Sample):
                    return None
                own = sample.value.quaternion
            turn = own * np.array([-1.0, -1.0, -1.0, 1.0]) if link.inverse else own
            whole = quaternion_product(whole, turn)
        return whole

    def _connect(self) -> None:
        """Find the way from base to camera after the tree has changed."""
        self._disconnected = self._disconnection()
        if self._disconnected:
            self._links, self._moving, self._pending = None, {}, []
            return
        up, down = self._way_up(self._base)[0], self._way_up(self._camera)[0]
        shared = next(frame for frame in up if frame in down)
        links = [_Link(frame, True) for frame in up[: up.index(shared)]]
        links += [_Link(frame, False) for frame in reversed(down[: down.index(shared)])]
        if tuple(links) == self._links and self._moving.keys() == self._moves(links):
            return
        self._links, self._pending, former = tuple(links), [], self._moving
        self._moving = {}
        for child in sorted(self._moves(links)):
            if child in former:
                self._moving[child] = former[child]
            else:
                self._moving[child] = orientation_series(self._max_gap_s, keep_s=KEEP_S)
                self._moving[child].add(self._last[child])
                insort(self._pending, self._last[child].stamp_ns)

    def _moves(self, links: list[_Link]) -> set[str]:
        return {link.child for link in links} - self._static

    def _disconnection(self) -> str:
        """Return why base and camera are not connected; empty if they are."""
        ways = {}
        for frame in (self._base, self._camera):
            ways[frame], loop = self._way_up(frame)
            if loop:
                return f"TF has a loop: {' -> '.join(loop)}"
        if set(ways[self._base]) & set(ways[self._camera]):
            return ""
        known = sorted({*self._parents, *self._parents.values()})
        for frame in ways:
            if frame not in known:
                more = ", …" if len(known) > MAX_LISTED else ""
                listed = ", ".join(known[:MAX_LISTED]) + more if known else "none yet"
                return f"TF has no frame {frame}; its frames: {listed}"
        base, camera = (f"{frame} hangs on {way[-1]}" for frame, way in ways.items())
        return f"TF does not connect them: {base}, {camera}"

    def _way_up(self, frame: str) -> tuple[list[str], list[str]]:
        """Return a frame with its ancestors, and a loop among these, from a frame to itself."""
        way = [frame]
        while way[-1] in self._parents:
            parent = self._parents[way[-1]]
            if parent in way:
                return way, [*way[way.index(parent) :], parent]
            way.append(parent)
        return way, []
