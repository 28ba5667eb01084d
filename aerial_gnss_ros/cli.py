# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The `aerial-gnss` command: finds the subcommand and turns errors into one sentence."""

from __future__ import annotations

import argparse
import errno
import importlib
import io
import os
import sys
from collections.abc import Sequence
from typing import NoReturn, Protocol, cast

from aerial_gnss_ros import __version__
from aerial_gnss_ros.core.values.errors import AerialGnssError

# Subcommand -> module and help. The module is imported only when asked for: `aerial-gnss --help`
# and a wrong word must not wait for OpenCV or need ROS.
COMMANDS = {
    "demo": ("demo", "simulate a short flight and localise its robots with the real nodes, live"),
    "run": ("run", "start detector and estimator nodes, and start again one that dies"),
    "view": ("view", "show a live picture, or one of a recording, in a browser or on a tablet"),
    "where": ("where", "say where one robot is: ask the live estimator once"),
    "stream": ("stream", "send live positions on: robots' autopilots, plotters, TAK, MAVLink"),
    "replay": ("replay", "localise the robots in recorded bags"),
    "play": ("play", "play a recording into live nodes, with /clock"),
    "simulate": ("simulate", "make a bag of a simulated flight with rendered images and truth"),
    "import-dji": ("import_dji", "turn a DJI flight record, with its video, into a bag"),
    "augment": ("augment", "make variants of the training images of a labelled data set"),
    "export": ("export", "make a model smaller and faster (fp16, int8), scored beside the first"),
    "teach": ("teach", "label your own robot in a recording with a few clicks"),
    "train": ("train", "train a detector on labelled images, first one robot, then several"),
    "detect": ("detect", "boxes on images, a folder, a video or a bag, drawn and scored"),
    "evaluate": ("evaluate", "compare the result of a replay with the truth"),
    "benchmark": ("benchmark", "time the whole pipeline on this machine, stage by stage"),
    "calibrate": ("calibrate", "find latency, heading, gimbal and height errors from a recording"),
    "profiles": ("profiles", "list the vehicle profiles, or print one as a start for your own"),
    "check": ("check", "say in words where the camera points, and test signs and references"),
    "doctor": ("doctor", "propose the vehicle profile for a bag or the live topics"),
    "camera": ("camera", "field of view and ground sample distance of a camera"),
}
WRONG_INPUT = 2


class _Command(Protocol):
    def add_arguments(self, parser: argparse.ArgumentParser) -> None: ...

    def run(self, args: argparse.Namespace) -> int: ...


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        """Say what was wrong in one sentence, then where the help is."""
        self.exit(WRONG_INPUT, f"{self.prog}: {message}; see {self.prog} --help.\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Run `aerial-gnss` and return its exit status.

    Args:
        argv: arguments without the program's name; None takes the process's own.

    Returns:
        0 when the work is done, 2 when the input was wrong, 130 when interrupted.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    if isinstance(sys.stdout, io.TextIOWrapper):  # file names may be no Unicode
        sys.stdout.reconfigure(errors="replace")
    try:
        return _dispatch(arguments)
    except SystemExit as stop:
        return stop.code if isinstance(stop.code, int) else WRONG_INPUT
    except AerialGnssError as error:
        return _complain(str(error))
    except (OSError, MemoryError) as error:
        if isinstance(error, BrokenPipeError):
            # The reader of a pipe (head, less) went away: nothing is wrong with the input.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0
        return _complain(_system_sentence(error))
    except KeyboardInterrupt:
        print(
            "aerial-gnss: interrupted; nothing was written under the final name.", file=sys.stderr
        )
        return 130


def _dispatch(arguments: list[str]) -> int:
    if not arguments or arguments[0] in ("-h", "--help"):
        _overview().print_help()
        return 0
    if arguments[0] == "--version":
        print(f"aerial-gnss {__version__}")
        return 0
    name = arguments[0]
    if name not in COMMANDS:
        _overview().error(f"{name!r} is not a command; choose from {', '.join(COMMANDS)}")
    module, help_text = COMMANDS[name]
    command = cast(_Command, importlib.import_module(f"aerial_gnss_ros.commands.{module}"))
    parser = _Parser(prog=f"aerial-gnss {name}", description=help_text[0].upper() + help_text[1:])
    command.add_arguments(parser)
    return command.run(parser.parse_args(arguments[1:]))


def _overview() -> _Parser:
    width = max(map(len, COMMANDS))
    lines = [f"  {name:<{width}}  {text}" for name, (_, text) in COMMANDS.items()]
    return _Parser(
        prog="aerial-gnss",
        usage="aerial-gnss COMMAND [arguments]",
        description="Positions of marine robots, seen from a drone.",
        epilog="commands:\n" + "\n".join(lines) + "\n\naerial-gnss COMMAND --help says more.",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )


def _complain(sentence: str) -> int:
    print(f"aerial-gnss: {sentence}", file=sys.stderr)
    return WRONG_INPUT


def _system_sentence(error: OSError | MemoryError) -> str:
    if isinstance(error, MemoryError):
        return (
            "memory ran out, and nothing was written under the final name; close other programs, "
            "or give smaller images or shorter pieces."
        )
    where = f" {error.filename}" if error.filename else ""
    if error.errno == errno.ENOSPC:
        return f"the disk is full{f' while writing{where}' if where else ''}; free some space."
    return f"cannot use{where or ' a file'}: {error.strerror or error}."


if __name__ == "__main__":
    sys.exit(main())
