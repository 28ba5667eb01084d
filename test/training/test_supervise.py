# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How a training ended, in a sentence; tested without torch, with processes in its place."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from aerial_gnss_ros.training import supervise, worker
from aerial_gnss_ros.training.inspection import inspect
from aerial_gnss_ros.training.layout import open_dataset
from aerial_gnss_ros.training.phases import Phase
from aerial_gnss_ros.training.run_folder import Plan, RunFolder
from aerial_gnss_ros.training.supervise import TrainingError, train_in_process


def follow(monkeypatch, tmp_path, program):
    monkeypatch.setattr(supervise, "COMMAND", (sys.executable, "-c", program))
    events = []
    run = RunFolder(tmp_path)
    try:
        train_in_process(run, 1, events.append)
    except TrainingError as error:
        return events, str(error), error.explained
    return events, "", True


ENDINGS = {
    "print('{\"epoch\": 3}')": "",
    "import os; os.kill(os.getpid(), 9)": "was killed, probably because memory ran out",
    "import os; os.kill(os.getpid(), 6)": "was ended by SIGABRT",
    "raise ValueError('odd thing')": "failed (ValueError: odd thing); ",
    'print(\'{"error": "too bad."}\'); exit(2)': "too bad.",
}


@pytest.mark.parametrize(("program", "expected"), ENDINGS.items(), ids=list(ENDINGS.values()))
def test_each_ending_has_its_sentence(monkeypatch, tmp_path, program, expected):
    events, said, explained = follow(monkeypatch, tmp_path, program)
    assert expected in said
    assert (expected == "") == (said == "")
    assert explained == (expected in ("", "too bad."))
    if "epoch" in program:
        assert events == [{"epoch": 3}]
    if said and not explained:
        assert f"--resume {tmp_path}" in said


def test_what_ends_a_training_that_has_written_everything_costs_nothing(monkeypatch, tmp_path):
    end = f"import os; open({str(tmp_path / 'best.pt')!r}, 'w').close(); os.kill(os.getpid(), 9)"
    assert follow(monkeypatch, tmp_path, end) == ([], "", True)


def test_ultralytics_is_kept_offline_and_to_its_threads(monkeypatch, tmp_path):
    show = (
        "import json, os; print(json.dumps({name: os.environ.get(name) for name in "
        "('YOLO_OFFLINE', 'YOLO_AUTOINSTALL', 'YOLO_CONFIG_DIR', 'OMP_NUM_THREADS')}))"
    )
    ((reported,), _, _) = follow(monkeypatch, tmp_path, show)
    assert reported == {
        "YOLO_OFFLINE": "true",
        "YOLO_AUTOINSTALL": "false",
        "YOLO_CONFIG_DIR": str(tmp_path / ".ultralytics"),
        "OMP_NUM_THREADS": "1",
    }
    fonts = tmp_path / ".ultralytics" / "Ultralytics"
    assert (fonts / "Arial.ttf").is_file()  # or it would be downloaded


@pytest.mark.parametrize(
    ("error", "expected"),
    [
        (MemoryError(), "memory ran out; continue with a smaller --batch"),
        (RuntimeError("CUDA out of memory. Tried to allocate 2 GiB"), "memory ran out"),
        (RuntimeError("[enforce fail] DefaultCPUAllocator: can't allocate memory"), "memory ran"),
        (OSError(errno.ENOSPC, "No space left on device"), "the disk is full"),
        (RuntimeError("shapes differ"), ""),
    ],
)
def test_what_ran_out(error, expected):
    said = worker._what_ran_out(error)
    assert said.startswith(expected)
    assert bool(said) == bool(expected)


def saved_plan(run, dataset, fingerprint):
    run.path.mkdir()
    run.save(Plan(dataset.file, fingerprint, False, (Phase("all", 1),), "yolo11n.yaml"))


def test_other_images_than_at_the_beginning_are_refused(tmp_path, make_set):
    dataset = open_dataset(make_set(tmp_path / "set"))
    run = RunFolder(tmp_path / "run")
    saved_plan(run, dataset, inspect(dataset).fingerprint())
    (tmp_path / "set" / "labels" / "train" / "0.txt").write_text("0 0.5 0.5 0.2 0.2\n")
    with pytest.raises(TrainingError, match="is not the data set of this training") as caught:
        train_in_process(run, 1, lambda _: None)
    assert caught.value.explained


def test_the_worker_ends_when_its_parent_is_killed(tmp_path, make_set):
    dataset = open_dataset(make_set(tmp_path / "set"))
    run = RunFolder(tmp_path / "run")
    saved_plan(run, dataset, "")
    # Held back by the lock's file, which is a pipe that nobody opens for reading.
    os.mkfifo(run.path / ".lock")
    program = (
        "import sys; from pathlib import Path; from aerial_gnss_ros.training.run_folder import "
        "RunFolder; from aerial_gnss_ros.training.supervise import train_in_process; "
        "train_in_process(RunFolder(Path(sys.argv[1])), 1, print)"
    )
    parent = subprocess.Popen([sys.executable, "-c", program, str(run.path)])
    child = first_child(parent.pid)
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    wait_until(lambda: not alive(child))


def first_child(pid):
    found = []

    def look():
        found.extend(path for path in Path("/proc").glob("[0-9]*") if parent_of(path) == pid)
        return found

    wait_until(look)
    return int(found[0].name)


def parent_of(process):
    return int((fields(process) or ["", "0"])[1])


def alive(pid):
    reported = fields(Path("/proc") / str(pid))
    return bool(reported) and reported[0] != "Z"


def fields(process):
    """State, parent and so on of a process; nothing where it has ended."""
    try:
        return (process / "stat").read_text().rsplit(")", 1)[1].split()
    except (FileNotFoundError, ProcessLookupError):
        return []


def wait_until(true, seconds=60.0):
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "waited too long"
        time.sleep(0.05)
