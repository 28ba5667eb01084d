# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Real trainings on tiny images: both phases, really killed and resumed, offline throughout."""

from __future__ import annotations

import csv
import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytestmark = pytest.mark.ultralytics

# Notes every attempt to reach a network, and refuses it.
GUARD = """
import os, socket, traceback
def refuse(*arguments, **_):
    with open(os.environ["GUARD_LOG"], "a") as file:
        file.write(repr(arguments) + "".join(traceback.format_stack()[-8:]))
    raise OSError("the test refuses networks")
socket.socket.connect = socket.getaddrinfo = refuse
"""
TINY = ["--image-size", "64", "--batch", "4", "--threads", "1", "--device", "cpu"]


@pytest.fixture
def guarded(tmp_path):
    pytest.importorskip("ultralytics", reason="needs the extra [ultralytics]")
    folder = tmp_path / "guard"
    folder.mkdir()
    (folder / "sitecustomize.py").write_text(GUARD)
    log = folder / "log"
    path = os.pathsep.join([str(folder), *filter(None, [os.environ.get("PYTHONPATH")])])
    environment = {**os.environ, "PYTHONPATH": path, "GUARD_LOG": str(log)}
    program = "import urllib.request; urllib.request.urlopen('http://localhost:9')"
    subprocess.run([sys.executable, "-c", program], env=environment, check=False, stderr=-3)
    assert "localhost" in log.read_text()  # the guard does see attempts
    log.unlink()
    yield environment
    assert not log.exists(), log.read_text()


def start(environment, *arguments):
    command = [sys.executable, "-m", "aerial_gnss_ros.cli", "train", *map(str, arguments)]
    return subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def wait_for(process, words):
    """Read what a process says until it says this."""
    said = []
    for line in process.stderr:
        said.append(line)
        if words in line:
            return
    pytest.fail("".join(said))


def worker_of(process):
    """The process that trains, which the command has started."""
    for path in Path("/proc").glob("[0-9]*"):
        try:
            state = (path / "stat").read_text().rsplit(")", 1)[1].split()
        except (FileNotFoundError, ProcessLookupError):
            continue
        if int(state[1]) == process.pid:
            return int(path.name)
    pytest.fail("the command has no child")


def wait_until(true, process):
    while not true():
        assert process.poll() is None, process.communicate()
        time.sleep(0.05)


def rows_of(table):
    with table.open(newline="") as file:
        return list(csv.DictReader(file))


def content(folder):
    return {
        path: hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.rglob("*")
        if path.is_file()
    }


def test_killed_twice_and_resumed(tmp_path, make_set, guarded):
    source, run = make_set(tmp_path / "set", classes=("red", "blue")), tmp_path / "run"
    before = content(source)
    # The system kills the process that trains, as when memory runs out.
    process = start(guarded, source, "-o", run, "--epochs", "3,2", *TINY)
    wait_for(process, "training: 1 of 5")
    os.kill(worker_of(process), signal.SIGKILL)
    _, said = process.communicate()
    assert process.returncode == 2
    assert "was killed, probably because memory ran out; continue with" in said
    assert not (run / "best.pt").exists()
    # Somebody kills the command; the process that trains must not go on alone.
    process = start(guarded, "--resume", run)
    wait_for(process, "training: 4 of 5")
    worker = worker_of(process)
    process.kill()
    process.wait()
    end = time.monotonic() + 60.0
    while Path(f"/proc/{worker}").exists() and time.monotonic() < end:
        time.sleep(0.05)
    process = start(guarded, "--resume", run, "--json")
    out, said = process.communicate()
    assert process.returncode == 0, said
    reported = json.loads(out)["scores"]
    assert (reported["split"], reported["images"], reported["overall"]["robots"]) == ("val", 4, 7)

    table = rows_of(run / "metrics.csv")
    order = [("1", "1"), ("1", "2"), ("1", "3"), ("2", "1"), ("2", "2")]
    assert [(row["phase"], row["epoch"]) for row in table] == order
    # No epoch was done more than twice: a kill costs the epoch that it falls into.
    for number in (1, 2):
        rows = rows_of(run / f"phase{number}" / "results.csv")
        assert len(rows) <= len({row["epoch"] for row in rows}) + 1
    log = (run / "training.log").read_text()
    assert log.count("Resuming training") == 2
    assert "from epoch 1 to" not in log
    card = (run / "model_card.md").read_text()
    assert "red, blue" in card
    assert "1. 3 of 3 epochs" in card
    left = sorted(path.name for path in run.iterdir() if not path.name.startswith("."))
    assert left == [
        "best.pt", "curves.png", "metrics.csv", "model_card.md", "phase1", "phase2", "plan.json",
        "scores.json", "training.log",
    ]  # fmt: skip
    assert content(source) == before  # not even a cache was left there


def test_each_phase_goes_on_from_the_one_before(tmp_path, make_set, guarded):
    """With a learning rate of 0 the weights that were given come out of both phases."""
    from ultralytics import YOLO

    source = make_set(tmp_path / "set")
    start_file = tmp_path / "start.pt"
    YOLO("yolo11n.yaml").save(start_file)
    arguments = ["--weights", start_file, "--allow-pickle", "--learning-rate", "0", "--bfloat16"]
    process = start(
        guarded, source, "-o", tmp_path / "run", "--epochs", "1,1", *arguments, *TINY
    )  # fmt: skip
    _, said = process.communicate()
    assert process.returncode == 0, said

    def first_layer(file):
        return YOLO(file).model.state_dict()["model.0.conv.weight"].half()

    assert (first_layer(tmp_path / "run" / "best.pt") == first_layer(start_file)).all()


def test_for_a_given_time_killed_and_resumed(tmp_path, make_set, guarded):
    source, run, home = make_set(tmp_path / "set"), tmp_path / "run", tmp_path / "home"
    home.mkdir()
    environment = {**guarded, "HOME": str(home)}
    seconds = 12.0
    process = start(environment, source, "-o", run, "--time", seconds / 3600.0, *TINY)
    table = run / "phase1" / "results.csv"
    wait_until(lambda: table.exists() and len(table.read_text().splitlines()) > 1, process)
    os.kill(worker_of(process), signal.SIGKILL)
    process.communicate()
    assert process.returncode == 2
    before = rows_of(table)[-1]
    process = start(environment, "--resume", run)
    _, said = process.communicate()
    assert process.returncode == 0, said
    assert "training: 1 of 1 minutes" in said
    rows = rows_of(run / "metrics.csv")
    times, rates = ([float(row[key]) for row in rows] for key in ("time", "lr/pg0"))
    assert [int(row["epoch"]) for row in rows] == list(range(1, len(rows) + 1))
    assert len(rows) > int(before["epoch"])
    # The time goes on from where it was, and the rate falls with it to its end.
    assert times == sorted(times)
    assert times[-1] > 0.5 * seconds
    assert times[-2] < seconds
    assert rates[-1] < 0.1 * max(rates)
    assert {row["metrics/recall(B)"] for row in rows[:-1]} == {""}  # not scored in between
    card = (run / "model_card.md").read_text()
    assert f"{seconds / 3600.0:g} hours, {len(rows)} epochs" in card
    assert "they selected the best epoch" not in card
    assert not list(home.rglob("*ltralytics*"))


def test_frozen_layers_and_normalisations_stay(tmp_path, make_set, guarded):
    import torch
    from ultralytics import YOLO

    source, start_file = make_set(tmp_path / "set"), tmp_path / "start.pt"
    YOLO("yolo11n.yaml").save(start_file)
    arguments = ["--weights", start_file, "--allow-pickle", "--one-phase", "--epochs", "2", *TINY]
    for freeze, expected in ((24, "--freeze 24 leaves nothing to train"), (10, "")):
        process = start(
            guarded, source, "-o", tmp_path / "run", "--freeze", freeze, "--lr0", "0.01", *arguments
        )
        _, said = process.communicate()
        assert (expected in said) if expected else process.returncode == 0, said
    before, after = (
        YOLO(file).model.half().state_dict() for file in (start_file, tmp_path / "run" / "best.pt")
    )
    altered = {name for name in after if not torch.equal(before[name], after[name])}
    assert altered  # it has learnt
    assert not [name for name in altered if "running" in name]
    layers = {int(name.split(".")[1]) for name in altered}
    assert min(layers) >= 10
    assert max(layers) == 23


def test_what_cannot_be_trained_on(tmp_path, make_set, guarded):
    source, run = make_set(tmp_path / "set", robots=(1, 2)), tmp_path / "run"
    (tmp_path / "bad.pt").write_bytes(b"no pickle")
    for arguments, expected in (
        (["--weights", tmp_path / "bad.pt", "--allow-pickle"], "bad.pt cannot be trained further"),
        (["--device", "99"], "--device 99: torch sees"),
    ):
        process = start(guarded, source, "-o", run, *TINY, *arguments)
        _, said = process.communicate()
        assert process.returncode == 2
        assert expected in said.splitlines()[-1]
        assert not run.exists()
