# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Starts the training process, follows it, and reports how it ended.

The training runs in a separate process, because the kernel kills it if memory runs out, which
another process must report.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from typing import Any

from aerial_gnss_ros.core.values.errors import AerialGnssError
from aerial_gnss_ros.training.offline import offline_environment
from aerial_gnss_ros.training.run_folder import RunFolder

COMMAND = (sys.executable, "-m", "aerial_gnss_ros.training.worker")
_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_MAX_THREADS")


class TrainingError(AerialGnssError):
    """A training ended early; the message says why, and how to continue.

    Attributes:
        explained: whether the message is complete without the log.
    """

    def __init__(self, message: str, explained: bool = False) -> None:
        super().__init__(message)
        self.explained = explained


def train_in_process(
    run: RunFolder, threads: int, report: Callable[[dict[str, Any]], None]
) -> None:
    """Train a run by its plan from its present state to the end.

    Args:
        run: with a plan.
        threads: of the processor; 0: the libraries decide.
        report: called with each event of `worker`: {"epoch": n} or {"doing": words}.

    Raises:
        TrainingError: it ended early.
    """
    environment = offline_environment(run.settings)
    if threads:
        environment.update(dict.fromkeys(_THREADS, str(threads)))
    command = [*COMMAND, str(run.path)]
    said = None
    with run.log.open("ab") as log:
        process = subprocess.Popen(  # noqa: S603 - our own module
            command,
            stdin=subprocess.PIPE,  # closed when this process ends
            stdout=subprocess.PIPE,
            stderr=log,
            env=environment,
            start_new_session=True,  # only this process handles Ctrl-C
        )
        try:
            assert process.stdout is not None  # noqa: S101 - PIPE
            for line in process.stdout:
                event = json.loads(line)
                said = event.get("error", said)
                report(event)
            code = process.wait()
        finally:
            _end(process)
    if code and not run.weights.is_file():  # written last: an end after that loses nothing
        raise TrainingError(said or _words(run, code), explained=said is not None)


def _end(process: subprocess.Popen[bytes]) -> None:
    if process.stdin is not None:
        process.stdin.close()
    try:
        process.wait(timeout=10)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def _words(run: RunFolder, code: int) -> str:
    if code == -signal.SIGKILL:
        return (
            "the training was killed, probably because memory ran out; continue with aerial-gnss "
            f"train --resume {run.path} (and a smaller --batch)."
        )
    if code < 0:
        how = f"was ended by {signal.Signals(-code).name}"
    else:
        how = f"failed ({_last_line(run)})"
    return f"the training {how}; {run.log} has the details; continue with --resume {run.path}."


def _last_line(run: RunFolder) -> str:
    size = run.log.stat().st_size
    with run.log.open("rb") as file:
        file.seek(max(0, size - 4096), os.SEEK_SET)
        lines = file.read().decode("utf-8", errors="replace").split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "without a word")
