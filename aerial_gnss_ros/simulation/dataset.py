# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Makes labelled image sets for detectors from random scenes, in YOLO's layout."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aerial_gnss_ros.bags.partial import partial
from aerial_gnss_ros.core.values.errors import ConfigError, OutputError
from aerial_gnss_ros.detection.images import write_jpeg
from aerial_gnss_ros.simulation.labels import RobotLabel
from aerial_gnss_ros.simulation.robot_models import robot_model
from aerial_gnss_ros.simulation.sample_source import sample_source
from aerial_gnss_ros.simulation.samples import DatasetConfig, labelled
from aerial_gnss_ros.simulation.workers import shared

SCENE_IMAGES = 5
"""Number of images per random scene: generating waves and clouds costs more than a crop."""
_KILLED = (
    "a rendering process was killed, probably because memory ran out; try again with fewer "
    "--processes."
)
ABOUT = ("height_m", "tilt_deg", "wind_mps", "sun_elevation_deg", "sun_light")
META = (
    "image", "split", "robot_id", "labelled", "scored", "left", "top", "right", "bottom",
    "long_px", "short_px", "depth_m", "contrast", "visible", *ABOUT,
)  # fmt: skip


def generate(
    folder: Path,
    config: DatasetConfig,
    processes: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> None:
    """Writes images/<split>/*.jpg, labels/<split>/*.txt, data.yaml and meta.csv.

    Label rows are `class cx cy w h`, relative to the image, whose first pixel spans 0 to 1 (YOLO's
    convention; the boxes in meta.csv are OpenCV's, where the first pixel's centre is 0).

    Args:
        folder: Must not exist; it is created when everything is written.
        config: What to make.
        processes: Number of worker processes; does not change the result.
        progress: Called with images done and in total.

    Raises:
        OutputError: If the folder exists or cannot be written, or a process was killed.
        ConfigError: If a count is negative or a crop too small or large.
    """
    if folder.exists():
        raise OutputError(f"{folder} exists already; give a new folder.")
    if min(config.counts.values(), default=0) < 0:
        raise ConfigError(f"counts are {config.counts}: they must not be negative")
    if config.size is not None and not (32 <= min(config.size) <= max(config.size) <= 720):
        raise ConfigError(f"crops of {config.size} px cannot be made: choose 32 to 720 px a side")
    with partial(folder) as place:
        _write_all(place, config, processes, progress)


def _write_all(
    folder: Path,
    config: DatasetConfig,
    processes: int,
    progress: Callable[[int, int], None] | None,
) -> None:
    for split in config.counts:
        (folder / "images" / split).mkdir(parents=True)
        (folder / "labels" / split).mkdir(parents=True)
    jobs = list(_jobs(folder, config))
    total, done = sum(config.counts.values()), 0
    with (folder / "meta.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(META)
        for rows, images in shared(_run, jobs, processes, _KILLED):
            writer.writerows(rows)
            done += images
            if progress is not None:
                progress(done, total)
    names = f"  0: {robot_model(config.variety.robot_model).name}"
    splits = "\n".join(f"{split}: images/{split}" for split in config.counts)
    (folder / "data.yaml").write_text(f"{splits}\nnames:\n{names}\n", encoding="utf-8")


@dataclass(frozen=True)
class _Job:
    folder: Path
    config: DatasetConfig
    split: str
    stream: int
    first: int
    count: int


def _jobs(folder: Path, config: DatasetConfig) -> Iterator[_Job]:
    for stream, (split, count) in enumerate(config.counts.items()):
        for first in range(0, count, SCENE_IMAGES):
            yield _Job(folder, config, split, stream, first, min(SCENE_IMAGES, count - first))


def _run(job: _Job) -> tuple[list[list[object]], int]:
    """Makes the images of one scene; rows of meta.csv and the number of images."""
    rng = np.random.default_rng([job.config.seed, job.stream, job.first])
    rows: list[list[object]] = []
    # The quality is drawn from its own stream, so that another draw in an image does not change the
    # rest.
    qualities = rng.spawn(1)[0].integers(45, 97, job.count)
    for i, sample in enumerate(sample_source(job.config).samples(rng, job.count)):
        name = f"{job.split}_{job.first + i:06d}"
        path = job.folder / "images" / job.split / f"{name}.jpg"
        write_jpeg(path, sample.image, int(qualities[i]))
        height, width = sample.image.shape[:2]
        lines = [_line(label, width, height) for label in sample.labels if labelled(label)]
        text = job.folder / "labels" / job.split / f"{name}.txt"
        text.write_text("".join(lines), encoding="ascii")
        about = [sample.about[key] for key in ABOUT]
        rows += [_meta(label, path.name, job.split) + about for label in sample.labels]
    return rows, job.count


def _line(label: RobotLabel, width: int, height: int) -> str:
    u, v, w, h = label.xywh
    x, y = (u + 0.5) / width, (v + 0.5) / height
    return f"0 {x:.6f} {y:.6f} {w / width:.6f} {h / height:.6f}\n"


def _meta(label: RobotLabel, image: str, split: str) -> list[object]:
    known = {"image": image, "split": split, "robot_id": label.robot_id}
    row = {**known, "labelled": int(labelled(label)), **label.figures()}
    return [row[name] for name in META if name not in ABOUT]
