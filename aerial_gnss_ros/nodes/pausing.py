# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pauses a player: by the space bar on a terminal, and by the services of `ros2 bag play`."""

from __future__ import annotations

import contextlib
import select
import sys
import termios
import tty
from collections.abc import Iterator
from typing import Any

import rclpy
from rclpy.node import Node
from std_srvs.srv import Trigger

from aerial_gnss_ros.nodes.player import Player


class Pausing:
    """Handles requests to pause and to resume.

    Args:
        node: offers the services `~/pause`, `~/resume` and `~/toggle_paused`.
        player: the player to pause.
        keyboard: whether the space bar pauses, too.
    """

    def __init__(self, node: Node, player: Player, *, keyboard: bool) -> None:
        self._node, self._player, self._keyboard = node, player, keyboard
        for name in ("pause", "resume", "toggle_paused"):
            self._offer(name)

    def _offer(self, name: str) -> None:
        def answer(_request: Any, response: Any) -> Any:
            paused = not self._player.paused if name == "toggle_paused" else name == "pause"
            self._set(paused)
            response.success, response.message = True, _word(paused)
            return response

        self._node.create_service(Trigger, f"~/{name}", answer)

    def going_on(self) -> bool:
        """Apply pending requests; return whether to continue playing. Call it often."""
        rclpy.spin_once(self._node, timeout_sec=0.0)
        if self._keyboard and select.select([sys.stdin], [], [], 0.0)[0]:
            key = sys.stdin.read(1)
            if key == " ":
                self._set(not self._player.paused)
            self._keyboard = bool(key)  # empty: the input has ended
        return bool(rclpy.ok())

    def _set(self, paused: bool) -> None:
        if paused != self._player.paused:
            self._player.paused = paused
            self._node.get_logger().info(_word(paused))


def _word(paused: bool) -> str:
    return "paused" if paused else "playing"


@contextlib.contextmanager
def keys() -> Iterator[bool]:
    """Put the terminal into single-key mode; yield whether there is a terminal."""
    if not sys.stdin.isatty():
        yield False
        return
    former = termios.tcgetattr(sys.stdin)
    tty.setcbreak(sys.stdin)
    try:
        yield True
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, former)
