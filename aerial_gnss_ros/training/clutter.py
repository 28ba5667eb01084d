# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Draws things of random shape and colour into labelled images, as examples of what is no robot.

python -m aerial_gnss_ros.training.clutter FOLDER -o CLUTTERED

A detector of rendered robots takes almost anything small and colourful on the water for one,
because it has seen too few other things. Real things are scarce and differ from water to water;
these cost nothing and are endless: bodies with limbs, rings, planks, foliage, stones; people;
figures of random parts, which may bear the paints of the robots of other images (`figures.py`); and
the pictures of a colour font (`drawings.py`). None has the shape of a robot. Robots that are
labelled in an image stay uncovered.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.bags.partial import partial
from aerial_gnss_ros.core.values.errors import AerialGnssError, ConfigError, OutputError
from aerial_gnss_ros.detection.base import Image
from aerial_gnss_ros.detection.images import write_jpeg
from aerial_gnss_ros.training.drawings import Picture, drawing, pictures_of
from aerial_gnss_ros.training.figures import figure
from aerial_gnss_ros.training.labelled import read_labels
from aerial_gnss_ros.training.people import person
from aerial_gnss_ros.training.shapes import F32, field, shape, texture

LENGTHS_PX = (12.0, 110.0)
_LAND = 0.2  # share of the images a part of which is covered
_GROUPED = 0.5  # share of the figures that have some alike beside them
_QUALITIES = (50, 97)
_PAINTS = 100  # robots whose colours are used


@dataclass(frozen=True)
class Numbers:
    """Mean numbers of what is drawn into an image.

    Attributes:
        things: bodies, rings, planks, stones; 0: no land either.
        people: people in the water.
        figures: figures of several parts and colours.
        drawings: pictures of a font.
    """

    things: float = 8.0
    people: float = 0.0
    figures: float = 0.0
    drawings: float = 0.0


def add_things(
    rng: np.random.Generator,
    image: Image,
    robots: NDArray[np.float64],
    numbers: Numbers,
    paints: Sequence[Image] = (),
    glyphs: Sequence[Picture] = (),
    lengths_px: tuple[float, float] = LENGTHS_PX,
) -> Image:
    """Return an image with things in it that are no robots, none of them on a robot.

    Args:
        rng: all randomness.
        image: (height, width, 3) blue, green, red.
        robots: (n, 4) left, top, right, bottom of the robots, px.
        numbers: of each kind, in the mean.
        paints: pictures of robots, whose colours figures may bear in another order.
        glyphs: pictures to draw.
        lengths_px: least and greatest of everything.
    """
    made = image.astype(np.float32)
    if rng.random() < _LAND and numbers.things > 0.0:
        _cover(rng, made, robots)
    for _ in range(int(rng.poisson(numbers.things))):
        length = float(np.exp(rng.uniform(*np.log(lengths_px))))
        coverage = shape(rng, length)
        place = _place(rng, image, len(coverage), robots)
        if place is not None:
            side = len(coverage)
            colours = texture(rng, (side, side), length * rng.uniform(0.1, 0.7))
            _draw(rng, made, place, coverage, colours)
    for _ in range(int(rng.poisson(numbers.people)) if numbers.people else 0):
        coverage, colours = person(rng, float(np.exp(rng.uniform(*np.log(lengths_px)))))
        place = _place(rng, image, len(coverage), robots)
        if place is not None:
            _draw(rng, made, place, coverage, colours)
    for _ in range(int(rng.poisson(numbers.figures)) if numbers.figures else 0):
        drawn = figure(rng, float(np.exp(rng.uniform(*np.log(lengths_px)))), paints)
        _draw_group(rng, made, robots, drawn)
    for _ in range(int(rng.poisson(numbers.drawings)) if numbers.drawings else 0):
        drawn = drawing(rng, float(np.exp(rng.uniform(*np.log(lengths_px)))), glyphs)
        _draw_group(rng, made, robots, drawn)
    return np.clip(np.round(made), 0, 255).astype(np.uint8)


def _place(
    rng: np.random.Generator, image: Image | F32, side: int, robots: NDArray[np.float64]
) -> tuple[int, int] | None:
    """Return left and top of a thing; None if it would touch a robot."""
    x, y = (int(rng.integers(-side // 3, size - side // 2)) for size in image.shape[1::-1])
    return None if _touches((x, y, x + side, y + side), robots, 0.3 * side) else (x, y)


def _draw_group(
    rng: np.random.Generator, made: F32, robots: NDArray[np.float64], drawn: tuple[F32, F32]
) -> None:
    """Draw a figure into an image, perhaps with some alike beside it, as people swim together.

    Two things apart have the ends of one long robot of which only the ends stand out.
    """
    side = len(drawn[0])
    first = _place(rng, made, side, robots)
    if first is None:
        return
    _draw(rng, made, first, *drawn)
    for _ in range(int(rng.integers(1, 4)) if rng.random() < _GROUPED else 0):
        angle, away = rng.uniform(0.0, 2.0 * np.pi), rng.uniform(0.6, 3.0) * side
        x, y = (
            round(a + away * b) for a, b in zip(first, (np.cos(angle), np.sin(angle)), strict=True)
        )
        if not _touches((x, y, x + side, y + side), robots, 0.3 * side):
            turns = int(rng.integers(4))
            _draw(rng, made, (x, y), *(np.rot90(one, turns) for one in drawn))


def _draw(
    rng: np.random.Generator, made: F32, place: tuple[int, int], coverage: F32, colours: F32
) -> None:
    """Draw a thing into an image, softened, and perhaps under water."""
    side, (x, y) = len(coverage), place
    height, width = made.shape[:2]
    softness = float(rng.uniform(0.3, 1.2))
    share = np.asarray(cv2.GaussianBlur(coverage, (0, 0), softness), np.float32)
    share *= np.float32(1.0 if rng.random() < 0.7 else rng.uniform(0.25, 1.0))  # under water
    left, top = max(x, 0), max(y, 0)
    right, bottom = min(x + side, width), min(y + side, height)
    if right <= left or bottom <= top:
        return
    inner = slice(top - y, bottom - y), slice(left - x, right - x)
    here = made[top:bottom, left:right]
    here += share[inner][..., None] * (colours[inner] - here)


def _touches(
    box: tuple[float, float, float, float], robots: NDArray[np.float64], margin: float
) -> bool:
    left, top, right, bottom = box
    return bool((
        (robots[:, 0] < right + margin) & (robots[:, 2] > left - margin)
        & (robots[:, 1] < bottom + margin) & (robots[:, 3] > top - margin)
    ).any())  # fmt: skip


def _cover(rng: np.random.Generator, made: F32, robots: NDArray[np.float64]) -> None:
    """Cover a part of an image with something like foliage, stones or planks."""
    height, width = made.shape[:2]
    size = (width, height)
    across = field(rng, size, float(rng.uniform(60.0, 400.0)))
    edge = np.clip((across - rng.uniform(-0.5, 1.0)) * rng.uniform(4.0, 40.0), -30.0, 30.0)
    share = 1.0 / (1.0 + np.exp(-edge))
    for left, top, right, bottom in robots:
        reach = max(right - left, bottom - top)
        x, y = (left + right) / 2, (top + bottom) / 2
        away = np.hypot(np.arange(width)[None] - x, np.arange(height)[:, None] - y)
        share *= np.clip((away - 1.5 * reach) / (0.5 * reach + 1.0), 0.0, 1.0)
    grain = float(np.exp(rng.uniform(np.log(4.0), np.log(60.0))))
    colours = texture(rng, size, grain)
    made += share.astype(np.float32)[..., None] * (colours - made)


def pictures(image: Image, robots: NDArray[np.float64]) -> list[Image]:
    """Return an image's robots, cut out along their boxes (n, 4); not those cut by its edge."""
    height, width = image.shape[:2]
    found = []
    for left, top, right, bottom in np.round(robots).astype(int):
        if left >= 0 and top >= 0 and right < width and bottom < height:
            found.append(image[top : bottom + 1, left : right + 1])
    return found


def write_cluttered(
    folder: Path, output: Path, numbers: Numbers, seed: int, split: str, font: Path | None = None
) -> int:
    """Write a data set's images again, with things in them; labels stay.

    Args:
        folder: in YOLO's layout; its meta.csv is copied, too.
        output: must not exist; it is created when everything is written.
        numbers: of each kind in an image, in the mean.
        seed: same seed, same bytes.
        split: which images.
        font: with the pictures to draw.

    Returns:
        Number of images.

    Raises:
        OutputError: the output exists or cannot be written.
        ConfigError: a negative number of things, or drawings without a font.
        InputError: no images, or a label that cannot be read.
    """
    if output.exists():
        raise OutputError(f"{output} exists already; give a new folder.")
    for name, value in asdict(numbers).items():
        if not value >= 0.0:
            raise ConfigError(f"--{name} must be 0 or more, got {value:g}.")
    if numbers.drawings and font is None:
        raise ConfigError("--drawings needs --font, a font with coloured bitmaps.")
    glyphs = [] if font is None else pictures_of(font)
    count, paints = 0, list[Image]()
    with partial(output) as place:
        (place / "images" / split).mkdir(parents=True)
        (place / "labels").mkdir()
        for labelled in read_labels(folder, split):
            rng = np.random.default_rng([seed, count])
            before, robots = labelled.read(), labelled.truth.corners
            image = add_things(rng, before, robots, numbers, paints, glyphs)
            paints = [*paints, *pictures(before, robots)][-_PAINTS:]
            path = place / "images" / split / labelled.name
            write_jpeg(path.with_suffix(".jpg"), image, int(rng.integers(*_QUALITIES)))
            count += 1
        shutil.copytree(folder / "labels" / split, place / "labels" / split)
        for name in ("meta.csv", "data.yaml"):
            if (folder / name).is_file():
                shutil.copyfile(folder / name, place / name)
    return count


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line; returns the exit status."""
    parser = argparse.ArgumentParser(prog="clutter", description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="labelled images in YOLO's layout")
    parser.add_argument("-o", "--output", type=Path, required=True, help="new folder")
    parser.add_argument("--things", type=float, default=8.0, help="mean number of things")
    parser.add_argument("--people", type=float, default=0.0, help="mean number of people")
    parser.add_argument("--figures", type=float, default=0.0, help="mean number of figures")
    parser.add_argument("--drawings", type=float, default=0.0, help="mean number of pictures")
    parser.add_argument("--font", type=Path, help="of the pictures, as NotoColorEmoji.ttf")
    parser.add_argument("--split", default="train")
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args(arguments)
    try:
        numbers = Numbers(given.things, given.people, given.figures, given.drawings)
        count = write_cluttered(
            given.folder, given.output, numbers, given.seed, given.split, given.font
        )
    except AerialGnssError as error:
        sys.stderr.write(f"clutter: {error}\n")
        return 2
    sys.stdout.write(f"{count} images in {given.output}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
