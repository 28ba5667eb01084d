# SPDX-License-Identifier: Apache-2.0
"""Makes labelled image sets for detectors from random scenes, in YOLO's layout."""

from __future__ import annotations

import argparse
import csv
import multiprocessing
import shutil
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np

from aerial_gnss_ros.core.errors import AerialGnssError, ConfigError, OutputError
from aerial_gnss_ros.simulation.labels import RobotLabel
from aerial_gnss_ros.simulation.renderer import Renderer
from aerial_gnss_ros.simulation.scene import random_scene
from aerial_gnss_ros.simulation.staging import Stage, random_stage

CLASS_NAMES = ("aqua",)
SCENE_IMAGES = 5
"""Images made of one random scene: making waves and clouds costs more than a crop."""
# Labelled for training: a little more than what a detector is scored on (labels.py).
LEAST_CONTRAST = 0.05
LEAST_LONG_PX = 10.0
LEAST_VISIBLE_CROP = 0.4
META = (
    "image", "split", "robot_id", "labelled", "scored", "left", "top", "right", "bottom",
    "long_px", "short_px", "depth_m", "contrast", "visible", "height_m", "tilt_deg",
    "wind_mps", "sun_elevation_deg", "sun_light",
)  # fmt: skip


@dataclass(frozen=True)
class DatasetConfig:
    """What to make.

    Attributes:
        counts: Images per split name.
        size: Width and height of the crops; None for whole frames of `image` size.
        seed: Same seed, same bytes. Splits never share a scene.
        occupied: Share of images that have robots.
        image: Camera size in px, None to vary.
        prune: Whether robots that nobody could label (too small, too faint, cut off) are taken
            out of the picture, so that every robot to be seen is labelled. Without it they stay,
            and are listed in meta.csv with `labelled` 0.
    """

    counts: dict[str, int]
    size: tuple[int, int] | None = (320, 320)
    seed: int = 0
    occupied: float = 0.8
    image: tuple[int, int] | None = None
    prune: bool = True


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
        folder: Must not exist; it appears when everything is written.
        config: What to make.
        processes: How many processes share the work; does not change the result.
        progress: Called with images done and in total.

    Raises:
        OutputError: If the folder exists or cannot be written.
        ConfigError: If a count is negative or a crop too small or large.
    """
    if folder.exists():
        raise OutputError(f"{folder} exists already: name a folder that does not")
    if min(config.counts.values(), default=0) < 0:
        raise ConfigError(f"counts are {config.counts}: they must not be negative")
    if config.size is not None and not (32 <= min(config.size) <= max(config.size) <= 720):
        raise ConfigError(f"crops of {config.size} px cannot be made: choose 32 to 720 px a side")
    partial = folder.with_name(f".{folder.name}.partial")
    shutil.rmtree(partial, ignore_errors=True)
    try:
        _write_all(partial, config, processes, progress)
        partial.rename(folder)
    except OSError as error:
        raise OutputError(f"{folder} cannot be written: {error}") from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)


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
        for rows, images in _map(jobs, processes):
            writer.writerows(rows)
            done += images
            if progress is not None:
                progress(done, total)
    names = "\n".join(f"  {i}: {name}" for i, name in enumerate(CLASS_NAMES))
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


def _map(jobs: list[_Job], processes: int) -> Iterator[tuple[list[list[object]], int]]:
    if processes <= 1:
        yield from map(_run, jobs)
        return
    context = multiprocessing.get_context("spawn")
    with context.Pool(processes, initializer=cv2.setNumThreads, initargs=(1,)) as pool:
        yield from pool.imap(_run, jobs, chunksize=4)


def _run(job: _Job) -> tuple[list[list[object]], int]:
    """Makes the images of one scene; rows of meta.csv and the number of images."""
    rng = np.random.default_rng([job.config.seed, job.stream, job.first])
    scene = random_scene(rng)
    if rng.random() < 0.3:
        scene = replace(scene, motion_px=tuple(rng.normal(0.0, 2.0, 2)))
    renderer = Renderer(scene)
    rows: list[list[object]] = []
    for i in range(job.first, job.first + job.count):
        name = f"{job.split}_{i:06d}"
        stage = random_stage(rng, job.config.size, job.config.occupied, job.config.image)
        image, labels = _picture(renderer, stage, float(rng.uniform(0.0, 600.0)), job.config)
        quality = int(rng.integers(45, 97))
        path = job.folder / "images" / job.split / f"{name}.jpg"
        if not cv2.imwrite(str(path), image, [cv2.IMWRITE_JPEG_QUALITY, quality]):
            raise OSError(f"{path} was not written")
        lines = [_line(label, stage) for label in labels if _labelled(label)]
        text = job.folder / "labels" / job.split / f"{name}.txt"
        text.write_text("".join(lines), encoding="ascii")
        about = [
            round(stage.height, 3),
            round(float(np.degrees(stage.tilt)), 2),
            round(scene.wind_speed, 2),
            round(float(np.degrees(scene.sun_elevation)), 1),
            round(scene.sun_light, 3),
        ]
        rows += [_meta(label, stage, path.name, job.split) + about for label in labels]
    return rows, job.count


def _picture(
    renderer: Renderer, stage: Stage, t_s: float, config: DatasetConfig
) -> tuple[np.ndarray, list[RobotLabel]]:
    """The rendered stage; with `prune`, without the robots that cannot be labelled."""
    robots = stage.robots
    for _ in range(4):
        image, labels = renderer.render(
            stage.camera, stage.pose, t_s, robots, stage.props, stage.window
        )
        good = {label.robot_id for label in labels if _labelled(label)}
        if not config.prune or len(good) == len(robots):
            break
        robots = [robot for robot in robots if robot.robot_id in good]
    return image, labels


def _labelled(label: RobotLabel) -> bool:
    return (
        label.contrast >= LEAST_CONTRAST
        and label.visible >= LEAST_VISIBLE_CROP
        and label.long_px >= LEAST_LONG_PX
    )


def _line(label: RobotLabel, stage: Stage) -> str:
    u, v, w, h = label.xywh
    width, height = stage.window.width, stage.window.height
    x, y = (u - stage.window.x + 0.5) / width, (v - stage.window.y + 0.5) / height
    number = CLASS_NAMES.index(label.class_name)
    return f"{number} {x:.6f} {y:.6f} {w / width:.6f} {h / height:.6f}\n"


def _meta(label: RobotLabel, stage: Stage, image: str, split: str) -> list[object]:
    x, y = stage.window.x, stage.window.y
    edges = (label.left - x, label.top - y, label.right - x, label.bottom - y)
    return [
        image, split, label.robot_id, int(_labelled(label)), int(label.scored),
        *(round(e, 2) for e in edges), round(label.long_px, 2), round(label.short_px, 2),
        round(label.depth, 3), round(label.contrast, 4), round(label.visible, 3),
    ]  # fmt: skip


def main(arguments: list[str] | None = None) -> int:
    """`python -m aerial_gnss_ros.simulation.dataset OUT --count N --seed S`."""
    parser = argparse.ArgumentParser(description="Makes labelled pictures of robots at sea.")
    parser.add_argument("out", type=Path)
    parser.add_argument("--count", type=int, default=1000, help="training pictures")
    parser.add_argument("--val", type=int, default=0, help="validation pictures")
    parser.add_argument("--test", type=int, default=0, help="whole 1280x720 test frames instead")
    parser.add_argument("--size", type=int, default=320, help="side of a crop in px")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--processes", type=int, default=2)
    args = parser.parse_args(arguments)
    if args.test:
        config = DatasetConfig(
            {"test": args.test}, None, args.seed, 0.9, image=(1280, 720), prune=False
        )
    else:
        counts = {"train": args.count, "val": args.val}
        config = DatasetConfig(counts, (args.size, args.size), args.seed)
    try:
        generate(args.out, config, args.processes)
    except AerialGnssError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
