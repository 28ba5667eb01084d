# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Composes rendered robots and other things onto photographs of water: labelled training images.

python -m aerial_gnss_ros.training.composing IMAGES --labels labels.csv -o FOLDER --count 500

Every image is a random part of a photograph, turned, mirrored and scaled at random, some with
robots, some without. What the photograph shows already (boats, swimmers, docks, foam, glint,
shores) has no label: a detector learns that it is no robot. Other things are rendered into the
photographs in the same way as robots, so that being rendered is no sign of a robot.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.bags.partial import partial
from aerial_gnss_ros.core.values.errors import AerialGnssError, ConfigError, InputError, OutputError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.images import read_image, write_jpeg
from aerial_gnss_ros.simulation.dataset import ABOUT, META
from aerial_gnss_ros.simulation.filling import Stage, random_stage
from aerial_gnss_ros.simulation.hexapod import RobotState
from aerial_gnss_ros.simulation.labels import RobotLabel
from aerial_gnss_ros.simulation.over_photograph import PhotographRenderer
from aerial_gnss_ros.simulation.robot_models import robot_model
from aerial_gnss_ros.simulation.samples import labelled, moved, only_labelled, view_data
from aerial_gnss_ros.simulation.scene import random_scene
from aerial_gnss_ros.simulation.staging import Variety
from aerial_gnss_ros.simulation.view import project_points
from aerial_gnss_ros.training.layout import write_data_file
from aerial_gnss_ros.training.photographs import Photograph, photographs_of, random_part

SPLIT = "train"
_ROOM = 1.0  # between a robot and a labelled object, lengths of the robot
_QUALITIES = (45, 97)
_SOFTNESS_PX = (0.3, 1.2)


@dataclass(frozen=True)
class Composing:
    """What to make.

    Attributes:
        count: images.
        side: of an image, px.
        seed: same seed and photographs, same bytes.
        occupied: share of the images that have robots.
        scales: least and greatest factor on a photograph's size.
        calm: share of a photograph, the one of least texture, that is taken for water; robots are
            put nowhere else. 1: all of it is water.
        variety: ranges of views, robots and other things.

    Raises:
        ConfigError: a value out of its range.
    """

    count: int
    side: int = 640
    seed: int = 0
    occupied: float = 0.6
    scales: tuple[float, float] = (0.6, 1.5)
    calm: float = 1.0
    variety: Variety = field(
        default_factory=lambda: Variety(
            tilt_deg=(0.0, 60.0), usual_long_px=(18.0, 110.0), distractors=0.6, flotsam=0.4
        )
    )

    def __post_init__(self) -> None:
        for name, value, low, high in (
            ("count", self.count, 1, 1_000_000),
            ("side", self.side, 64, 720),
            ("occupied", self.occupied, 0.0, 1.0),
            ("calm", self.calm, 0.01, 1.0),
            ("scales", self.scales[0], 0.05, self.scales[1]),
            ("scales", self.scales[1], self.scales[0], 10.0),
        ):
            if not low <= value <= high:
                raise ConfigError(f"{name} must lie within {low:g} to {high:g}, but is {value:g}.")


@dataclass(frozen=True)
class Composed:
    """An image with its robots.

    Attributes:
        image: (side, side, 3) blue, green, red.
        labels: of its robots, in its pixels.
        about: further columns of meta.csv.
    """

    image: Image
    labels: list[RobotLabel]
    about: dict[str, float]


def compose(rng: np.random.Generator, part: Photograph, plan: Composing) -> Composed:
    """Return a part of a photograph with robots and other things in it, or without."""
    scene = random_scene(rng)
    stage = random_stage(rng, (plan.side, plan.side), plan.occupied, None, plan.variety)
    robots = [robot for robot in stage.robots if _may_be(robot, stage, part)]
    renderer = PhotographRenderer(scene)
    softness = float(rng.uniform(*_SOFTNESS_PX))
    brightness = float(np.exp(rng.normal(0.0, 0.25)))
    t_s = float(rng.uniform(0.0, 600.0))

    def render(robots: list[RobotState]) -> tuple[Image, list[RobotLabel]]:
        return renderer.draw_into(
            part.image, stage.camera, stage.pose, t_s, robots, stage.props, window=stage.window,
            softness_px=softness, brightness=brightness,
        )  # fmt: skip

    image, labels = only_labelled(render, robots)
    about = view_data(scene, stage.height, stage.tilt)
    return Composed(image, [moved(label, stage.window) for label in labels], about)


def _may_be(robot: RobotState, stage: Stage, part: Photograph) -> bool:
    """Return whether a robot's place is water without anything else on it."""
    course = np.array([np.cos(robot.course), np.sin(robot.course)])
    middle = np.array([robot.east, robot.north])
    ends = np.stack([middle, middle + 0.35 * course, middle - 0.35 * course])
    pixels, seen = project_points(
        stage.camera, stage.pose, np.hstack([ends, np.zeros((len(ends), 1))])
    )
    if not seen.all():
        return False
    pixels = pixels - (stage.window.x, stage.window.y)
    reach = _ROOM * float(np.hypot(*(pixels[1] - pixels[2])))
    u, v = pixels[0]
    objects = part.objects
    near = (objects[:, 0] - reach < u) & (u < objects[:, 2] + reach)
    near &= (objects[:, 1] - reach < v) & (v < objects[:, 3] + reach)
    columns, rows = np.clip(np.round(pixels).astype(int), 0, np.subtract(part.water.shape, 1)).T
    return not near.any() and bool(part.water[rows, columns].all())


def write_composed(
    photographs: Sequence[tuple[Path, NDArray[np.float64]]], folder: Path, plan: Composing
) -> int:
    """Write images/train, labels/train, data.yaml and meta.csv, as `simulate --dataset` does.

    Args:
        photographs: files, and (n, 4) left, top, right, bottom of what is labelled in each, px.
        folder: must not exist; it is created when everything is written.
        plan: what to make.

    Returns:
        Number of robots.

    Raises:
        OutputError: the folder exists or cannot be written.
        InputError: no photographs, or one that cannot be read.
    """
    if folder.exists():
        raise OutputError(f"{folder} exists already; give a new folder.")
    if not photographs:
        raise InputError("there are no photographs to compose robots onto.")
    robots = 0
    with partial(folder) as place:
        for kind in ("images", "labels"):
            (place / kind / SPLIT).mkdir(parents=True)
        with (place / "meta.csv").open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(META)
            for number in range(plan.count):
                rng = np.random.default_rng([plan.seed, number])
                path, objects = photographs[number % len(photographs)]
                made = compose(rng, _part(rng, path, objects, plan), plan)
                name = f"{path.stem}_{number:06d}"
                rows = _write(place, name, made, int(rng.integers(*_QUALITIES)))
                writer.writerows(rows)
                robots += len(rows)
        write_data_file(
            place / "data.yaml",
            [robot_model(plan.variety.robot_model).name],
            {SPLIT: "images/train"},
        )
    return robots


def _part(
    rng: np.random.Generator, path: Path, objects: NDArray[np.float64], plan: Composing
) -> Photograph:
    return random_part(rng, read_image(path), objects, plan.side, plan.scales, plan.calm)


def _write(folder: Path, name: str, made: Composed, quality: int) -> list[list[object]]:
    """Write an image and its labels; return its rows of meta.csv."""
    path = folder / "images" / SPLIT / f"{name}.jpg"
    write_jpeg(path, made.image, quality)
    height, width = made.image.shape[:2]
    lines, rows = [], []
    for label in made.labels:
        u, v, w, h = label.xywh
        row = {
            "image": path.name, "split": SPLIT, "robot_id": label.robot_id,
            "labelled": int(labelled(label)), **label.figures(),
        }  # fmt: skip
        rows.append([*(row[key] for key in META if key not in ABOUT), *made.about.values()])
        if labelled(label):
            place = (u + 0.5) / width, (v + 0.5) / height, w / width, h / height
            lines.append("0 " + " ".join(f"{value:.6f}" for value in place) + "\n")
    (folder / "labels" / SPLIT / f"{name}.txt").write_text("".join(lines), encoding="ascii")
    return rows


def _lengths(text: str) -> tuple[float, float]:
    try:
        low, high = map(float, text.split(","))
    except ValueError:
        low, high = 0.0, 0.0
    if not 0.0 < low <= high <= 600.0:
        raise ConfigError(f"--lengths needs two lengths in px, as 24,110, got {text!r}.")
    return low, high


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line; returns the exit status."""
    parser = argparse.ArgumentParser(prog="composing", description=__doc__.splitlines()[0])
    parser.add_argument("images", type=Path, help="folder of photographs without robots")
    parser.add_argument("--labels", type=Path, help="table of what is in them (labels.csv)")
    parser.add_argument("-o", "--output", type=Path, required=True, help="new folder")
    parser.add_argument("--count", type=int, required=True, help="number of images")
    parser.add_argument("--side", type=int, default=640, help="of an image, px (default 640)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--occupied", type=float, default=0.6, help="share with robots")
    parser.add_argument("--calm", type=float, default=1.0, help="share taken for water (default 1)")
    parser.add_argument("--lengths", help="least and greatest length of most robots, px: 24,110")
    given = parser.parse_args(arguments)
    try:
        plan = Composing(given.count, given.side, given.seed, given.occupied, calm=given.calm)
        if given.lengths:
            lengths = _lengths(given.lengths)
            variety = replace(plan.variety, long_px=lengths, usual_long_px=lengths)
            plan = replace(plan, variety=variety)
        photographs = photographs_of(given.images, given.labels)
        robots = write_composed(photographs, given.output, plan)
    except AerialGnssError as error:
        sys.stderr.write(f"composing: {error}\n")
        return 2
    sys.stdout.write(f"{plan.count} images with {robots} robots in {given.output}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
