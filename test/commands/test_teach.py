# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss teach`: a data set from a few marks, in one go or in several; wrong input."""

from __future__ import annotations

import importlib.util
import json
import re

import cv2
import numpy as np
import pytest
import yaml

from aerial_gnss_ros import cli
from aerial_gnss_ros.commands import teach as command
from aerial_gnss_ros.teaching.learning import Learnt
from aerial_gnss_ros.teaching.recording import Recording
from aerial_gnss_ros.training.labelled_bag import read_bag
from aerial_gnss_ros.training.layout import open_dataset


def _say(path, marks):
    path.write_text(json.dumps({"marks": marks}))
    return path


def teach(*args):
    return cli.main(["teach", *map(str, args)])


@pytest.fixture(scope="module")
def flight(tmp_path_factory):
    """A flight over a catamaran and a torpedo, with telemetry and images."""
    bag = tmp_path_factory.mktemp("teach") / "flight"
    arguments = ["simulate", "-o", str(bag), "--robot-model", "catamaran,torpedo", "--robots", "2"]
    arguments += ["--duration", "5", "--rate", "2", "--size", "640x360", "--flight", "transit"]
    assert cli.main([*arguments, "--height", "9", "--tilt", "70", "--seed", "6"]) == 0
    return bag


def _true_boxes(bag):
    """Return the true boxes (n, 4) left, top, right, bottom of each image; first pixel 0 to 1."""
    return [image.truth.corners + 0.5 for image in read_bag(bag)]


def _clicks(bag, path):
    """Click the two robots in the first image; which is which does not matter for boxes."""
    first = _true_boxes(bag)[0]
    middles = (first[:, :2] + first[:, 2:]) / 2.0
    long = (first[:, 2:] - first[:, :2]).max(axis=1)
    names = ["catamaran", "torpedo"] if long[0] < long[1] else ["torpedo", "catamaran"]
    return _say(path, [
        {"robot": f"{name}_1", "class": name, "frame": 0, "x": x, "y": y}
        for name, (x, y) in zip(names, middles.tolist(), strict=True)
    ])  # fmt: skip


def test_one_click_each_labels_a_flight_with_telemetry(flight, tmp_path, capsys):
    work = tmp_path / "mine"
    clicks = _clicks(flight, tmp_path / "clicks.json")
    assert teach(flight, "-o", work, "--clicks", clicks, "--json", "--no-train") == 0
    said, shown = capsys.readouterr()
    assert "carried by telemetry (10 of 10 cameras known)" in shown
    about = json.loads(said)
    assert about["marks"] == 2
    data = open_dataset(work / "dataset")
    assert set(data.names) == {"catamaran", "torpedo"}
    assert (len(data.images["train"]), len(data.images["val"])) == (8, 2)
    right = labels = boxes = 0
    for frame, truth in enumerate(_true_boxes(flight)):
        split = "train" if frame < 8 else "val"
        text = (work / "dataset" / "labels" / split / f"{frame:06d}.txt").read_text()
        rows = np.array([line.split() for line in text.splitlines()], dtype=float).reshape(-1, 5)
        for x, y, w, h in rows[:, 1:] * (640, 360, 640, 360):
            low, high = np.array([x - w / 2, y - h / 2]), np.array([x + w / 2, y + h / 2])
            both = np.minimum(high, truth[:, 2:]) - np.maximum(low, truth[:, :2])
            both = np.maximum(both, 0.0).prod(axis=1)
            areas = (truth[:, 2:] - truth[:, :2]).prod(axis=1)
            right += (both / (areas + w * h - both)).max() > 0.5
        boxes += len(rows)
        whole = (truth[:, :2] > 1.0).all(axis=1) & (truth[:, 2:] < (639.0, 359.0)).all(axis=1)
        labels += int(whole.sum())
    assert labels >= 14
    assert right >= 0.9 * labels
    assert right >= 0.95 * boxes


@pytest.fixture(name="drawn")
def _drawn():
    """Return a maker of a folder of noisy water with one yellow robot that swims to the right."""
    return _draw


@pytest.fixture(name="video")
def _video(tmp_path):
    return _draw(tmp_path / "video", 8)


def _draw(folder, count):
    rng = np.random.default_rng(2)
    folder.mkdir()
    for i in range(count):
        noise = cv2.GaussianBlur(rng.normal(0.0, 12.0, (240, 320)), (0, 0), 1.5)[..., None]
        image = np.clip(np.array([110.0, 120.0, 70.0]) + noise, 0, 255).astype(np.uint8)
        cv2.rectangle(image, (60 + 5 * i, 100), (89 + 5 * i, 117), (40, 210, 230), -1)
        cv2.imwrite(str(folder / f"{i:0{len(str(count - 1))}d}.png"), image)
    return folder


def test_work_goes_on_where_it_was_left(video, tmp_path, capsys, monkeypatch):
    """A second run copies no frame, adds what is new, and an undo takes the last mark back."""
    work, clicks = tmp_path / "mine", tmp_path / "clicks.json"
    click = {"frame": 2, "x": 85, "y": 108}
    assert teach(video, "-o", work, "--clicks", _say(clicks, [click]), "--class", "fin") == 0
    out, err = capsys.readouterr()
    assert "8 boxes (fin 8) from 1 mark" in out
    assert "8 boxes are too few to train on" in out
    assert "alignment of the images (0 of 8 cameras known)" in err
    monkeypatch.setattr(command, "open_pictures", lambda *_args: pytest.fail("opened again"))
    _say(clicks, [click, {"frame": 6, "absent": True}])
    assert teach(video, "-o", work, "--clicks", clicks, "--class", "fin") == 0
    assert "6 boxes (fin 6) from 2 marks" in capsys.readouterr().out
    assert teach(video, "-o", work, "--undo") == 0
    assert "8 boxes (fin 8) from 1 mark" in capsys.readouterr().out
    assert not list(work.glob(".*"))


def test_without_torch_labels_are_written_with_what_to_install(
    tmp_path, capsys, monkeypatch, drawn
):
    """And too few boxes, or --no-train, say nothing of torch."""
    real = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "torch" else real(name)
    )
    clicks = _say(tmp_path / "clicks.json", [{"frame": 2, "x": 85, "y": 108}])
    long, work = drawn(tmp_path / "long", 24), tmp_path / "mine"
    assert teach(long, "-o", work, "--clicks", clicks) == 0
    out, err = capsys.readouterr()
    assert "24 boxes (robot 24) from 1 mark" in out
    (said,) = [line for line in err.splitlines() if line.startswith("no detector")]
    assert re.search(r"needs torch; install it with .*\[training\]", said)
    assert len(list((work / "dataset/labels/train").iterdir())) == 19
    assert teach(long, "-o", work, "--clicks", clicks, "--no-train") == 0
    assert "torch" not in capsys.readouterr().err
    assert teach(long, "-o", work, "--threads", "-1") == 2
    assert "--threads must lie within 0 to 256" in capsys.readouterr().err


def test_what_was_learnt_is_told_with_what_to_put_into_the_parameters(
    tmp_path, capsys, monkeypatch, drawn
):
    learnt = Learnt("0", ("fin",), 0.62, 0.7, 5, 20, 19, 1, 800, 61.4, 42.0)
    monkeypatch.setattr(command, "learn", lambda *_args: learnt)
    clicks = _say(tmp_path / "clicks.json", [{"frame": 2, "x": 85, "y": 108}])
    work = tmp_path / "mine"
    assert teach(drawn(tmp_path / "long", 24), "-o", work, "--clicks", clicks) == 0
    said = capsys.readouterr().out
    assert "on the 5 images kept aside, with 20 labels: precision 0.950, recall 0.950" in said
    assert "trained in 61 s on 800 boxes, 42 ms an image" in said
    shown = yaml.safe_load(said[said.index("/**/detector:") :])
    assert shown == yaml.safe_load((work / "detector.yaml").read_text())
    assert shown["/**/detector"]["ros__parameters"] == {
        "model": "anomaly", "second_look": str(work / "taught.onnx"), "score_threshold": 0.62,
    }  # fmt: skip
    assert "/**/estimator" not in shown  # no lengths without telemetry
    assert "#     tracks: {confirm_score: 0.7}" in said
    assert teach(tmp_path / "long", "-o", work, "--clicks", clicks, "--json") == 0
    assert json.loads(capsys.readouterr().out)["detector"]["recall"] == 0.95


def test_a_killed_copy_of_the_frames_begins_anew(video, tmp_path):
    work = tmp_path / "mine"
    (work / ".frames.partial" / "frames").mkdir(parents=True)
    clicks = _say(tmp_path / "clicks.json", [{"frame": 2, "x": 85, "y": 108}])
    assert teach(video, "-o", work, "--clicks", clicks) == 0
    assert len(Recording(work)) == 8


def test_of_a_long_recording_every_nth_frame_is_taken(video, tmp_path):
    work = tmp_path / "mine"
    clicks = _say(tmp_path / "clicks.json", [{"image": "3.png", "box": [75, 100, 30, 18]}])
    assert teach(video, "-o", work, "--clicks", clicks, "--frames", "3") == 0
    assert Recording(work).names == ["0.png", "3.png", "6.png"]
    _say(clicks, [{"image": "4.png", "x": 95, "y": 108}])
    assert teach(video, "-o", work, "--clicks", clicks) == 2


@pytest.mark.parametrize(
    ("marks", "words"),
    [
        ([{"frame": 2, "x": 250, "y": 30}], "nothing stands out from the water at 250, 30 px"),
        ([{"frame": 8, "x": 85, "y": 108}], "frame is 8; the recording has frames 0 to 7"),
        ([{"image": "9.png", "x": 1, "y": 1}], "has no image '9.png'"),
        ([{"frame": 1, "x": 85}], r"must be 2 numbers, px"),
        ([{"frame": 1}], "give either x and y, or box, or absent"),
        ([{"frame": 1, "box": [1, 2, 0, 4]}], "a box of 0x4 px is too small"),
        ([{"frame": 1, "bx": 3}], "'bx'.* is not known; use absent, box, class"),
        (
            [{"frame": 1, "x": 1, "y": 1, "class": "fin.2"}],
            "'fin.2' must .* without a dot",
        ),
        ([], "has no marks; write"),
    ],
)
def test_marks_that_cannot_be_meant_are_refused(video, tmp_path, capsys, marks, words):
    clicks = _say(tmp_path / "clicks.json", marks)
    assert teach(video, "-o", tmp_path / "mine", "--clicks", clicks) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert re.search(words, said), said
    assert not (tmp_path / "mine" / "dataset").exists()


def test_what_is_no_recording_or_no_work_is_refused(video, tmp_path, capsys):
    (tmp_path / "broken.mp4").write_bytes(b"no video")
    assert teach(tmp_path / "broken.mp4", "-o", tmp_path / "mine") == 2
    assert "broken.mp4" in capsys.readouterr().err
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.txt").write_text("mine")
    assert teach(video, "-o", tmp_path / "full") == 2
    assert "is no work of teach; give another folder" in capsys.readouterr().err
    empty = tmp_path / "empty"
    empty.mkdir()
    (empty / "0.jpg").write_bytes(b"\xff\xd8 cut off")
    assert teach(empty, "-o", tmp_path / "none") == 2
    assert "0.jpg" in capsys.readouterr().err
    assert not (tmp_path / "none").exists()
    assert teach(video, "-o", tmp_path / "some", "--no-page") == 2
    assert (
        "has no marks yet; click the robots on the page, or give --clicks"
        in capsys.readouterr().err
    )
    assert teach(empty, "-o", tmp_path / "some") == 2
    assert "has frames of video, not of empty" in capsys.readouterr().err
