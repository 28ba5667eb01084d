# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Runs nodes in a process until a signal: status 0, or 2 with one sentence for wrong input."""

from __future__ import annotations

import re
import signal
import sys
import warnings
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import rclpy
from rclpy.exceptions import InvalidHandle, NotInitializedException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node

from aerial_gnss_ros.adapters.parameter_files import read
from aerial_gnss_ros.core.values.errors import AerialGnssError, ConfigError, RosError
from aerial_gnss_ros.nodes.leaving import (
    SIGNALS,
    Leave,
    asked_to_leave,
    leave_on_signals,
    leaves_on,
    noted_only,
    nothing_to_end,
)
from aerial_gnss_ros.nodes.memory import keep_freed_memory
from aerial_gnss_ros.nodes.ros_arguments import remember
from aerial_gnss_ros.nodes.schemas import SCHEMAS
from aerial_gnss_ros.nodes.worker import WorkEndedError

WRONG_INPUT = 2
_SWITCH_S = 0.001  # the detection thread waits for the GIL after every inference
_RCL_ERROR: type[Exception] = rclpy._rclpy_pybind11.RCLError  # noqa: SLF001 (no public name)
_ENDS = (ExternalShutdownException, WorkEndedError)
_GONE = (_RCL_ERROR, InvalidHandle, NotInitializedException)


def main(program: str, make_node: Callable[[], Node], argv: Sequence[str] | None = None) -> int:
    """Run one node as an executable and return the exit status.

    Args:
        program: its name, for messages.
        make_node: called once ROS is initialised.
        argv: with the program's name first; None takes the process's own.
    """
    arguments = list(sys.argv if argv is None else argv)
    rest = own_arguments(arguments)[1:]
    if rest:
        asked = rest[0] in ("-h", "--help")
        usage = f"usage: {program} [--ros-args --params-file FILE -p NAME:=VALUE -r FROM:=TO ...]"
        print(
            usage if asked else f"{program}: unknown argument {rest[0]!r}; {usage}",
            file=sys.stdout if asked else sys.stderr,
        )
        return 0 if asked else WRONG_INPUT
    try:
        return spin([make_node], arguments)
    except AerialGnssError as error:
        print(f"{program}: {error}", file=sys.stderr)  # noqa: T201
        return WRONG_INPUT


def own_arguments(arguments: Sequence[str]) -> list[str]:
    """Return the arguments that are not for ROS: all but `--ros-args ...` up to its end or `--`.

    rclpy's own function also reads the parameter files and raises if one is invalid.
    """
    own, ours = [], True
    for argument in arguments:
        if argument == "--ros-args":
            ours = False
        elif argument == "--" and not ours:
            ours = True
        elif ours:
            own.append(argument)
    return own


def spin(makers: Sequence[Callable[[], Any]], arguments: Sequence[str]) -> int:
    """Initialise ROS, make nodes and spin them until SIGINT or SIGTERM; return 0.

    Args:
        makers: factories of nodes (`SupervisedNode`); their exceptions end the process.
        arguments: with the program's name first, then `--ros-args …`.

    Raises:
        AerialGnssError: the input was wrong; ROS has been shut down.
    """
    nodes: list[Any] = []

    @noted_only()
    def until_shutdown() -> None:
        executor = SingleThreadedExecutor()
        nodes.extend(_made(make) for make in makers if not asked_to_leave())
        for node in nodes:
            if not asked_to_leave():
                node.begin()
                executor.add_node(node)
        while rclpy.ok() and not asked_to_leave():  # rclpy's own handler ends the waiting
            _spin_once(executor, nodes)

    def destroy() -> None:
        for node in nodes:
            node.destroy_node()

    return work(until_shutdown, arguments, destroy)


def _made(make: Callable[[], Any]) -> Any:
    """Make a node.

    Raises:
        RosError: ROS refuses, for example without its security libraries.
    """
    try:
        return make()
    except _RCL_ERROR as error:
        if asked_to_leave() or not rclpy.ok():
            raise
        raise _init_error(str(error), ()) from error


def _spin_once(executor: SingleThreadedExecutor, nodes: Sequence[Any]) -> None:
    """Execute due callbacks; an exception in one does not end the nodes."""
    try:
        executor.spin_once()
    except Exception as error:
        if asked_to_leave() or not rclpy.ok() or isinstance(error, _ENDS):
            raise
        for node in nodes:  # the callback's node is unknown
            node.survive(error)


def work(
    task: Callable[[], None], arguments: Sequence[str], after: Callable[[], None] = lambda: None
) -> int:
    """Initialise ROS, run a task until its end or a signal, and shut ROS down; return 0.

    Args:
        task: the work.
        arguments: with the program's name first, then `--ros-args …`.
        after: cleans up before ROS is shut down; a second signal does not disturb it.

    Raises:
        AerialGnssError: the input was wrong.
    """
    # After a first signal the process is ending anyway: a second one has no effect.
    former = {
        number: nothing_to_end if leaves_on(number) else signal.getsignal(number)
        for number in SIGNALS
    }
    leave_on_signals()
    keep_freed_memory()
    sys.setswitchinterval(_SWITCH_S)
    try:
        _initialise(arguments)
        if not asked_to_leave():
            task()
    except (Leave, ExternalShutdownException):
        pass
    except Exception as error:
        # A signal at any point: rclpy's C++ converts `Leave` into other errors, or the context is
        # gone.
        if not (asked_to_leave() or (isinstance(error, _GONE) and not rclpy.ok())):
            raise
    finally:
        for number in former:
            signal.signal(number, signal.SIG_IGN)
        # A signal may leave a coroutine of rclpy unstarted, about which Python warns at exit.
        warnings.filterwarnings("ignore", "coroutine 'Executor", RuntimeWarning)
        after()
        rclpy.try_shutdown()
        remember(())
        for number, handler in former.items():
            signal.signal(number, handler)
    return 0


def _initialise(arguments: Sequence[str]) -> None:
    remember(arguments)
    try:
        rclpy.init(args=list(arguments))
    except Exception as error:
        files = [b for a, b in pairwise(arguments) if a == "--params-file"]
        read(
            files, SCHEMAS, tell=lambda _: None
        )  # a better error message than rcl's, if it finds the error
        rules = [b for a, b in pairwise(arguments) if a in ("-r", "--remap")]
        raise _init_error(str(error), files, rules) from error


def _init_error(text: str, files: Sequence[str], rules: Sequence[str] = ()) -> AerialGnssError:
    reason = re.sub(r", at /\S+:\d+", "", text.split("Error: ", 1)[-1]).strip(" .")
    reason = re.sub(r"\s*\n\s*", "; ", reason)
    if "same type" in reason:
        reason += "; in one list write all numbers with a decimal point, such as [0.0, 90.0]"
    if rules and "error not set" in reason:  # so rcl's parser refuses a name in a rule
        reason = (
            f"a remapping rule is invalid ({', '.join(rules)}); it has the form from:=to, and no "
            "part of a name begins with a digit"
        )
    if "lexeme" in reason:  # rcl's parser of remapping rules
        reason += "; a rule or name after --ros-args is not of the form from:=to, such as __ns:=/d1"
    if files:
        return ConfigError(f"ROS cannot read the parameters ({', '.join(files)}): {reason}.")
    return RosError(f"ROS cannot start: {reason}.")
