# SPDX-License-Identifier: Apache-2.0
"""Notices that time began again, as in a bag that is played in a loop."""

from __future__ import annotations

BACKWARD_NS = 2_000_000_000
"""So far behind the newest stamp of the same input is no late message: the clock went backward."""


class Clock:
    """The newest stamp of each input."""

    def __init__(self) -> None:
        self._newest: dict[str, int] = {}

    def newest(self, source: str) -> int | None:
        """Return the newest stamp of an input, ns."""
        return self._newest.get(source)

    def went_backward(self, source: str, stamp_ns: int) -> bool:
        """Take in a stamp; return whether it lies far behind the newest one of its input.

        Inputs are judged each by itself: their clocks and delays differ.
        """
        newest = self._newest.get(source)
        if newest is not None and stamp_ns < newest - BACKWARD_NS:
            return True
        if newest is None or stamp_ns > newest:
            self._newest[source] = stamp_ns
        return False

    def begin(self, source: str, stamp_ns: int) -> None:
        """Forget all stamps but this one."""
        self._newest = {source: stamp_ns}
