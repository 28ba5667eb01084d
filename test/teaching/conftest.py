# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A recording that anybody can check: coloured robots on noisy water, under a moving camera."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import pytest

from aerial_gnss_ros.bags.pictures import open_pictures
from aerial_gnss_ros.teaching.recording import extract

SIZE = (640, 360)
COLOURS = {"red": (40, 40, 200), "yellow": (40, 210, 230), "white": (235, 235, 235)}
ROBOT_PX = (30, 18)


@dataclass(frozen=True)
class Film:
    """A folder of images and the true boxes (centre, size) in each, by robot."""

    folder: Path
    truth: list[dict[str, np.ndarray]]


def draw(rng: np.random.Generator, swell: np.ndarray, boxes: dict[str, np.ndarray]) -> np.ndarray:
    """Return water with robots on it: a swell that stays, ripples that do not."""
    ripples = cv2.GaussianBlur(rng.normal(0.0, 6.0, (SIZE[1], SIZE[0])), (0, 0), 1.5)
    image = np.array([110.0, 120.0, 70.0]) + (swell + ripples)[..., None]
    image = np.clip(image, 0, 255).astype(np.uint8)
    for name, box in boxes.items():
        low = np.round(box[:2] - box[2:] / 2).astype(int)
        high = np.round(box[:2] + box[2:] / 2).astype(int)
        colour = COLOURS[name.split("_")[0]]
        cv2.rectangle(image, low.tolist(), (high - 1).tolist(), colour, -1)
    return image


@pytest.fixture
def film(tmp_path: Path) -> Callable[..., Film]:
    """Return a maker of films: places of robots at the start, their speeds, the camera's, px."""

    def make(
        robots: dict[str, tuple[float, float, float, float]],
        count: int = 10,
        camera: tuple[float, float] = (9.0, -4.0),
        hidden: dict[str, range] | None = None,
    ) -> Film:
        folder, rng = tmp_path / "film", np.random.default_rng(5)
        folder.mkdir()
        swell = cv2.GaussianBlur(rng.normal(0.0, 60.0, (SIZE[1], SIZE[0])), (0, 0), 5.0)
        truth = []
        for i in range(count):
            boxes, step = {}, [round(i * speed) for speed in camera]
            for name, (x, y, vx, vy) in robots.items():
                if hidden is None or i not in hidden.get(name, ()):
                    place = np.array([x, y]) + i * (np.array([vx, vy]) + camera)
                    boxes[name] = np.array([*place, *ROBOT_PX])
            truth.append(boxes)
            cv2.imwrite(
                str(folder / f"{i:03d}.png"), draw(rng, np.roll(swell, step, (1, 0)), boxes)
            )
        return Film(folder, truth)

    return make


@pytest.fixture
def work(tmp_path: Path) -> Callable[[Film], Path]:
    """Return a maker of a project's folder with the frames of a film."""

    def make(film: Film) -> Path:
        folder = tmp_path / "work"
        folder.mkdir()
        source = open_pictures(film.folder)
        extract(source, folder, 100, lambda stamps: [None] * len(stamps), lambda _done: None)
        return folder

    return make
