# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Arguments of `aerial-gnss train`, and the refusal of contradictory ones."""

from __future__ import annotations

import argparse
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

from aerial_gnss_ros.commands.dataset_arguments import add_dataset_arguments
from aerial_gnss_ros.core.values.errors import ConfigError, InputError
from aerial_gnss_ros.detection.select import find_model
from aerial_gnss_ros.training.phases import Phase, plan_phases, timed_phase
from aerial_gnss_ros.training.run_folder import ONLINE, Plan

SCRATCH = "yolo11n.yaml"
_EPOCHS = (100, 100)
# Arguments copied into the plan; those of the machine may change on resuming.
_PARAMETERS = ("image_size", "learning_rate", "online", "seed", "freeze", "bfloat16")
_MACHINE = ("batch", "threads", "device")
# Arguments that a resumed training has already fixed.
_FIXED = ("output", "weights", "allow_pickle", "epochs", "time", "one_phase")
_RANGES = {
    "image_size": (32, 8192), "batch": (1, 4096), "seed": (0, 2**31), "threads": (0, 1024),
    "freeze": (0, 1000),
}  # fmt: skip


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    add_dataset_arguments(parser, optional=True)
    parser.add_argument("-o", "--output", type=Path, metavar="RUN", help="new folder")
    parser.add_argument(
        "--resume", type=Path, metavar="RUN",
        help="resume an interrupted training; --batch, --threads and --device may differ",
    )  # fmt: skip
    parser.add_argument(
        "--check", action="store_true", help="only inspect the data set, without training"
    )
    parser.add_argument(
        "--weights", metavar="FILE",
        help=
                "initial weights: an .onnx that `export` wrote, a shipped one, or a .pt (needs "
                f"--allow-pickle); or a network's name to start from scratch (default {SCRATCH})",
    )  # fmt: skip
    parser.add_argument(
        "--allow-pickle", action="store_true", default=None,
        help="trust a .pt file, which can run any code when it is loaded",
    )  # fmt: skip
    _add_length(parser)
    _add_learning(parser)
    _add_machine(parser)
    parser.add_argument(
        "--json", action="store_true", help="print the scores, or with --check the counts, as JSON"
    )


def _add_length(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--epochs", type=_epochs, metavar="N,N",
        help="epochs of the phases with one and with several robots (default 100,100)",
    )  # fmt: skip
    parser.add_argument(
        "--one-phase", action="store_true", default=None,
        help="one phase with all images, for the sum of the epochs",
    )  # fmt: skip
    parser.add_argument(
        "--time", type=float, metavar="HOURS",
        help="instead of epochs: one phase with all images, of this many hours",
    )  # fmt: skip


def _add_learning(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--image-size", "--imgsz", type=int, metavar="PX",
        help=f"side of the square network input, px (default {Plan.image_size})",
    )  # fmt: skip
    parser.add_argument("--batch", type=int, metavar="N", help=f"batch size (default {Plan.batch})")
    parser.add_argument(
        "--learning-rate", "--lr0", type=float, metavar="R",
        help=f"learning rate at the start of each phase (default {Plan.learning_rate:g})",
    )  # fmt: skip
    parser.add_argument(
        "--freeze", type=int, metavar="N",
        help="freeze the first N layers and all normalisations (default 0)",
    )  # fmt: skip
    parser.add_argument(
        "--online", choices=ONLINE,
        help="augmentation during training: light (default: colour, small shifts, flips) or none",
    )  # fmt: skip
    parser.add_argument("--seed", type=int, help=f"random seed (default {Plan.seed})")


def _add_machine(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--threads", type=int, metavar="N",
        help="CPU threads (default: as many as other programs leave free)",
    )  # fmt: skip
    parser.add_argument(
        "--device", help="cpu, or the number of a GPU (default: a GPU if there is one)"
    )
    parser.add_argument(
        "--bfloat16", action="store_true", default=None,
        help="16-bit training on a CPU: twice as fast with AVX512-BF16 or AMX, slower without",
    )  # fmt: skip


def plan_of(args: argparse.Namespace) -> Plan:
    """Return the plan of a training, without its data set, which is set after inspection.

    Raises:
        ConfigError: an argument is wrong, or two contradict each other.
        InputError: the weights do not exist.
    """
    phases, weights = phases_of(args), _weights(args.weights or SCRATCH, args.allow_pickle)
    chosen = _given(args, *_PARAMETERS, *_MACHINE)
    plan = Plan(Path(), "", args.unlabelled == "empty", phases, weights, **chosen)
    _check(plan)
    if plan.freeze and weights.endswith(".yaml"):
        raise ConfigError(
            f"--freeze {plan.freeze} would keep random layers: {weights} begins from scratch; give "
            "the weights of a trained network, or leave --freeze out."
        )
    if plan.bfloat16 and plan.device not in ("", "cpu"):
        raise ConfigError(
            f"--bfloat16 is for a processor, not for --device {plan.device}: a GPU calculates in "
            "16 bits by itself; leave one of them out."
        )
    return plan


def plan_resumed(plan: Plan, args: argparse.Namespace) -> Plan:
    """Return the plan of a resumed training; batch, threads and device may be new.

    Raises:
        ConfigError: an argument is wrong, or would alter what is trained.
    """
    given = [*_given(args, *_FIXED, *_PARAMETERS)]
    if args.unlabelled == "empty" and not plan.unlabelled_is_empty:
        given.append("unlabelled")
    if given:
        names = ", ".join(f"--{name.replace('_', '-')}" for name in given)
        raise ConfigError(f"a resumed training keeps its options: leave out {names}.")
    plan = replace(plan, **_given(args, *_MACHINE))
    _check(plan)
    return plan


def _given(args: argparse.Namespace, *names: str) -> dict[str, Any]:
    found = {name: getattr(args, name) for name in names}
    return {name: value for name, value in found.items() if value is not None}


def phases_of(args: argparse.Namespace) -> tuple[Phase, ...]:
    """Return the phases to train.

    Raises:
        ConfigError: an invalid duration, or two.
    """
    if args.time is None:
        return plan_phases(args.epochs or _EPOCHS, bool(args.one_phase))
    if args.epochs is not None:
        raise ConfigError("--epochs and --time both set the duration: give one of them.")
    return timed_phase(args.time)


def _check(plan: Plan) -> None:
    for name, (low, high) in _RANGES.items():
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


def _weights(given: str, allow_pickle: bool | None) -> str:
    """Return the initial weights: the absolute path of a file, or a network's name."""
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


def _epochs(text: str) -> tuple[int, ...]:
    words = text.split(",")
    if not all(word.strip().isdecimal() for word in words) or len(words) > 2:
        raise argparse.ArgumentTypeError(f"{text!r} is not one or two whole numbers, as 100,100")
    return tuple(int(word) for word in words)
