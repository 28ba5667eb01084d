# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Training sets: layout, labels that agree with meta.csv, same bytes from one process or two."""

from __future__ import annotations

import csv
import subprocess
import sys
from pathlib import Path

import cv2
import pytest

from aerial_gnss_ros.core.values.errors import ConfigError, OutputError
from aerial_gnss_ros.simulation.dataset import DatasetConfig, generate


def _files(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_processes_do_not_change_a_byte_and_seeds_do(tmp_path: Path) -> None:
    """The work is seeded by image, not by worker."""
    config = DatasetConfig({"train": 6, "val": 2}, (160, 160), seed=3)
    generate(tmp_path / "one", config, processes=1)
    generate(tmp_path / "two", config, processes=2)
    one, two = _files(tmp_path / "one"), _files(tmp_path / "two")
    assert one == two
    assert len(one) == 2 * 8 + 2
    generate(tmp_path / "other", DatasetConfig({"train": 6, "val": 2}, (160, 160), seed=4))
    assert one["meta.csv"] != (tmp_path / "other" / "meta.csv").read_bytes()


def test_label_files_repeat_meta_in_yolo_convention(tmp_path: Path) -> None:
    """Each labelled row of meta.csv is a line, half a pixel further (YOLO counts from the edge)."""
    progress: list[tuple[int, int]] = []
    config = DatasetConfig({"train": 12}, (200, 160), seed=5, occupied=1.0)
    generate(tmp_path / "set", config, progress=lambda done, total: progress.append((done, total)))
    assert progress[-1] == (12, 12)
    with (tmp_path / "set" / "meta.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["labelled"] == "1"]
    assert len(rows) >= 8
    lines: dict[str, list[list[float]]] = {}
    for path in sorted((tmp_path / "set" / "labels" / "train").iterdir()):
        image = cv2.imread(str(tmp_path / "set" / "images" / "train" / f"{path.stem}.jpg"))
        assert image is not None
        assert image.shape == (160, 200, 3)
        text = path.read_text(encoding="ascii")
        lines[path.stem] = [[float(x) for x in line.split()] for line in text.splitlines()]
    assert sum(map(len, lines.values())) == len(rows)
    for row in rows:
        _, x, y, w, h = lines[Path(row["image"]).stem].pop(0)
        assert x * 200 - w * 100 - 0.5 == pytest.approx(float(row["left"]), abs=0.01)
        assert y * 160 + h * 80 - 0.5 == pytest.approx(float(row["bottom"]), abs=0.01)
        assert float(row["contrast"]) >= 0.05
        assert float(row["long_px"]) >= 10.0


@pytest.mark.parametrize(
    "config",
    [
        DatasetConfig({"train": -1}),
        DatasetConfig({}, (320, 2000)),
        DatasetConfig({"train": 1}, renderer="oils"),
    ],
)
def test_what_cannot_be_made_is_refused(tmp_path: Path, config: DatasetConfig) -> None:
    """The message has the value seen."""
    with pytest.raises(ConfigError, match=r"-1|2000|oils"):
        generate(tmp_path / "set", config)


def test_an_existing_folder_is_left_alone(tmp_path: Path) -> None:
    """Nothing is overwritten, and nothing half-written stays behind."""
    (tmp_path / "set").mkdir()
    with pytest.raises(OutputError, match="exists already"):
        generate(tmp_path / "set", DatasetConfig({"train": 1}))
    assert [path.name for path in tmp_path.iterdir()] == ["set"]


@pytest.mark.parametrize("processes", [1, 2])
def test_a_full_disk_is_a_sentence_and_leaves_nothing(tmp_path: Path, processes: int) -> None:
    """A limit for files stands for the disk's end."""
    done = subprocess.run(
        [sys.executable, "-c", IN_ANOTHER_PROCESS, tmp_path / "set", str(processes)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2, done.stderr
    [sentence] = [line for line in done.stderr.splitlines() if line.startswith("aerial-gnss: ")]
    assert f"{tmp_path / 'set'} cannot be written: File too large" in sentence
    assert "Traceback" not in done.stderr
    assert list(tmp_path.iterdir()) == []


IN_ANOTHER_PROCESS = """
import resource, sys
from aerial_gnss_ros import cli
if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
    sys.exit(cli.main(["simulate", "--dataset", sys.argv[1], "--count", "2",
                       "--processes", sys.argv[2]]))
"""
