# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trains the second look on photographs of water, and scores it on water that it has not seen.

    python benchmarks/unseen_water.py REAL_WATER -o WORK --rendered FOLDER ... --held-out FOLDER ...
    python benchmarks/unseen_water.py REAL_WATER -o WORK --look MODEL_second_look.onnx

REAL_WATER has a folder for each of `SOURCES`, with images/ and labels.csv, without any robot in
them: every box is false. Rendered robots are composed onto them (`training.composing`). One source
after the other is left out of training, and all figures on real water are of the source left out;
then a network learns from all of them (WORK/second_look.onnx). A stage that is done is kept in
WORK. With `--look` a network that exists is scored in the same way, and nothing trained.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.base import Detections, Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.detection.second_look import SecondLook
from aerial_gnss_ros.detection.second_look_terms import Terms, traits
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.detection.views import views
from aerial_gnss_ros.detection.yolo import iou
from aerial_gnss_ros.resources import model_path
from aerial_gnss_ros.training.clutter import Numbers, write_cluttered
from aerial_gnss_ros.training.compare import labelled
from aerial_gnss_ros.training.composing import (
    Composing,
    photographs_of,
    water_of,
    write_composed,
)
from aerial_gnss_ros.training.labelled import LabelledImage, Truth
from aerial_gnss_ros.training.proposals import Proposals, gather, joined
from aerial_gnss_ros.training.score import Score
from aerial_gnss_ros.training.second_look_network import Network, fill, write
from aerial_gnss_ros.training.second_look_network_fit import fit
from aerial_gnss_ros.training.share import Look, Share, strictest_share

SOURCES = {"northsea_video": 1.0, "lake_nadir": 1.0, "lake_shore": 0.5}
"""Name of each, and the share of its photographs that is taken for water."""
COMPOSED = {"northsea_video": 300, "lake_nadir": 250, "lake_shore": 500}
WITH_ROBOTS = {"northsea_video": 90, "lake_nadir": 90, "lake_shore": 140}
NUMBERS = Numbers(things=9.0)  # of what is drawn into an image
GATHERED_FROM = 0.015  # score of the boxes to learn from; lower than those that are looked at
LENGTH_PX = 24.0  # of robots that a detector is expected to find on real water
THRESHOLDS = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9)
TERMS = Terms(to_score=1.0)
ALL = "nothing"  # left out


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


def composed(given: argparse.Namespace, source: str, kind: str) -> Path:
    """Return the folder of a source's photographs with robots in them, made if it is missing."""
    folder: Path = given.output / f"{kind}_{source}"
    if not folder.is_dir():
        count = (COMPOSED if kind == "composed" else WITH_ROBOTS)[source]
        plan = Composing(
            count, seed=given.seed + (kind != "composed"), calm=SOURCES[source],
            occupied=0.6 if kind == "composed" else 1.0,
        )  # fmt: skip
        place = given.real / source
        write_composed(photographs_of(place / "images", place / "labels.csv"), folder, plan)
    return folder


def cluttered(given: argparse.Namespace, folder: Path) -> Path:
    """Return a folder's images with things of random shape in them, made if it is missing."""
    things: Path = given.output / f"clutter_{folder.name}"
    if not things.is_dir():
        write_cluttered(folder, things, NUMBERS, given.seed, "train")
    return things


def proposals_of(given: argparse.Namespace, key: str, images: Iterable[LabelledImage]) -> Proposals:
    """Return the boxes to learn from, gathered once."""
    file = given.output / f"proposals_{key}.npz"
    if not file.is_file():
        found = gather(_detector(given, GATHERED_FROM), images, TERMS)
        np.savez(file, **{item.name: getattr(found, item.name) for item in fields(found)})
        _say(f"{key}: {len(found)} boxes, {int(found.is_robot.sum())} on robots")
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


def _say(words: str) -> None:
    sys.stdout.write(f"{words}\n")
    sys.stdout.flush()


def looks(second: SecondLook, seen: Sequence[Seen]) -> list[Look]:
    """Return a network's looks at all that the detector has found."""
    made = []
    for one in seen:
        scores = one.found.scores.copy()
        chosen = second.terms.doubtful(scores)
        if len(chosen):
            inputs = traits(one.found.xywh[chosen], one.found.scores[chosen])
            scores[chosen] = second.run(one.views[chosen], inputs)
        made.append(Look(one.found, scores, one.truth))
    return made


def trained(given: argparse.Namespace, left_out: str) -> tuple[Path, Share]:
    """Return a second look trained without one source, or with all of them, and its share."""
    file = given.output / f"without_{left_out}.onnx"
    chosen = file.with_suffix(".json")
    sources = [name for name in SOURCES if name != left_out]
    if not file.is_file():
        parts = [
            proposals_of(given, folder.name, images_of(folder)).times(weight)
            for weight, folders in ((1.0, given.rendered), (given.emphasis, given.emphasised))
            for folder in folders
        ]
        for name in sources:
            folder = composed(given, name, "composed")
            parts.append(proposals_of(given, folder.name, images_of(folder)))
            things = cluttered(given, folder)
            parts.append(proposals_of(given, things.name, images_of(things)))
            parts.append(proposals_of(given, name, photographs(given.real / name)).times(2.0))
        every = joined(parts)
        _say(f"without {left_out}: {len(every)} boxes, {int(every.is_robot.sum())} on robots")
        network = fit(
            every, TERMS, given.steps, given.seed, given.threads,
            lambda step, loss: _say(f"step {step}: loss {loss:.4f}"), given.start,
        )  # fmt: skip
        write(network, TERMS, Share(), file)
    if not chosen.is_file():
        second = SecondLook(file, given.threads)
        groups = [
            looks(second, [s for f in held for s in seen_of(given, f.name, images_of(f))])
            for held in given.held_out
        ]
        # Other robots on the photographs of training: no image of the source left out is used.
        groups.append(
            looks(second, [
                one for name in sources
                for folder in [composed(given, name, "robots")]
                for one in seen_of(given, folder.name, images_of(folder))
            ])
        )  # fmt: skip
        share, false = strictest_share(groups, [*given.least_recall, given.least_composed])
        _say(f"the second look counts {share.weight:g}, shift {share.shift:.2f}: {false:.3f} false")
        chosen.write_text(json.dumps({"weight": share.weight, "shift": share.shift}))
    share = Share(**json.loads(chosen.read_text()))
    if left_out == ALL:
        network = Network()
        fill(network, file)
        write(network.eval(), TERMS, share, given.output / "second_look.onnx")
    return file, share


def shared(look: Look, share: Share) -> Detections:
    """Return the boxes with the scores that the detector with its second look gives."""
    found, _ = look.shared(share.weight)
    odds = np.log(found.scores / (1.0 - found.scores)) + share.shift
    scores = 1.0 / (1.0 + np.exp(-odds))
    return Detections(found.xywh, scores, found.class_ids, found.class_names)


def above(found: Detections, threshold: float) -> Detections:
    """Return the boxes from a score on."""
    kept = found.scores >= threshold
    return Detections(
        found.xywh[kept], found.scores[kept], found.class_ids[kept], found.class_names
    )


def in_area(given: argparse.Namespace, source: str, made: Sequence[Any]) -> list[Any]:
    """Return what was found in the part of each photograph that is taken for water.

    It stands in for an area of operation, since these photographs have no telemetry.
    """
    kept = []
    for name, found, truth in made:
        image = read_image(given.real / source / "images" / name)
        water = water_of(image, SOURCES[source])
        size = np.array(water.shape[::-1])
        columns, rows = np.clip(np.round(found.xywh[:, :2]).astype(int), 0, size - 1).T
        chosen = water[rows, columns]
        inside = Detections(
            found.xywh[chosen], found.scores[chosen], found.class_ids[chosen], found.class_names
        )
        kept.append((name, inside, truth))
    return kept


def on_what(found: Detections, labels: Any, name: str) -> list[str]:
    """Return the class of what each box lies on; nothing labelled: `other`."""
    known = labels.of(name, (0, 0))
    if known is None or not len(known.corners):
        return ["other"] * len(found)
    fits = iou(found.xyxy, known.corners)
    return [known.classes[row.argmax()] if row.max() > 0.1 else "other" for row in fits]


def false_boxes(given: argparse.Namespace, source: str, made: Sequence[Any]) -> str:
    """Return a row: false boxes an image on a source's photographs at each threshold."""
    from collections import Counter

    from aerial_gnss_ros.training.picture_labels import PictureLabels

    labels = PictureLabels(given.real / source / "labels.csv", ())
    counts = [sum(len(above(found, t)) for _, found, _ in made) for t in THRESHOLDS]
    kinds = Counter(
        kind for name, found, _ in made for kind in on_what(above(found, 0.3), labels, name)
    )
    cells = " | ".join(f"{count / len(made):.3f}" for count in counts)
    return f"| {source} | {len(made)} | {cells} | {dict(kinds.most_common())} |"


def robots(source: str, made: Sequence[Any]) -> str:
    """Return a row: robots composed onto a source's photographs that are found."""
    cells = []
    for threshold in THRESHOLDS:
        score = Score()
        for _, found, truth in made:
            long_enough = truth.counted & (truth.long_px >= LENGTH_PX)
            score.add(
                above(found, threshold),
                Truth(truth.corners, long_enough, truth.long_px, truth.contrast, truth.class_ids),
            )
        cells.append(f"{score.overall.recall:.3f}, {score.overall.false / len(made):.2f}")
    return f"| {source} | {score.overall.robots} | {' | '.join(cells)} |"


def finished(seen: Sequence[Seen], file: Path, share: Share, threads: int) -> list[Any]:
    """Return name, boxes and truth of each image, as the detector with a second look has them."""
    second = SecondLook(file, threads)
    return [
        (one.name, shared(look, share), one.truth)
        for one, look in zip(seen, looks(second, seen), strict=True)
    ]


def main() -> None:
    """Train what is missing, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("real", type=Path, metavar="REAL_WATER")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="WORK")
    parser.add_argument("--look", type=Path, metavar="FILE")
    parser.add_argument("--rendered", type=Path, nargs="+", default=[], metavar="FOLDER")
    parser.add_argument("--emphasised", type=Path, nargs="+", default=[], metavar="FOLDER")
    parser.add_argument("--emphasis", type=float, default=3.0)
    parser.add_argument("--held-out", type=Path, nargs="+", action="append", default=[])
    parser.add_argument("--least-recall", type=float, nargs="+", default=[])
    parser.add_argument("--least-composed", type=float, default=0.8)
    parser.add_argument("--test", type=Path, nargs="+", action="append", default=[])
    parser.add_argument("--model", default=DetectorConfig.model)
    parser.add_argument("--start", type=Path, default=model_path("aqua_yolo11n_second_look.onnx"))
    parser.add_argument("--steps", type=int, default=1500)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="+", default=[*SOURCES, ALL])
    given = parser.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    if given.look is not None:
        tell(given, given.look, Share(), tuple(SOURCES))
        return
    for left_out in given.only:
        file, share = trained(given, left_out)
        tell(given, file, share, tuple(SOURCES) if left_out == ALL else (left_out,))


def tell(given: argparse.Namespace, file: Path, share: Share, sources: Sequence[str]) -> None:
    """Print the rows of one network: false boxes, robots found, and rendered images."""
    for source in sources:
        folder = composed(given, source, "robots")
        plain = seen_of(given, f"plain_{source}", photographs(given.real / source))
        with_robots = seen_of(given, folder.name, images_of(folder))
        boxes = finished(plain, file, share, given.threads)
        _say(false_boxes(given, source, boxes))
        if SOURCES[source] < 1.0:
            _say(f"in an area: {false_boxes(given, source, in_area(given, source, boxes))}")
        _say(robots(source, finished(with_robots, file, share, given.threads)))
    for folders in given.test:
        seen = [s for f in folders for s in seen_of(given, f.name, images_of(f))]
        score = Score()
        for _, found, truth in finished(seen, file, share, given.threads):
            score.add(above(found, DetectorConfig.score_threshold), truth)
        overall = score.overall
        _say(
            f"| {folders[0].name} and {len(folders) - 1} more | {overall.robots} | precision "
            f"{overall.precision:.3f} | recall {overall.recall:.3f} |"
        )


if __name__ == "__main__":
    main()
