# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss export`: a model for another runtime or with fewer bits, scored beside the first."""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from aerial_gnss_ros.bags.partial import refuse_existing
from aerial_gnss_ros.commands.argument_types import size
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.errors import ConfigError, InputError
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import find_model, load_detector
from aerial_gnss_ros.training.calibration_images import USUAL_COUNT, choose_images
from aerial_gnss_ros.training.compare import compare, for_scoring, labelled, table
from aerial_gnss_ros.training.export import export as export_weights
from aerial_gnss_ros.training.half import export_half
from aerial_gnss_ros.training.labelled import LabelledImage
from aerial_gnss_ros.training.quantize import ARRANGEMENTS, Quantization, export_int8

FP32, FP16, INT8 = "fp32", "fp16", "int8"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("model", help=".onnx in fp32, the name of a shipped one, or .pt")
    parser.add_argument("-o", "--output", type=Path, required=True, help="file to write")
    parser.add_argument("--precision", choices=(FP32, FP16, INT8), default=FP32)
    parser.add_argument(
        "--size", type=size, metavar="WxH",
        help="fixed input, from .pt (default: any multiples of 32)",
    )  # fmt: skip
    parser.add_argument("--allow-pickle", action="store_true", help="trust a .pt file")
    eight = parser.add_argument_group("int8")
    eight.add_argument(
        "--calibration", type=Path, metavar="FOLDER", help="images as the camera takes them"
    )
    eight.add_argument(
        "--images", type=_count, default=USUAL_COUNT, metavar="N",
        help=f"at most so many of them, evenly taken (default {USUAL_COUNT})",
    )  # fmt: skip
    eight.add_argument(
        "--runtime", choices=tuple(ARRANGEMENTS), default="openvino",
        help="which one the file shall be fast on (default openvino)",
    )  # fmt: skip
    eight.add_argument(
        "--reduce-range", action="store_true",
        help="weights in 7 bits, for ONNX Runtime on processors without VNNI",
    )  # fmt: skip
    parser.add_argument(
        "--score", type=Path, metavar="DATASET",
        help="labelled images in YOLO's layout, or a simulated bag: score original and export",
    )  # fmt: skip
    parser.add_argument("--split", default="test", help="of the data set (default test)")
    parser.add_argument("--backend", default=DetectorConfig.backend, help="to score on")
    parser.add_argument("--json", action="store_true", help="the scores for machines")


def _count(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of images")
    return int(text)


def run(args: argparse.Namespace) -> int:
    """Export, then score if asked.

    Raises:
        AerialGnssError: wrong arguments, a model that cannot be used, an output that exists.
    """
    source = _checked(args)
    images = [] if args.score is None else list(labelled(args.score, args.split))
    with ended_cleanly():
        _export(args, source)
    if not args.json:
        print(f"wrote {args.output} ({args.output.stat().st_size / 1e6:.1f} MB)")
    if images:
        _score(args, source, images)
    return 0


def _checked(args: argparse.Namespace) -> Path:
    """Return the source, with everything refused that can be told beforehand."""
    source: Path = find_model(args.model)
    if args.output.suffix.lower() != ".onnx":
        raise ConfigError(f"{args.output} must end in .onnx; give such a name.")
    refuse_existing(args.output)
    if not source.is_file():
        raise InputError(f"the model {source} does not exist; give a .pt or .onnx file.")
    if source.suffix.lower() not in (".pt", ".onnx"):
        raise InputError(f"the model {source} is neither a .pt nor an .onnx file.")
    if source.suffix.lower() == ".pt":
        if not args.allow_pickle:
            raise ConfigError(
                f"{source} is a pickle, which can run any code when it is loaded; add "
                "--allow-pickle if you trust it."
            )
    elif args.precision == FP32:
        raise ConfigError(f"{source} is an .onnx file already; choose --precision fp16 or int8.")
    elif args.size is not None:
        raise ConfigError("--size is for exports from .pt.")
    if args.precision == INT8 and args.calibration is None:
        raise ConfigError("int8 needs --calibration FOLDER with images as the camera takes them.")
    return source


def _export(args: argparse.Namespace, source: Path) -> None:
    steps: list[Callable[[Path, Path], object]] = []
    if source.suffix.lower() == ".pt":
        steps.append(lambda model, made: export_weights(model, made, args.size))
    if args.precision == FP16:
        steps.append(export_half)
    if args.precision == INT8:
        images = choose_images(args.calibration, args.images)
        steps.append(lambda model, made: _to_int8(model, made, images, args))
    with tempfile.TemporaryDirectory() as folder:
        between = [Path(folder) / f"{number}.onnx" for number in range(1, len(steps))]
        for step, model, made in zip(
            steps, [source, *between], [*between, args.output], strict=True
        ):
            step(model, made)


def _to_int8(source: Path, output: Path, images: list[Path], args: argparse.Namespace) -> None:
    longest = max(args.size) if args.size else DetectorConfig.image_size
    how = Quantization(tuple(images), args.runtime, longest, args.reduce_range)
    with progress("calibrating", len(images), "images") as report:
        export_int8(source, output, how, report)


def _score(args: argparse.Namespace, source: Path, images: list[LabelledImage]) -> None:
    detectors = [
        load_detector(
            for_scoring(
                DetectorConfig(
                    model=str(model), backend=args.backend, allow_pickle=args.allow_pickle
                )
            )
        )
        for model in (source, args.output)
    ]
    with progress("scoring", len(images), "images") as report:
        figures = compare(detectors, images, report)
    if args.json:
        print(json.dumps([asdict(row) for row in figures], indent=2))
    else:
        print(f"\n{len(images)} images of {args.score}\n\n{table(figures)}", end="")
