# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""How many right labels a few clicks give: on labelled images, and on simulated flights.

A simulated person clicks the middle of an object that has no box yet, in the frame with the most of
them, until none is left; then says yes once to each robot that is asked about and has a right box.
A carried box is right if it overlaps a label (intersection over union) by half, or if their centres
are within 8 px; each label counts once. "Carried" boxes are those that are sure.

python benchmarks/teach.py IMAGES --labels labels.csv --kind swimmer --first 31
python benchmarks/teach.py FLIGHT_BAG

With --train a detector is trained on these labels, and scored on the images that are not among the
--first, or on another flight of the same robots (--score). Every box on no robot is false, two on
one robot count once.
"""

from __future__ import annotations

import argparse
import json
import shutil
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.bags.pictures import IMAGE_ENDINGS, open_pictures
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.teaching.clicks import Click
from aerial_gnss_ros.teaching.dataset import write_dataset
from aerial_gnss_ros.teaching.learning import NETWORK, Plan, learn
from aerial_gnss_ros.teaching.recording import Recording, extract
from aerial_gnss_ros.teaching.session import Session
from aerial_gnss_ros.teaching.telemetry import bag_views
from aerial_gnss_ros.teaching.tracks import Sight, overlap
from aerial_gnss_ros.text.json_text import parse_json
from aerial_gnss_ros.training.labelled import LabelledImage, Truth
from aerial_gnss_ros.training.labelled_bag import read_bag
from aerial_gnss_ros.training.picture_labels import PictureLabels
from aerial_gnss_ros.training.score import match

Array = NDArray[np.float64]
Labels = list[list[tuple[str, Array, str]]]
"""Class, box (centre, size) and robot (empty: unknown) of each label, by frame."""
RIGHT_IOU, RIGHT_PX = 0.5, 8.0
COVERED_IOU = 0.1
MOST_CLICKS = 20


@dataclass
class Count:
    """Labels and boxes compared."""

    clicks: int = 0
    right: int = 0
    false: int = 0
    beside: int = 0
    unsure: int = 0
    labels: int = 0

    def line(self) -> str:
        """Return the figures as text."""
        precision = self.right / max(1, self.right + self.false)
        return (
            f"clicks {self.clicks}, right {self.right} ({self.right / max(1, self.clicks):.1f} a "
            f"click), false {self.false} (of these on an object, but off: {self.beside}), unsure "
            f"{self.unsure}, labels {self.labels}: precision {precision:.3f}, recall "
            f"{self.right / max(1, self.labels):.3f}"
        )


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("recording", type=Path)
    parser.add_argument("--labels", type=Path, help="table of labels; without: the bag's truth")
    parser.add_argument("--kind", help="label class that counts")
    parser.add_argument("--first", type=int, help="only so many images from the start")
    parser.add_argument("--last", type=int, help="only so many images at the end")
    parser.add_argument("--blind", action="store_true", help="without telemetry")
    parser.add_argument("--train", action="store_true", help="train a detector and score it")
    parser.add_argument("--start", type=Path, help="first layers: second look, or nanodet.json")
    parser.add_argument("--score", type=Path, metavar="FLIGHT_BAG", help="flight to score on")
    parser.add_argument("--clicks", type=Path, metavar="JSON", help="write the clicks that it made")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "work"
        folder.mkdir()
        _extract(args, Path(name), folder)
        recording = Recording(folder)
        began = time.perf_counter()
        recording.prepare(lambda _done: None)
        print(f"{len(recording)} frames, {recording.posed} with a camera; proposals "
              f"{time.perf_counter() - began:.1f} s")  # fmt: skip
        session = Session(folder)
        truth = _labels(args, recording) if args.labels else _bag_truth(args.recording, recording)
        clicks = _teach(session, truth)
        if args.clicks is not None:
            args.clicks.write_text(json.dumps({"marks": clicks}, indent=1), encoding="utf-8")
        if args.train:
            _train(args, session, folder)


def _train(args: argparse.Namespace, session: Session, folder: Path) -> None:
    """Train, and print scores on images that were neither labelled nor learnt from."""
    began, used = time.perf_counter(), time.process_time()
    write_dataset(session, folder)
    learnt = learn(
        folder, Plan(threads=1, start=args.start), lambda *_args: nullcontext(lambda _done: None)
    )  # fmt: skip
    print(f"trained on {learnt.boxes} boxes in {time.perf_counter() - began:.0f} s, "
          f"{time.process_time() - used:.0f} s of one core; on {learnt.robots} labels kept aside "
          f"precision {learnt.precision:.3f}, recall {learnt.recall:.3f}, threshold "
          f"{learnt.threshold:g}")  # fmt: skip
    config = DetectorConfig(
        model="anomaly", second_look=str(folder / NETWORK), score_threshold=learnt.threshold
    )
    detector, images = load_detector(config), _unseen(args)
    found = [(detector.detect(image.read()), image.truth) for image in images]
    for least in (0.5, 0.3):  # a flight's truth knows one class
        hits = boxes = labels = 0
        for boxes_found, truth in found:
            matched = match(
                replace(boxes_found, class_ids=np.zeros(len(boxes_found), np.int64)), truth, least
            )
            hits += int((matched.robot >= 0).sum())
            boxes += int((matched.robot >= -1).sum())
            labels += int(truth.counted.sum())
        print(f"on {len(found)} unseen images, IoU {least}: {labels} labels, precision "
              f"{hits / max(1, boxes):.3f}, recall {hits / max(1, labels):.3f}")  # fmt: skip


def _unseen(args: argparse.Namespace) -> list[LabelledImage]:
    if args.score is not None:
        return list(read_bag(args.score))
    if not args.labels:
        return list(read_bag(args.recording))[args.first :]
    files = sorted(f for f in args.recording.iterdir() if f.suffix.lower() in IMAGE_ENDINGS)
    table = PictureLabels(args.labels, ())
    made = []
    for file in files[args.first :]:
        own = table.of(file.name, (0, 0))
        corners = own.corners[[kind == args.kind for kind in own.classes]]
        count = len(corners)
        truth = Truth(corners, np.ones(count, bool), np.ones(count), np.ones(count),
                      np.zeros(count, np.int64))  # fmt: skip
        made.append(LabelledImage(file.name, truth, partial(read_image, file)))
    return made


def _extract(args: argparse.Namespace, name: Path, folder: Path) -> None:
    source, views = args.recording, lambda stamps: [None] * len(stamps)
    if source.is_dir() and not (source / "metadata.yaml").is_file():
        files = sorted(f for f in source.iterdir() if f.suffix.lower() in IMAGE_ENDINGS)
        files = files[: args.first] if args.first else files[-args.last :] if args.last else files
        source = name / source.name
        source.mkdir()
        for file in files:
            shutil.copyfile(file, source / file.name)
    elif not args.blind:
        config, detector = EstimatorConfig(), DetectorConfig()

        def views(stamps: Sequence[int]) -> list:
            return bag_views(args.recording, stamps, config, detector, "")

    pictures = open_pictures(source)
    if args.first and pictures.count > args.first:  # of a bag
        whole = pictures.pictures
        pictures = replace(pictures, count=args.first, pictures=lambda: islice(whole(), args.first))
    extract(pictures, folder, 5000, views, lambda _done: None)


def _labels(args: argparse.Namespace, recording: Recording) -> Labels:
    table = PictureLabels(args.labels, ())
    truth: Labels = []
    for name in recording.names:
        own = table.of(name, recording.size)
        if own is None:
            truth.append([])
            continue
        centres = (own.corners[:, :2] + own.corners[:, 2:]) / 2.0 + 0.5
        boxes = np.hstack([centres, own.corners[:, 2:] - own.corners[:, :2]])
        kinds = zip(own.classes, boxes, strict=True)
        truth.append([(kind, box, "") for kind, box in kinds if args.kind in (None, kind)])
    return truth


def _bag_truth(path: Path, recording: Recording) -> Labels:
    found: dict[str, list[tuple[str, Array, str]]] = {}
    with open_bag([path]) as bag:
        topics = {name for name in bag.topics if name.endswith("truth/labels")}
        for one in bag.messages(topics):
            about = parse_json(str(one.message().data))
            found[f"{about['stamp_ns']}.jpg"] = [
                (
                    str(robot["class"]),
                    np.array([
                        (robot["left"] + robot["right"] + 1.0) / 2.0,
                        (robot["top"] + robot["bottom"] + 1.0) / 2.0,
                        robot["right"] - robot["left"],
                        robot["bottom"] - robot["top"],
                    ]),
                    str(robot["robot_id"]),
                )
                for robot in about["robots"]
                if robot["scored"]
            ]  # fmt: skip
    return [found.get(name, []) for name in recording.names]


def _teach(session: Session, truth: Labels) -> list[dict]:
    made, robots, refused = [], Counter(), set()
    for clicks in range(MOST_CLICKS + 1):
        count, missed = _compare(session, truth)
        count.clicks = clicks
        print(count.line())
        missed = [one for one in missed if one not in refused]
        if not missed or clicks == MOST_CLICKS:
            break
        frames = Counter(frame for frame, _ in missed)
        frame = min(frames, key=lambda one: (-frames[one], one))
        number = next(i for f, i in missed if f == frame)
        kind, box, robot = truth[frame][number]
        robots[kind] += 1
        click = Click(robot or f"{kind}_{robots[kind]}", kind, frame, point=box[:2])
        began = time.perf_counter()
        try:
            session.add([click])
        except InputError as error:
            print(f"  {error}")
            refused.add((frame, number))
            continue
        made.append({"robot": click.robot, "class": kind, "frame": frame,
                     "x": round(float(box[0]), 1), "y": round(float(box[1]), 1)})  # fmt: skip
        print(f"  {click.robot} in frame {frame}: carried in {time.perf_counter() - began:.1f} s")
    made += _answers(session, truth)
    count, _ = _compare(session, truth)
    count.clicks = len(made)
    print(count.line())
    lost = Counter(track.sight.value for of in session.tracks.values() for track in of.values())
    print(f"robots times frames: {dict(lost)}; questions {len(session.questions())}; frames "
          f"complete {sum(session.labels(i) is not None for i in range(len(truth)))} of "
          f"{len(truth)}")  # fmt: skip
    return made


def _answers(session: Session, truth: Labels) -> list[dict]:
    """Say yes to each robot that is asked about, in the first frame in which its box is right."""
    made = []
    for asked in session.questions():
        kind, of = session.project.classes[asked.robot], session.tracks[asked.robot]
        right = [frame for frame in range(asked.frame, asked.until + 1)
                 if any(own == kind and _right(box, of[frame].box)
                        for own, box, _ in truth[frame])]  # fmt: skip
        if right and of[right[0]].sight is Sight.UNSURE:
            box = of[right[0]].box
            corner = np.concatenate([box[:2] - box[2:] / 2.0, box[2:]])
            session.add([Click(asked.robot, kind, right[0], box=corner)])
            made.append({"robot": asked.robot, "class": kind, "frame": right[0],
                         "box": corner.round(1).tolist()})  # fmt: skip
    print(f"  answered yes to {len(made)} questions")
    return made


def _compare(session: Session, truth: Labels) -> tuple[Count, list[tuple[int, int]]]:
    count, missed = Count(), []
    for frame, labels in enumerate(truth):
        boxes = {r: of[frame] for r, of in session.tracks.items() if frame in of}
        shown = [t for t in boxes.values() if t.sight in (Sight.SURE, Sight.UNSURE)]
        count.labels += len(labels)
        count.unsure += sum(one.sight is Sight.UNSURE for one in shown)
        used = set()
        for robot, track in boxes.items():
            if track.sight is not Sight.SURE:
                continue
            kind = session.project.classes[robot]
            hit = [i for i, (own, box, _) in enumerate(labels)
                   if i not in used and own == kind and _right(box, track.box)]  # fmt: skip
            if hit:
                used.add(hit[0])
                count.right += 1
            else:
                count.false += 1
                count.beside += any(overlap(box, track.box) > COVERED_IOU for _, box, _ in labels)
        missed += [(frame, i) for i, (_, box, _) in enumerate(labels)
                   if all(overlap(box, one.box) <= COVERED_IOU for one in shown)]  # fmt: skip
    return count, missed


def _right(label: Array, box: Array) -> bool:
    return overlap(label, box) >= RIGHT_IOU or bool(np.hypot(*(label - box)[:2]) <= RIGHT_PX)


if __name__ == "__main__":
    main()
