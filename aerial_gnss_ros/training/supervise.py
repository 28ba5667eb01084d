# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Starts the process that trains, follows it, and says in a sentence how it ended.

A process of its own, because the kernel's answer to memory that runs out is to kill it: somebody
must be left to say so.
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
    """A training ended before its end; the message says why, and how to go on.

    Attributes:
        explained: whether the log has nothing to add.
    """

    def __init__(self, message: str, explained: bool = False) -> None:
        super().__init__(message)
        self.explained = explained


def train_in_process(
    run: RunFolder, threads: int, report: Callable[[dict[str, Any]], None]
) -> None:
    """Train what the run's plan says, from where it is, to the end.

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
            stdin=subprocess.PIPE,  # its end shows the process that we are gone
            stdout=subprocess.PIPE,
            stderr=log,
            env=environment,
            start_new_session=True,  # Ctrl-C is for us alone
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
    if code and not run.weights.is_file():  # written last: what ends it then costs nothing
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
            "the training was killed, as the system does when memory runs out; go on with "
            f"aerial-gnss train --resume {run.path} (with a smaller --batch, if it was that)."
        )
    if code < 0:
        how = f"was ended by {signal.Signals(-code).name}"
    else:
        how = f"failed ({_last_line(run)})"
    return f"the training {how}; {run.log} has the details; go on with --resume {run.path}."


def _last_line(run: RunFolder) -> str:
    size = run.log.stat().st_size
    with run.log.open("rb") as file:
        file.seek(max(0, size - 4096), os.SEEK_SET)
        lines = file.read().decode("utf-8", errors="replace").split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "without a word")
