# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss augment` from the command line: what it writes, again and again the same."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import cv2
import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.training.inspection import inspect
from aerial_gnss_ros.training.labelled import read_folder
from aerial_gnss_ros.training.layout import open_dataset
from aerial_gnss_ros.training.variants import PROBABILITIES


def content(folder):
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_variants_of_the_training_images_only(tmp_path, make_set, capsys):
    source, out = make_set(tmp_path / "set", splits=("train", "val", "test")), tmp_path / "out"
    assert cli.main(["augment", str(source), "-o", str(out), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    found = inspect(open_dataset(out))
    found.refuse_problems()  # what it writes, training takes
    counts = {split: len(examples) for split, examples in found.examples.items()}
    assert counts == {"train": said["images"], "val": 4, "test": 4}
    assert said["images"] + said["dropped"] == 40
    assert said["boxes"] == sum(len(example.boxes) for example in found.examples["train"])
    for kind, ending in (("images", "png"), ("labels", "txt")):
        for i in range(4):
            name = f"{kind}/val/{i}.{ending}"
            assert (out / name).read_bytes() == (source / name).read_bytes()
    sheet = cv2.imread(str(out / "contact_sheet.png"))
    assert sheet.shape == (4 * 320, 6 * 320, 3)
    assert (sheet == (0, 255, 255)).all(axis=2).any()  # boxes are drawn
    summary = json.loads((out / "augmentation.json").read_text())
    assert summary["plan"]["recipe"]["probabilities"]["glass_blur"] == 0.2


def test_the_same_seed_gives_the_same_bytes_with_any_number_of_processes(tmp_path, make_set):
    source = make_set(tmp_path / "set")
    given = ["augment", str(source), "--variants", "3", "--seed", "7"]
    for name, processes in (("one", "1"), ("two", "2")):
        assert cli.main([*given, "-o", str(tmp_path / name), "--processes", processes]) == 0
    assert content(tmp_path / "one") == content(tmp_path / "two")
    sheet = cv2.imread(str(tmp_path / "one" / "contact_sheet.png"))
    assert sheet.shape[1] == 3 * 320  # no columns that nothing is in
    assert cli.main([*given[:-1], "8", "-o", str(tmp_path / "other")]) == 0
    assert content(tmp_path / "one") != content(tmp_path / "other")


def test_an_image_has_the_same_variants_whatever_else_is_in_the_set(tmp_path, make_set):
    source = make_set(tmp_path / "set")
    given = ["augment", str(source), "--variants", "2", "--processes", "1"]
    assert cli.main([*given, "-o", str(tmp_path / "all")]) == 0
    (source / "images" / "train" / "0.png").unlink()
    (source / "labels" / "train" / "0.txt").unlink()
    assert cli.main([*given, "-o", str(tmp_path / "some")]) == 0
    every, some = (content(tmp_path / name / "images") for name in ("all", "some"))
    assert some.items() < every.items()


def test_images_of_the_same_name_do_not_overwrite_each_other(tmp_path, make_set):
    """Every camera begins at DJI_0001; and variants may be augmented once more."""
    source, out = tmp_path / "set", tmp_path / "out"
    for flight in ("first", "second"):
        make_set(source / flight, side=64 if flight == "first" else 80)
    (source / "data.yaml").write_text(
        "train: [first/images/train, second/images/train]\n"
        "val: [first/images/val, second/images/val]\nnames: [aqua]\n"
    )
    given = ["--variants", "1", "--processes", "1", "--keep-originals", "--probability", "crop=0"]
    given += ["--probability", "pad=0", "--probability", "affine=0", "--probability", "rotation=0"]
    assert cli.main(["augment", str(source), "-o", str(out), *given]) == 0
    train = sorted(path.name for path in (out / "images" / "train").iterdir())
    assert len(train) == 16
    assert "first_images_train_0_00.jpg" in train
    assert "second_images_train_0_original.png" in train
    assert len(list((out / "images" / "val").iterdir())) == 8
    assert cli.main(["augment", str(out), "-o", str(tmp_path / "again"), *given]) == 0
    assert len(list((tmp_path / "again" / "images" / "train").iterdir())) == 32


def test_without_operations_images_are_only_cropped(tmp_path, make_set):
    source, out = make_set(tmp_path / "set", side=96, robots=(1, 0)), tmp_path / "out"
    given = ["augment", str(source), "-o", str(out), "--variants", "1", "--size", "64x80"]
    for name in PROBABILITIES:
        given += ["--probability", f"{name}=0"]
    assert cli.main([*given, "--keep-originals"]) == 0
    images = {image.name: image for image in read_folder(out, "train")}
    assert sorted(images) == ["0_00.jpg", "0_original.png", "1_00.jpg", "1_original.png"]
    assert images["0_00.jpg"].read().shape == (80, 64, 3)
    assert len(images["1_00.jpg"].truth.corners) == 0


@pytest.mark.parametrize(("shows", "images"), [("single", "024"), ("several", "123")])
def test_the_papers_two_sets(tmp_path, make_set, shows, images):
    source, out = make_set(tmp_path / "set", robots=(1, 2, 0, 3, 1)), tmp_path / "out"
    given = ["augment", str(source), "-o", str(out), "--variants", "1", "--processes", "1"]
    assert cli.main([*given, "--shows", shows, "--keep-originals"]) == 0
    kept = (out / "images" / "train").glob("*_original.png")
    assert "".join(sorted(path.name[0] for path in kept)) == images
    assert len(list((out / "images" / "val").glob("*.png"))) == 5


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--variants", "0"], "variants must lie within 1"),
        (["--probability", "rotate=1"], "no augmentation 'rotate'"),
        (["--probability", "rotation"], "is not NAME=P"),
        (["--probability", "rotation=2"], "must lie within 0 to 1"),
        (["--processes", "0"], "--processes must lie within"),
        (["--size", "9x9"], "64 to 8192"),
        (["--quality", "0"], "quality must lie within 1"),
    ],
)
def test_wrong_arguments(tmp_path, make_set, capsys, arguments, expected):
    out = tmp_path / "out"
    assert cli.main(["augment", str(make_set(tmp_path / "set")), "-o", str(out), *arguments]) == 2
    assert expected in capsys.readouterr().err
    assert not out.exists()
    assert not list(tmp_path.glob(".*"))


def test_a_killed_process_is_reported_and_leaves_nothing(tmp_path, make_set):
    out = tmp_path / "out"
    arguments = ["augment", str(make_set(tmp_path / "set")), "-o", str(out), "--variants", "2000"]
    command = [sys.executable, "-m", "aerial_gnss_ros.cli", *arguments, "--processes", "2"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        victim = None
        while victim is None:
            assert process.poll() is None
            victim = next(
                filter(None, map(a_worker_of(process.pid), Path("/proc").iterdir())), None
            )
        os.kill(victim, signal.SIGKILL)
        _, said = process.communicate()
    assert process.returncode == 2
    assert "was killed, probably because memory ran out" in said.splitlines()[-1]
    assert not out.exists()
    assert not (tmp_path / ".out.partial").exists()


def a_worker_of(parent):
    """Whether a folder of /proc is of a process of the pool; then its number."""

    def look(path):
        try:
            child = int((path / "stat").read_text().rsplit(")", 1)[1].split()[1]) == parent
            return int(path.name) if child and b"spawn_main" in cmdline(path) else None
        except (OSError, ValueError, IndexError):
            return None

    def cmdline(path):
        return (path / "cmdline").read_bytes()

    return look


def test_a_set_with_errors_is_refused(tmp_path, make_set, capsys):
    source = make_set(tmp_path / "set")
    labels = source / "labels" / "train" / "2.txt"
    labels.write_text("3 0.5 0.5 0.1 0.1\n")
    assert cli.main(["augment", str(source), "-o", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert f"{labels.resolve()}, line 1: class 3 is not in data.yaml" in said
    assert not (tmp_path / "out").exists()
    assert cli.main(["augment", str(tmp_path / "none"), "-o", str(tmp_path / "out")]) == 2
    assert "does not exist; give a folder in YOLO's layout" in capsys.readouterr().err


def test_what_the_simulation_tells_of_held_out_images_stays(tmp_path, make_set):
    source, out = make_set(tmp_path / "set"), tmp_path / "out"
    head = "image,split,scored,left,top,right,bottom,long_px,contrast\n"
    rows = [f"0.png,{split},0,1,2,30,40,38,0.2\n" for split in ("train", "val")]
    (source / "meta.csv").write_text(head + "".join(rows))
    assert cli.main(["augment", str(source), "-o", str(out), "--variants", "1"]) == 0
    assert (out / "meta.csv").read_text() == head + rows[1]
    val = next(iter(read_folder(out, "val")))
    assert val.truth.counted.tolist() == [False]
    train = [image for image in read_folder(out, "train") if image.name.startswith("0")]
    assert all(image.truth.counted.tolist() == [True] for image in train)
