# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss train`: the paper's curriculum on a labelled data set, resumable after a kill."""

from __future__ import annotations

import argparse
import json
import math
import re
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from aerial_gnss_ros.bags.partial import refuse_existing
from aerial_gnss_ros.commands.dataset_arguments import add_dataset_arguments, inspected
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.core.errors import ConfigError, InputError
from aerial_gnss_ros.detection.select import find_model
from aerial_gnss_ros.training.layout import open_dataset
from aerial_gnss_ros.training.model_card import figure
from aerial_gnss_ros.training.offline import require_ultralytics
from aerial_gnss_ros.training.phases import members, plan_phases
from aerial_gnss_ros.training.results import written
from aerial_gnss_ros.training.run_folder import ONLINE, Plan, RunFolder
from aerial_gnss_ros.training.supervise import TrainingError, train_in_process

SCRATCH = "yolo11n.yaml"
NEEDED = ("train", "val")
INTERRUPTED = 130


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_dataset_arguments(parser, optional=True)
    parser.add_argument("-o", "--output", type=Path, metavar="RUN", help="new folder")
    parser.add_argument(
        "--resume", type=Path, metavar="RUN",
        help="go on with a training that was killed; --batch, --threads and --device may differ",
    )  # fmt: skip
    parser.add_argument(
        "--check", action="store_true", help="only look through the data set, train nothing"
    )
    parser.add_argument(
        "--weights", metavar="FILE",
        help="begin with an .onnx that `export` wrote, a shipped one, or a .pt (needs "
        f"--allow-pickle); or a network's name, from scratch (default {SCRATCH})",
    )  # fmt: skip
    parser.add_argument(
        "--allow-pickle", action="store_true",
        help="trust a .pt file, which can run any code when it is loaded",
    )  # fmt: skip
    parser.add_argument(
        "--epochs", type=_epochs, metavar="N,N",
        help="of the phase with one robot and of that with several (default 100,100)",
    )  # fmt: skip
    parser.add_argument(
        "--one-phase", action="store_true", help="all images at once, for the sum of the epochs"
    )
    _add_parameters(parser)
    parser.add_argument("--json", action="store_true", help="print the scores as JSON")


def _add_parameters(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--image-size", type=int, metavar="PX",
        help=f"side of the square that images are fitted into (default {Plan.image_size})",
    )  # fmt: skip
    parser.add_argument(
        "--batch", type=int, metavar="N", help=f"images a step (default {Plan.batch})"
    )
    parser.add_argument(
        "--learning-rate", type=float, metavar="R",
        help=f"at the start of each phase (default {Plan.learning_rate:g})",
    )  # fmt: skip
    parser.add_argument(
        "--online", choices=ONLINE,
        help="augmentation while training: light (default: colour, small shifts, flips) or none",
    )  # fmt: skip
    parser.add_argument("--seed", type=int, help=f"default {Plan.seed}")
    parser.add_argument(
        "--threads", type=int, metavar="N",
        help="of the processor (default: as many as other programs leave free)",
    )  # fmt: skip
    parser.add_argument("--device", help="cpu, or the number of a GPU (default: one, if there is)")
    parser.add_argument(
        "--bfloat16", action="store_true", default=None,
        help="on a processor: 16 bits; twice as fast with AVX512-BF16 or AMX, slower without",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Train, or go on, and say what came out.

    Raises:
        AerialGnssError: wrong arguments, a data set with errors, a training that ended early.
    """
    if args.check:
        return _check(args)
    with _stopped_politely(args):
        folder, plan = _resumed(args) if args.resume else _begun(args)
        folder.save(plan)
        try:
            _follow(folder, plan)
        except TrainingError as error:
            if error.explained and not args.resume and not folder.has_learnt:
                shutil.rmtree(folder.path)  # nothing to go on with, and the name is free again
            raise
    scores = json.loads((folder.path / "scores.json").read_text(encoding="utf-8"))
    if args.json:
        print(json.dumps({"run": str(folder.path), "scores": scores}, indent=2))
        return 0
    print(
        f"on {scores['images']} held-out images ({scores['split']}): mAP50-95 "
        f"{figure(scores['map50_95'])}, precision {figure(scores['precision'])}, recall "
        f"{figure(scores['recall'])}, box centre off by "
        f"{figure(scores['centre_error_median_px'], 1)} px"
    )
    for file in written(folder.path):
        print(file)
    return 0


def _check(args: argparse.Namespace) -> int:
    if args.dataset is None:
        raise ConfigError("--check needs a DATASET.")
    found = inspected(args, NEEDED)
    for split, examples in found.examples.items():
        robots = sum(len(example.boxes) for example in examples)
        several = sum(len(example.boxes) > 1 for example in examples)
        one = sum(len(example.boxes) == 1 for example in examples)
        print(
            f"{split}: {len(examples)} images, {robots} robots; {one} images with one, {several} "
            f"with several, {len(examples) - one - several} with none"
        )
    print(f"fingerprint {found.fingerprint()}")
    return 0


def _begun(args: argparse.Namespace) -> tuple[RunFolder, Plan]:
    if args.dataset is None or args.output is None:
        raise ConfigError("give a DATASET and -o RUN, or --resume RUN.")
    refuse_existing(args.output)
    weights = _weights(args.weights or SCRATCH, args.allow_pickle)
    phases = plan_phases(args.epochs or (100, 100), args.one_phase)
    chosen = {name: value for name, value in _parameters(args).items() if value is not None}
    plan = Plan(Path(), "", args.unlabelled == "empty", phases, weights, **chosen)
    _check_numbers(plan)
    require_ultralytics("training")
    found = inspected(args, NEEDED)
    for phase in phases:
        members(phase, found.examples["train"])
    folder = RunFolder(args.output)
    folder.path.mkdir(parents=True)
    file = found.dataset.file.resolve()
    return folder, replace(plan, dataset=file, fingerprint=found.fingerprint())


def _resumed(args: argparse.Namespace) -> tuple[RunFolder, Plan]:
    given = {name: value for name, value in _parameters(args).items() if value is not None}
    fixed = {"output", "weights", "epochs"}
    others = [name for name in sorted(fixed) if getattr(args, name) is not None]
    others += sorted(set(given) - {"batch", "threads", "device"})
    others += [name for name in ("one_phase", "allow_pickle") if getattr(args, name)]
    if others:
        raise ConfigError(
            f"a training that is resumed goes on as it was begun: leave out {', '.join(others)}."
        )
    folder = RunFolder(args.resume)
    plan = replace(folder.load(), **given)
    if (
        args.dataset is not None
    ):  # it lies elsewhere now; its fingerprint tells whether it is the same
        plan = replace(plan, dataset=open_dataset(args.dataset).file.resolve())
    _check_numbers(plan)
    if folder.weights.exists():
        raise InputError(f"{folder.path} is finished already: {folder.weights} is its result.")
    require_ultralytics("training")
    with folder.locked():
        pass
    return folder, plan


def _parameters(args: argparse.Namespace) -> dict[str, Any]:
    names = (
        "image_size", "batch", "learning_rate", "online", "seed", "threads", "device", "bfloat16",
    )  # fmt: skip
    return {name: getattr(args, name) for name in names}


def _check_numbers(plan: Plan) -> None:
    for name, low, high in (
        ("image_size", 32, 8192), ("batch", 1, 4096), ("seed", 0, 2**31), ("threads", 0, 1024),
    ):  # fmt: skip
        value = getattr(plan, name)
        if not low <= value <= high:
            option = name.replace("_", "-")
            raise ConfigError(f"--{option} must lie within {low} to {high}, not {value}.")
    if plan.image_size % 32:
        raise ConfigError(f"--image-size must be a multiple of 32, not {plan.image_size}.")
    if not (math.isfinite(plan.learning_rate) and 0.0 <= plan.learning_rate <= 1.0):
        raise ConfigError(f"--learning-rate must lie within 0 to 1, not {plan.learning_rate:g}.")
    if not re.fullmatch(r"|cpu|mps|\d+", plan.device):
        raise ConfigError(f"--device is cpu or the number of a GPU, not {plan.device!r}.")


def _weights(given: str, allow_pickle: bool) -> str:
    """Return what to begin with: the absolute path of a file, or a network's name."""
    suffix = Path(given).suffix.lower()
    if suffix not in (".onnx", ".pt", ".yaml"):
        raise ConfigError(f"--weights {given} is no .onnx, .pt or .yaml file.")
    path = find_model(given) if suffix == ".onnx" else Path(given)
    if path.is_file():
        if suffix == ".pt" and not allow_pickle:
            raise ConfigError(
                f"{path} is a pickle, which can run any code when it is loaded; give "
                "--allow-pickle if you trust it, or export it to .onnx."
            )
        return str(path.resolve())
    if suffix == ".yaml" and path.name == given:
        return given  # one of the networks that ultralytics describes
    raise InputError(f"the weights {path} do not exist; nothing is downloaded.")


def _follow(folder: RunFolder, plan: Plan) -> None:
    total = sum(phase.epochs for phase in plan.phases)
    with progress("training", total, "epochs") as report:

        def on_event(event: dict[str, Any]) -> None:
            if "epoch" in event:
                report(event["epoch"])
            elif "doing" in event:
                print(event["doing"], file=sys.stderr)

        train_in_process(folder, plan.threads, on_event)


@contextmanager
def _stopped_politely(args: argparse.Namespace) -> Iterator[None]:
    """Tell who stops a training how to go on; what it had learnt is not lost."""
    try:
        with ended_cleanly():
            yield
    except KeyboardInterrupt:
        folder = args.resume or args.output
        if folder is None or not RunFolder(folder).plan_file.is_file():
            raise
        print(
            f"aerial-gnss: stopped; go on with aerial-gnss train --resume {folder}",
            file=sys.stderr,
        )
        raise SystemExit(INTERRUPTED) from None


def _epochs(text: str) -> tuple[int, ...]:
    words = text.split(",")
    if not all(word.strip().isdecimal() for word in words) or len(words) > 2:
        raise argparse.ArgumentTypeError(f"{text!r} is not one or two whole numbers, as 100,100")
    return tuple(int(word) for word in words)
