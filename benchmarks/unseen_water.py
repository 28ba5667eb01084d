# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trains the second look on photographs of water, and scores it on water that it has not seen.

    python benchmarks/unseen_water.py REAL_WATER -o WORK --rendered FOLDER ... --held-out FOLDER ...
    python benchmarks/unseen_water.py REAL_WATER -o WORK --look MODEL_second_look.onnx

REAL_WATER has a folder for each of `SOURCES`, with images/ and labels.csv, without any robot in
them: every box is false. Rendered robots are composed onto them (`training.composing`). One source
after the other is left out of training, and all figures on real water are of the source left out;
then a network learns from all of them (WORK/second_look.onnx). A stage that is done is kept in
WORK. With `--look` a network that exists is scored in the same way, and nothing trained. `--start`
is a network to go on from, which must not have seen the photographs either (the shipped one has).
`--font` is one with coloured bitmaps, whose pictures are drawn into images (`training.drawings`).
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from unseen_water_tables import SOURCES, above, at_recall, false_boxes, in_area, robots, shared

from aerial_gnss_ros.detection.base import Detections, Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.detection.second_look import SecondLook
from aerial_gnss_ros.detection.second_look_terms import Terms, traits
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.detection.views import views
from aerial_gnss_ros.training.clutter import Numbers, write_cluttered
from aerial_gnss_ros.training.compare import labelled
from aerial_gnss_ros.training.composing import (
    Composing,
    photographs_of,
    write_composed,
)
from aerial_gnss_ros.training.labelled import LabelledImage, Truth
from aerial_gnss_ros.training.proposals import Proposals, gather, joined
from aerial_gnss_ros.training.score import Score
from aerial_gnss_ros.training.second_look_network import Network, fill, write
from aerial_gnss_ros.training.second_look_network_fit import fit
from aerial_gnss_ros.training.share import Look, Share, strictest_share

COMPOSED = {"northsea_video": 300, "lake_nadir": 250, "lake_shore": 500}
WITH_ROBOTS = {"northsea_video": 90, "lake_nadir": 90, "lake_shore": 140}
NUMBERS = {"clutter": Numbers(things=9.0), "crowd": Numbers(3.0, 2.0, 6.0, 6.0)}
"""Of what is drawn into an image, by the kind of the set."""
GATHERED_FROM = 0.015  # score of the boxes to learn from; lower than those that are looked at
FOUND = (0.94, 0.9, 0.85, 0.8)  # shares of the composed robots where false boxes are compared
TERMS = Terms(to_score=1.0, ways=4)
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
            scores[chosen] = second.judged(one.views[chosen], inputs)
        made.append(Look(one.found, scores, one.truth))
    return made


def examples(given: argparse.Namespace, sources: Sequence[str]) -> Proposals:
    """Return the boxes to learn from: on rendered images, and on sources of photographs."""
    folders = [(1.0, f) for f in given.rendered] + [(given.emphasis, f) for f in given.emphasised]
    places = [composed(given, name, "composed") for name in sources]
    folders += [(1.0, place) for place in places]
    folders += [(1.0, t) for f in [*given.cluttered, *places] for t in cluttered(given, f)]
    parts = [proposals_of(given, f.name, images_of(f)).times(weight) for weight, f in folders]
    parts += [
        proposals_of(given, name, photographs(given.real / name)).times(2.0) for name in sources
    ]
    return joined(parts)


def trained(given: argparse.Namespace, left_out: str) -> tuple[Path, Share]:
    """Return a second look trained without one source, or with all of them, and its share."""
    file = given.output / f"without_{left_out}.onnx"
    chosen = file.with_suffix(".json")
    sources = [name for name in SOURCES if name != left_out]
    if not file.is_file():
        every = examples(given, sources)
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
        least = [*given.least_recall, given.least_composed]
        share, false = strictest_share(groups, least, *([[given.weight]] if given.weight else []))
        _say(f"the second look counts {share.weight:g}, shift {share.shift:.2f}: {false:.3f} false")
        chosen.write_text(json.dumps({"weight": share.weight, "shift": share.shift}))
    share = Share(**json.loads(chosen.read_text()))
    if left_out == ALL:
        network = Network()
        fill(network, file)
        write(network.eval(), TERMS, share, given.output / "second_look.onnx")
    return file, share


def finished(
    seen: Sequence[Seen], file: Path, share: Share, threads: int, ways: int | None = None
) -> list[Any]:
    """Return name, boxes and truth of each image, as the detector with a second look has."""
    second = SecondLook(file, threads)
    if ways is not None:
        second.terms = replace(second.terms, ways=ways)
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
    parser.add_argument("--weight", type=float, help="of the second look; default: chosen")
    parser.add_argument("--ways", type=int, help="other than the network's, to look at boxes in")
    parser.add_argument("--font", type=Path, metavar="FILE")
    parser.add_argument("--rendered", type=Path, nargs="+", default=[], metavar="FOLDER")
    parser.add_argument("--emphasised", type=Path, nargs="+", default=[], metavar="FOLDER")
    parser.add_argument("--emphasis", type=float, default=3.0)
    parser.add_argument("--cluttered", type=Path, nargs="+", default=[], metavar="FOLDER")
    parser.add_argument("--held-out", type=Path, nargs="+", action="append", default=[])
    parser.add_argument("--least-recall", type=float, nargs="+", default=[])
    parser.add_argument("--least-composed", type=float, default=0.8)
    parser.add_argument("--test", type=Path, nargs="+", action="append", default=[])
    parser.add_argument("--found", type=float, nargs="+", default=FOUND, help="shares of robots")
    parser.add_argument("--model", default=DetectorConfig.model)
    parser.add_argument("--start", type=Path, metavar="FILE")
    parser.add_argument("--steps", type=int, default=3000)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="+", default=[*SOURCES, ALL])
    given = parser.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    if given.look is not None:
        sources = [source for source in given.only if source != ALL]
        tell(given, given.look, Share(given.weight or 1.0), sources)
        return
    for left_out in given.only:
        file, share = trained(given, left_out)
        tell(given, file, share, tuple(SOURCES) if left_out == ALL else (left_out,))


def tell(given: argparse.Namespace, file: Path, share: Share, sources: Sequence[str]) -> None:
    """Print the rows of one network: false boxes, robots found, and rendered images."""
    for source in sources:
        place = composed(given, source, "robots")
        plain = seen_of(given, f"plain_{source}", photographs(given.real / source))
        with_robots = seen_of(given, place.name, images_of(place))
        boxes = finished(plain, file, share, given.threads, given.ways)
        folder = given.real / source
        _say(false_boxes(folder, boxes))
        if SOURCES[source] < 1.0:
            _say(f"in an area: {false_boxes(folder, in_area(folder, boxes))}")
        found = finished(with_robots, file, share, given.threads, given.ways)
        _say(robots(source, found))
        for row in at_recall(folder, boxes, found, given.found):
            _say(row)
    for folders in given.test:
        seen = [s for f in folders for s in seen_of(given, f.name, images_of(f))]
        score = Score()
        for _, found, truth in finished(seen, file, share, given.threads, given.ways):
            score.add(above(found, DetectorConfig.score_threshold), truth)
        overall = score.overall
        _say(
            f"| {folders[0].name} and {len(folders) - 1} more | {overall.robots} | precision "
            f"{overall.precision:.3f} | recall {overall.recall:.3f} |"
        )


if __name__ == "__main__":
    main()
