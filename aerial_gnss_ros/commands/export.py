# Copyright 2026 aerial_gnss_ros developers
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
from aerial_gnss_ros.core.values.errors import ConfigError, InputError
from aerial_gnss_ros.detection.config import BACKENDS, DetectorConfig
from aerial_gnss_ros.detection.select import find_model, load_detector
from aerial_gnss_ros.text.sentences import counted
from aerial_gnss_ros.training.calibration_images import USUAL_COUNT, choose_images
from aerial_gnss_ros.training.compare import compare, for_scoring, labelled, table
from aerial_gnss_ros.training.engine import EnginePlan, build_engine
from aerial_gnss_ros.training.export import export as export_weights
from aerial_gnss_ros.training.half import export_half
from aerial_gnss_ros.training.labelled import LabelledImage
from aerial_gnss_ros.training.quantize import ARRANGEMENTS, Quantization, export_int8

ONNX, ENGINE = "onnx", "engine"
FP32, FP16, INT8 = "fp32", "fp16", "int8"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("model", help="model: .onnx in fp32, the name of a shipped one, or .pt")
    parser.add_argument("-o", "--output", type=Path, required=True, help="file to write")
    parser.add_argument(
        "--format", choices=(ONNX, ENGINE),
        help="engine: for TensorRT, on the device that will fly (default: by the output's ending)",
    )  # fmt: skip
    parser.add_argument("--precision", choices=(FP32, FP16, INT8), default=FP32)
    parser.add_argument(
        "--size", type=size, metavar="WxH",
        help="fixed input size, from .pt and for engines (default: any multiples of 32)",
    )  # fmt: skip
    parser.add_argument(
        "--workspace", type=_count, default=EnginePlan.workspace_mb, metavar="MB",
        help="memory for TensorRT's build (default %(default)s)",
    )  # fmt: skip
    parser.add_argument("--allow-pickle", action="store_true", help="trust a .pt file")
    eight = parser.add_argument_group("int8")
    eight.add_argument(
        "--calibration", type=Path, metavar="FOLDER", help="images as the camera takes them"
    )
    eight.add_argument(
        "--images", type=_count, default=USUAL_COUNT, metavar="N",
        help=f"greatest number of them, evenly sampled (default {USUAL_COUNT})",
    )  # fmt: skip
    eight.add_argument(
        "--runtime", choices=tuple(ARRANGEMENTS),
        help="runtime to optimise for (default openvino; tensorrt for an engine)",
    )  # fmt: skip
    eight.add_argument(
        "--reduce-range", action="store_true",
        help="weights in 7 bits, for ONNX Runtime on processors without VNNI",
    )  # fmt: skip
    parser.add_argument(
        "--score", type=Path, metavar="DATASET",
        help="labelled images in YOLO's layout, or a simulated bag: score original and export",
    )  # fmt: skip
    parser.add_argument("--split", default="test", help="split of the data set (default test)")
    parser.add_argument(
        "--backend", choices=BACKENDS, default=DetectorConfig.backend, help="runtime for scoring"
    )
    parser.add_argument("--json", action="store_true", help="print the scores as JSON")


def _count(text: str) -> int:
    if not text.isdigit() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number of 1 or more")
    return int(text)


def run(args: argparse.Namespace) -> int:
    """Export, then score if asked.

    Raises:
        AerialGnssError: wrong arguments, an unusable model, an output that exists.
    """
    source, kind = _checked(args)
    images = [] if args.score is None else list(labelled(args.score, args.split))
    with ended_cleanly():
        _export(args, source, kind)
    if not args.json:
        print(f"wrote {args.output} ({args.output.stat().st_size / 1e6:.1f} MB)")
    if images:
        _score(args, source, images)
    elif args.json:
        print("[]")  # no scores
    return 0


def _checked(args: argparse.Namespace) -> tuple[Path, str]:
    """Return source and format after all cheap checks."""
    source: Path = find_model(args.model)
    kind = args.format or (ENGINE if args.output.suffix.lower() == ".engine" else ONNX)
    if args.output.suffix.lower() != f".{kind}":
        raise ConfigError(f"{args.output} must end in .{kind}; give such a name.")
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
    elif kind == ONNX and args.precision == FP32:
        raise ConfigError(f"{source} is an .onnx file already; choose --precision fp16 or int8.")
    elif kind == ONNX and args.size is not None:
        raise ConfigError("--size is for exports from .pt and for engines.")
    if args.precision == INT8 and args.calibration is None:
        raise ConfigError("int8 needs --calibration FOLDER with images as the camera takes them.")
    if args.precision != INT8:
        for name in ("calibration", "runtime", "reduce_range"):
            if getattr(args, name):
                option = name.replace("_", "-")
                raise ConfigError(f"--{option} applies only with --precision int8.")
    return source, kind


def _export(args: argparse.Namespace, source: Path, kind: str) -> None:
    steps: list[Callable[[Path, Path], object]] = []
    if source.suffix.lower() == ".pt":
        steps.append(lambda model, made: export_weights(model, made, args.size))
    if args.precision == FP16:
        steps.append(export_half)
    if args.precision == INT8:
        images = choose_images(args.calibration, args.images)
        runtime = args.runtime or ("tensorrt" if kind == ENGINE else "openvino")
        steps.append(lambda model, made: _to_int8(model, made, images, runtime, args))
    if kind == ENGINE:
        plan = EnginePlan(source, args.precision, args.size, args.workspace)
        steps.append(lambda model, made: build_engine(model, made, plan))
    with tempfile.TemporaryDirectory() as folder:
        between = [Path(folder) / f"{number}.onnx" for number in range(1, len(steps))]
        for step, model, made in zip(
            steps, [source, *between], [*between, args.output], strict=True
        ):
            step(model, made)


def _to_int8(
    source: Path, output: Path, images: list[Path], runtime: str, args: argparse.Namespace
) -> None:
    longest = max(args.size) if args.size else DetectorConfig.image_size
    how = Quantization(tuple(images), runtime, longest, args.reduce_range)
    with progress("calibrating", len(images), "images") as report:
        export_int8(source, output, how, report)


def _score(args: argparse.Namespace, source: Path, images: list[LabelledImage]) -> None:
    detectors = [
        load_detector(
            for_scoring(
                DetectorConfig(
                    model=str(model),
                    backend=args.backend,
                    precision="f32",  # measures the file's loss, not the runtime's
                    allow_pickle=args.allow_pickle,
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
        print(f"\n{counted(len(images), 'image')} of {args.score}\n\n{table(figures)}", end="")
