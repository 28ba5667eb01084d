# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The process of Blender: reads orders from its input, writes images to its output.

Blender prints to its output, and a fault in it ends the process; this contains both.
"""

from __future__ import annotations

import os
import pickle
import struct
import sys
import tempfile
from pathlib import Path
from typing import IO, Any

LENGTH = struct.Struct("<Q")


def send(pipe: IO[bytes], value: Any) -> None:
    """Writes a value and its length."""
    data = pickle.dumps(value)
    pipe.write(LENGTH.pack(len(data)) + data)
    pipe.flush()


def receive(pipe: IO[bytes]) -> Any:
    """Returns the next value.

    Raises:
        EOFError: the other process has ended.
    """
    head = pipe.read(LENGTH.size)
    data = pipe.read(LENGTH.unpack(head)[0]) if len(head) == LENGTH.size else b""
    if len(head) < LENGTH.size or len(data) < LENGTH.unpack(head)[0]:
        raise EOFError
    return pickle.loads(data)  # noqa: S301  (from our own process, through a pipe of our own)


def main() -> None:
    """Answers each order with a sample, or with the error that it met."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    from aerial_gnss_ros.simulation.blender.picture import render_sample

    with tempfile.TemporaryDirectory() as folder:
        while True:
            try:
                order = receive(sys.stdin.buffer)
            except EOFError:
                return
            try:
                send(answers, render_sample(order, Path(folder)))
            except Exception as error:  # noqa: BLE001  (reported to the parent, which decides)
                send(answers, f"{type(error).__name__}: {error}")


if __name__ == "__main__":
    main()
