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
    environment = {**os.environ, "PYTHONPATH": str(folder), "GUARD_LOG": str(log)}
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
    assert "was killed, as the system does when memory runs out; go on with" in said
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
    told = json.loads(out)["scores"]
    assert (told["split"], told["images"], told["overall"]["robots"]) == ("val", 4, 7)

    table = list(csv.DictReader((run / "metrics.csv").open()))
    order = [("1", "1"), ("1", "2"), ("1", "3"), ("2", "1"), ("2", "2")]
    assert [(row["phase"], row["epoch"]) for row in table] == order
    # No epoch was done more than twice: a kill costs the epoch that it falls into.
    for number in (1, 2):
        rows = list(csv.DictReader((run / f"phase{number}" / "results.csv").open()))
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


def test_a_training_by_hand_is_offline_too(tmp_path, make_set, guarded):
    """Without settings or fonts of an earlier one, and leaving none."""
    data = make_set(tmp_path / "set") / "data.yaml"
    data.write_text(f"path: {data.parent}\n{data.read_text()}")
    home = tmp_path / "home"
    home.mkdir()
    environment = {**guarded, "HOME": str(home)}
    environment.pop("YOLO_CONFIG_DIR", None)
    command = [sys.executable, "-m", "aerial_gnss_ros.training.train", str(data), "-o", "run"]
    arguments = ["--minutes", "0", "--epochs", "1", "--image-size", "64", "--batch", "4"]
    subprocess.run(
        [*command, *arguments, "--threads", "1"], env=environment, cwd=tmp_path, check=True
    )
    assert not list(home.rglob("settings.json"))


def test_what_cannot_be_trained_on(tmp_path, make_set, guarded):
    source, run = make_set(tmp_path / "set", robots=(1, 2)), tmp_path / "run"
    (tmp_path / "bad.pt").write_bytes(b"no pickle")
    for arguments, expected in (
        (["--weights", tmp_path / "bad.pt", "--allow-pickle"], "bad.pt cannot be trained on"),
        (["--device", "99"], "--device 99: torch sees"),
    ):
        process = start(guarded, source, "-o", run, *TINY, *arguments)
        _, said = process.communicate()
        assert process.returncode == 2
        assert expected in said.splitlines()[-1]
        assert not run.exists()
