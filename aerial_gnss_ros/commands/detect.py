# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss detect`: detects robots in any images; lists, draws and scores boxes."""

from __future__ import annotations

import argparse
import csv
import itertools
import json
import math
from collections import Counter
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, Any

import numpy as np

from aerial_gnss_ros.bags.annotated import AnnotatedPictures, AnnotatedVideo
from aerial_gnss_ros.bags.partial import partial, refuse_existing
from aerial_gnss_ros.bags.pictures import Picture, Source, open_pictures
from aerial_gnss_ros.commands.configuration import values_of
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.values.detection_frame import DetectionFrame
from aerial_gnss_ros.core.values.errors import ConfigError, InputError
from aerial_gnss_ros.detection.base import Detections, Detector, Image
from aerial_gnss_ros.detection.config import DetectorConfig, detector_config
from aerial_gnss_ros.detection.search_config import FULL, ROI, TILES
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.nodes.schemas import DETECTOR
from aerial_gnss_ros.text.sentences import counted
from aerial_gnss_ros.training.picture_labels import Comparison, PictureLabels
from aerial_gnss_ros.training.score import MATCH_IOU, SIZES_PX

COLUMNS = (
    "file_name", "stamp_ns", "class_id", "score", "x_px", "y_px", "width_px", "height_px",
)  # fmt: skip
MOST_TOLD = 8


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    parser.epilog = (
        "boxes.csv has a row per box: left and top edge, width and height in px of the image, "
        "whose first pixel reaches from 0 to 1. LABELS is such a table (class or class_id; a row "
        "without a class for an image without objects), or a folder of YOLO's text files."
    )
    parser.add_argument(
        "pictures", type=Path, nargs="+", metavar="PICTURES",
        help="images, folders of images, videos, bags",
    )  # fmt: skip
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="new folder for the results"
    )
    parser.add_argument(
        "--model", metavar="FILE", help="detection model (default: the shipped one)"
    )
    parser.add_argument(
        "--search",
        choices=(FULL, ROI, TILES),
        help="search mode: parts of an image that the network processes",
    )
    parser.add_argument(
        "--score", type=float, metavar="S", help="least score of a box (default 0.3)"
    )
    parser.add_argument(
        "--params", type=Path, action="append", default=[], metavar="YAML",
        help="parameter file as for the detector node; may be repeated, later ones take precedence",
    )  # fmt: skip
    parser.add_argument(
        "--against", type=Path, metavar="LABELS", help="score the boxes against these labels"
    )
    parser.add_argument(
        "--any-class", action="store_true", help="with --against: labels of all classes count"
    )
    parser.add_argument(
        "--iou", type=float, metavar="X",
        help=f"with --against: least overlap with a label, 0 to 1 (default {MATCH_IOU})",
    )  # fmt: skip
    parser.add_argument("--no-pictures", action="store_true", help="write no annotated images")
    parser.add_argument("--json", action="store_true", help="print the summary as JSON")


@dataclass
class Summary:
    """Result of the detection.

    Attributes:
        images: number of processed images.
        boxes: by class.
        refused: counts of unreadable images, by reason.
        comparison: with labels, if there are any.
    """

    images: int = 0
    boxes: Counter[str] = field(default_factory=Counter)
    refused: Counter[str] = field(default_factory=Counter)
    comparison: Comparison | None = None


def run(args: argparse.Namespace) -> int:
    """Detect robots in images."""
    refuse_existing(args.output)
    if args.against is None and (args.any_class or args.iou is not None):
        option = "--any-class" if args.any_class else "--iou"
        raise ConfigError(f"{option} applies only with --against.")
    least_iou = MATCH_IOU if args.iou is None else args.iou
    if not 0.0 < least_iou <= 1.0:
        raise InputError(f"--iou {least_iou:g} must lie above 0 and at most at 1.")
    config = _config(args)
    sources = [open_pictures(path, config.image.max_pixels) for path in args.pictures]
    _check_names(sources)
    detector = load_detector(config)
    labels = PictureLabels(args.against, detector.class_names) if args.against else None
    summary = Summary(comparison=Comparison(least_iou, args.any_class) if labels else None)
    with ended_cleanly(), partial(args.output) as folder:
        folder.mkdir()
        with (
            (folder / "boxes.csv").open("w", newline="", encoding="utf-8") as stream,
            progress("detecting", sum(one.count for one in sources), "pictures") as report,
        ):
            _Work(detector, labels, summary, stream, report).all(
                sources, None if args.no_pictures else folder / "pictures"
            )
        _check(summary, args.against)
    print(_as_json(args.output, summary) if args.json else _as_text(args.output, summary))
    return 0


def _config(args: argparse.Namespace) -> DetectorConfig:
    given = {"model": args.model, "search.mode": args.search, "score_threshold": args.score}
    values = values_of(args.params)[DETECTOR]
    values |= {name: value for name, value in given.items() if value is not None}
    return detector_config(values)


def _check_names(sources: Sequence[Source]) -> None:
    names = Counter(source.name for source in sources)
    twice = [name for name, count in names.items() if count > 1]
    if twice:
        raise InputError(
            f"two inputs have the name {twice[0]}, so their boxes could not be distinguished; "
            "process them separately."
        )


class _Work:
    """Processes images one by one and collects their boxes."""

    def __init__(
        self,
        detector: Detector,
        labels: PictureLabels | None,
        summary: Summary,
        stream: IO[str],
        report: Any,
    ) -> None:
        self._detector, self._labels, self._summary = detector, labels, summary
        self._report, self._done = report, 0
        self._rows = csv.writer(stream, lineterminator="\n")
        self._rows.writerow(COLUMNS)

    def all(self, sources: Sequence[Source], drawn: Path | None) -> None:
        """Process all images.

        Args:
            sources: of the images.
            drawn: folder for annotated images; None: none.
        """
        for source in sources:
            prefix = f"{source.name}/" if len(sources) > 1 and source.count > 1 else ""
            with ExitStack() as stack:
                sink = None if drawn is None else _sink(drawn, source)
                if sink is not None:
                    stack.enter_context(sink)
                for picture in source.pictures():
                    self._one(replace(picture, name=prefix + picture.name), sink)

    def _one(self, picture: Picture, sink: AnnotatedVideo | AnnotatedPictures | None) -> None:
        self._done += 1
        try:
            image = picture.read()
        except InputError as error:
            self._summary.refused[str(error)] += 1
            self._report(self._done)
            return
        found = self._detector.detect(image)
        self._keep(picture, found, image)
        if sink is not None:
            sink.add(picture.name, image, _frame(picture, found))
        self._report(self._done)

    def _keep(self, picture: Picture, found: Detections, image: Image) -> None:
        self._summary.images += 1
        self._summary.boxes.update(found.names)
        stamp = "" if picture.stamp_ns is None else picture.stamp_ns
        low = found.xyxy[:, :2] + 0.5  # from the middle of the first pixel to its edge
        for name, score, (left, top), (width, height) in zip(
            found.names, found.scores, low, found.xywh[:, 2:], strict=True
        ):
            box = (f"{number:.2f}" for number in (left, top, width, height))
            self._rows.writerow((picture.name, stamp, name, f"{score:.4f}", *box))
        if self._labels is None or self._summary.comparison is None:
            return
        own = self._labels.of(picture.name, (image.shape[1], image.shape[0]))
        if own is not None:
            self._summary.comparison.add(found, own)


def _sink(folder: Path, source: Source) -> AnnotatedVideo | AnnotatedPictures:
    folder.mkdir(exist_ok=True)
    if source.rate_hz:
        return AnnotatedVideo(folder / f"{Path(source.name).stem}.mp4", source.rate_hz)
    return AnnotatedPictures(folder)


def _frame(picture: Picture, found: Detections) -> DetectionFrame:
    xywh = found.xywh
    return DetectionFrame(
        picture.stamp_ns or 0, picture.name, xywh[:, :2], xywh[:, 2:], found.scores, found.names
    )


def _check(summary: Summary, against: Path | None) -> None:
    """Refuse a run without usable input."""
    if not summary.images:
        raise InputError(next(iter(summary.refused), "there is no image in it."))
    if summary.comparison is not None and not summary.comparison.labelled:
        raise InputError(f"{against} has labels of none of these images: the file names differ.")


def _as_text(output: Path, summary: Summary) -> str:
    boxes = sum(summary.boxes.values())
    kinds = ", ".join(f"{name} {count}" for name, count in sorted(summary.boxes.items()))
    lines = [
        f"{output}: {counted(summary.images, 'picture')}, {counted(boxes, 'box')}"
        + (f" ({kinds})" if kinds else "")
        + f", {boxes / summary.images:.2f} a picture"
    ]
    told = list(summary.refused.items())[:MOST_TOLD]
    lines += [f"not read: {why}" + (f" ({n} times)" if n > 1 else "") for why, n in told]
    if len(summary.refused) > len(told):
        lines.append(f"not read: {len(summary.refused) - len(told)} more")
    if summary.comparison is not None:
        lines += _scored(summary.comparison)
    return "\n".join(lines)


def _scored(comparison: Comparison) -> list[str]:
    score, labelled = comparison.score, comparison.labelled
    whole = score.overall
    lines = [f"against labels of {counted(labelled, 'picture')}:"]
    if whole.robots:
        lines.append(
            f"  precision {whole.precision:.3f}, recall {whole.recall:.3f} "
            f"(IoU {comparison.least_iou:g}): {whole.found} of {whole.robots} found"
        )
    lines.append(f"  false boxes {whole.false}, {whole.false / labelled:.3f} a picture")
    lines += [f"    on {kind:<26}{count}" for kind, count in comparison.false_on.most_common()]
    rows = []
    for (low, high), size in zip(itertools.pairwise(SIZES_PX), score.by_size, strict=True):
        if size.robots or size.false:
            name = f"{low:g} or more" if math.isinf(high) else f"{low:g} to {high:g}"
            rows.append(f"    {name:<16}{size.robots:>10}{size.found:>10}{size.false:>10}")
    if rows:
        lines += ["  long side, px       labelled     found     false", *rows]
    if comparison.right_scores:
        least, median = np.quantile(comparison.right_scores, (0.1, 0.5))
        lines.append(
            f"  scores of boxes on robots: median {median:.2f}, a tenth below {least:.2f}"
            + (
                f"; of false ones: median {np.median(comparison.false_scores):.2f}"
                if comparison.false_scores
                else ""
            )
        )
    if comparison.others:
        kinds = ", ".join(f"{name} {count}" for name, count in comparison.others.most_common())
        hint = "" if whole.robots else "; --any-class makes them count"
        lines.append(f"  labels of classes that the model does not know: {kinds}{hint}")
    return lines


def _as_json(output: Path, summary: Summary) -> str:
    content: dict[str, Any] = {
        "output": str(output),
        "pictures": summary.images,
        "boxes": dict(summary.boxes),
        "refused": dict(summary.refused),
    }
    if summary.comparison is not None:
        content["score"] = summary.comparison.score.as_dict()
        content["false_on"] = dict(summary.comparison.false_on)
        content["other_labels"] = dict(summary.comparison.others)
        content["scores"] = {
            "on_robots": summary.comparison.right_scores,
            "false": summary.comparison.false_scores,
        }
    return json.dumps(content, indent=2)
