# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Images of `unseen_water.py`, each made once, and the boxes that the detector finds in them."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, fields
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from unseen_water_tables import SOURCES

from aerial_gnss_ros.detection.base import Detections, Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.detection.second_look_terms import Terms
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.detection.views import views
from aerial_gnss_ros.training.clutter import Numbers, write_cluttered
from aerial_gnss_ros.training.compare import labelled
from aerial_gnss_ros.training.composing import Composing, write_composed
from aerial_gnss_ros.training.labelled import LabelledImage, Truth
from aerial_gnss_ros.training.photographs import photographs_of
from aerial_gnss_ros.training.proposals import Proposals, gather

COMPOSED = {"northsea_video": 150, "lake_nadir": 125, "lake_shore": 200}
SETS = 4  # of so many composed images of each source
WITH_ROBOTS = {"northsea_video": 90, "lake_nadir": 90, "lake_shore": 140}
NUMBERS = {"clutter": Numbers(things=9.0), "crowd": Numbers(3.0, 2.0, 6.0, 6.0)}
"""Of what is drawn into an image, by the kind of the set."""
PHOTOGRAPHS_COUNT = 2.0  # times as much as composed images
GATHERED_FROM = 0.015  # score of the boxes to learn from; lower than those that are looked at
TERMS = Terms(to_score=1.0, ways=4)


@dataclass(frozen=True)
class Seen:
    """What a detector finds in an image, with the views for the second look."""

    name: str
    found: Detections
    views: NDArray[np.uint8]
    truth: Truth


def nothing() -> Truth:
    """Return the truth of a photograph without robots."""
    none = np.zeros(0)
    return Truth(np.zeros((0, 4)), np.zeros(0, bool), none, none, np.zeros(0, np.int64))


def photographs(folder: Path) -> Iterator[LabelledImage]:
    """Yield a source's photographs, in which nothing is a robot."""
    for path, _ in photographs_of(folder / "images", None):
        yield LabelledImage(path.name, nothing(), lambda path=path: read_image(path))


def images_of(folder: Path) -> Iterable[LabelledImage]:
    """Yield the labelled images of a flight or of a data set's only split."""
    if not (folder / "images").is_dir():
        return labelled(folder, "train")
    splits = [s for s in ("train", "test", "val") if any((folder / "images" / s).glob("*"))]
    return labelled(folder, splits[0])


def composed(given: argparse.Namespace, source: str, name: str, plan: Composing) -> Path:
    """Return a folder of a source's photographs with robots in them, made if it is missing."""
    folder: Path = given.output / name
    if not folder.is_dir():
        place = given.real / source
        write_composed(photographs_of(place / "images", place / "labels.csv"), folder, plan)
    return folder


def cluttered(given: argparse.Namespace, folder: Path) -> Iterator[Path]:
    """Yield a folder's images with other things in them, made if they are missing."""
    for kind, numbers in NUMBERS.items():
        things: Path = given.output / f"{kind}_{folder.name}"
        if numbers.drawings and given.font is None:
            continue
        if not things.is_dir():
            seed = given.seed + list(NUMBERS).index(kind)
            write_cluttered(folder, things, numbers, seed, "train", given.font)
        yield things


def proposals_of(given: argparse.Namespace, key: str, images: Iterable[LabelledImage]) -> Proposals:
    """Return the boxes to learn from, gathered once."""
    file = given.output / f"proposals_{key}.npz"
    if not file.is_file():
        found = gather(_detector(given, GATHERED_FROM), images, TERMS)
        np.savez(file, **{item.name: getattr(found, item.name) for item in fields(found)})
    with np.load(file) as stored:
        return Proposals(**{item.name: stored[item.name] for item in fields(Proposals)})


def seen_of(given: argparse.Namespace, key: str, images: Iterable[LabelledImage]) -> list[Seen]:
    """Return what the detector finds in images to score on, found once."""
    file = given.output / f"seen_{key}.npz"
    if not file.is_file():
        detector, kept = _detector(given, TERMS.from_score), []
        for image in images:
            pixels = image.read()
            found = detector.detect(pixels)
            kept.append(Seen(image.name, found, views(pixels, found.xywh, TERMS), image.truth))
        np.savez(file, seen=np.array([*kept, None], dtype=object))
    with np.load(file, allow_pickle=True) as stored:  # our own file of a moment ago
        return list(stored["seen"][:-1])


_detectors: dict[float, Detector] = {}


def _detector(given: argparse.Namespace, score: float) -> Detector:
    if score not in _detectors:
        config = DetectorConfig(
            model=given.model, score_threshold=score, second_look="off", threads=given.threads
        )
        _detectors[score] = load_detector(config)
    return _detectors[score]


def learnt_from(given: argparse.Namespace, folder: Path) -> list[Proposals]:
    """Return the boxes of a folder's images, and of the same with other things in them."""
    folders = [folder, *(cluttered(given, folder) if folder in given.cluttered else [])]
    return [proposals_of(given, one.name, images_of(one)) for one in folders]


def composed_from(given: argparse.Namespace, source: str, k: int) -> list[Proposals]:
    """Return the boxes of a source's composed images, the k-th set, and with other things."""
    plan = Composing(COMPOSED[source], seed=given.seed + 10 * k, calm=SOURCES[source])
    place = composed(given, source, f"composed{k}_{source}", plan)
    folders = [place, *cluttered(given, place)]
    return [proposals_of(given, one.name, images_of(one)) for one in folders]


def refused_of(given: argparse.Namespace, source: str) -> list[Proposals]:
    """Return the boxes on a source's photographs themselves: no robots."""
    images = photographs(given.real / source)
    return [proposals_of(given, source, images).times(PHOTOGRAPHS_COUNT)]


def scored_on(given: argparse.Namespace, source: str) -> tuple[list[Seen], list[Seen]]:
    """Return what is found on a source's photographs, and on the same with robots in all."""
    plan = Composing(
        WITH_ROBOTS[source], seed=given.seed + 1, calm=SOURCES[source], occupied=1.0
    )  # fmt: skip
    place = composed(given, source, f"robots_{source}", plan)
    plain = seen_of(given, f"plain_{source}", photographs(given.real / source))
    return plain, seen_of(given, place.name, images_of(place))


def prepare(given: argparse.Namespace) -> None:
    """Make and search all images, `given.jobs` sets at a time."""
    sets = [
        *((composed_from, source, k) for k in range(SETS) for source in SOURCES),
        *((scored_on, source) for source in SOURCES),
        *((refused_of, source) for source in SOURCES),
        *((learnt_from, folder) for folder in [*given.rendered, *given.emphasised]),
    ]
    with ProcessPoolExecutor(given.jobs, get_context("spawn")) as pool:
        for done in [pool.submit(_made, given, *one) for one in sets]:
            done.result()


def _made(given: argparse.Namespace, function: Callable[..., Any], *args: Any) -> None:
    """Call for what is stored, not for what is returned: it need not travel."""
    function(given, *args)
