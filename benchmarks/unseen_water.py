# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trains the second look on photographs of water, and scores it on water that it has not seen.

    python benchmarks/unseen_water.py REAL_WATER -o WORK --rendered FOLDER ... --held-out FOLDER ...
    python benchmarks/unseen_water.py REAL_WATER -o WORK --look MODEL_second_look.onnx
    python benchmarks/unseen_water.py REAL_WATER -o WORK --model MODEL.onnx --look off

REAL_WATER has a folder for each of `SOURCES`, with images/ and labels.csv, without any robot in
them: every box is false. Rendered robots are composed onto them (`training.composing`). One source
after the other is left out of training, and all figures on real water are of the source left out;
then a network learns from all of them (WORK/second_look.onnx). A stage that is done is kept in
WORK. With `--look` a network that exists is scored in the same way, and nothing trained; with
`--look off` a detector (`--model`) alone. What a detector finds is kept, too: each needs a WORK of
its own. `--start` is what to go on from: nanodet.json, whose weights know COCO's photographs
(`training.second_look_network_pretrained`), or a second look that has not seen REAL_WATER either
(the shipped one has).
`--font` is one with coloured bitmaps, whose pictures are drawn into images (`training.drawings`).
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from unseen_water_images import (
    SETS,
    TERMS,
    Seen,
    composed_from,
    images_of,
    learnt_from,
    prepare,
    refused_of,
    scored_on,
    seen_of,
)
from unseen_water_tables import SOURCES, above, at_recall, by_kind, false_boxes, in_area, robots

from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.second_look import SecondLook
from aerial_gnss_ros.detection.second_look_terms import ODDS_UNIT, traits
from aerial_gnss_ros.training.proposals import Proposals, joined
from aerial_gnss_ros.training.score import Score
from aerial_gnss_ros.training.second_look_network import write
from aerial_gnss_ros.training.second_look_network_fit import BATCH, fit
from aerial_gnss_ros.training.second_look_network_pretrained import read, start_from
from aerial_gnss_ros.training.share import Look, Share, strictest_share

FOUND = (0.94, 0.9, 0.85, 0.8)  # shares of the composed robots where false boxes are compared
ALL = "nothing"  # left out
OFF = Path("off")  # no second look


def _say(words: str) -> None:
    sys.stdout.write(f"{words}\n")
    sys.stdout.flush()


class Sharing(SecondLook):
    """A network that was written with weight 1, as if it had been written with another share."""

    def __init__(self, file: Path, threads: int, share: Share) -> None:
        self._share = share
        super().__init__(file, threads)

    def run(self, shown: NDArray[np.uint8], inputs: NDArray[np.float32]) -> NDArray[np.float64]:
        """Return the shared scores (n,)."""
        return self._share.scores(super().run(shown, inputs), ODDS_UNIT * inputs[:, 0])


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
    parts = [part for folder in given.rendered for part in learnt_from(given, folder)]
    parts += [
        part.times(given.emphasis)
        for folder in given.emphasised
        for part in learnt_from(given, folder)
    ]
    for source in sources:
        parts += refused_of(given, source)
        parts += [part for k in range(SETS) for part in composed_from(given, source, k)]
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
            every, TERMS, given.steps, given.seed, start_from(given.start), given.threads,
            lambda step, loss: _say(f"step {step}: loss {loss:.4f}"), given.device, given.batch,
        )  # fmt: skip
        write(network, TERMS, Share(), file)
    if not chosen.is_file():
        second = SecondLook(file, given.threads)
        groups = [
            looks(second, [s for f in held for s in seen_of(given, f.name, images_of(f))])
            for held in given.held_out
        ]
        # Other robots on the photographs of training: no image of the source left out is used.
        groups.append(looks(second, [one for name in sources for one in scored_on(given, name)[1]]))
        least = [*given.least_recall, given.least_composed]
        share, false = strictest_share(groups, least, *([[given.weight]] if given.weight else []))
        _say(f"the second look counts {share.weight:g}, shift {share.shift:.2f}: {false:.3f} false")
        chosen.write_text(json.dumps({"weight": share.weight, "shift": share.shift}))
    share = Share(**json.loads(chosen.read_text()))
    if left_out == ALL:
        write(read(file), TERMS, share, given.output / "second_look.onnx")
    return file, share


def finished(
    seen: Sequence[Seen], file: Path, share: Share, threads: int, ways: int | None = None
) -> list[Any]:
    """Return name, boxes and truth of each image, as the detector with a second look has."""
    if file == OFF:
        return [(one.name, one.found, one.truth) for one in seen]
    second = Sharing(file, threads, share)
    if ways is not None:
        second.terms = replace(second.terms, ways=ways)
    return [
        (one.name, look.shared(1.0)[0], one.truth)
        for one, look in zip(seen, looks(second, seen), strict=True)
    ]


def main() -> None:
    """Train what is missing, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("real", type=Path, metavar="REAL_WATER")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="WORK")
    parser.add_argument("--look", type=Path, metavar="FILE|off")
    parser.add_argument("--weight", type=float, help="of the second look; default: chosen")
    parser.add_argument("--shift", type=float, default=0.0, help="of the log odds, with --look")
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
    parser.add_argument("--batch", type=int, default=BATCH, help="boxes of a step")
    parser.add_argument("--device", default="cpu", help="of torch, to train on")
    parser.add_argument("--jobs", type=int, default=1, help="processes that prepare images")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="+", default=[*SOURCES, ALL])
    given = parser.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    if given.look is not None:
        sources = [source for source in given.only if source != ALL]
        tell(given, given.look, Share(given.weight or 1.0, given.shift), sources)
        return
    if given.start is None:
        parser.error("give --start, or --look.")
    prepare(given)
    for left_out in given.only:
        file, share = trained(given, left_out)
        tell(given, file, share, tuple(SOURCES) if left_out == ALL else (left_out,))


def tell(given: argparse.Namespace, file: Path, share: Share, sources: Sequence[str]) -> None:
    """Print the rows of one network: false boxes, robots found, and rendered images."""
    for source in sources:
        plain, with_robots = scored_on(given, source)
        boxes = finished(plain, file, share, given.threads, given.ways)
        folder = given.real / source
        _say(false_boxes(folder, boxes))
        if SOURCES[source] < 1.0:
            _say(f"in an area: {false_boxes(folder, in_area(folder, boxes))}")
        found = finished(with_robots, file, share, given.threads, given.ways)
        _say(robots(source, found))
        _say(at_recall(folder, boxes, found, given.found))
        for row in by_kind(folder, boxes, found):
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
