# SPDX-License-Identifier: Apache-2.0
"""Trains YOLO11n with ultralytics (AGPL-3.0, the extra [ultralytics]), for a given time.

python -m aerial_gnss_ros.training.train DATA.yaml -o FOLDER --minutes 60
"""

from __future__ import annotations

import argparse
import math
import os
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aerial_gnss_ros.core.errors import AerialGnssError, InputError, OutputError
from aerial_gnss_ros.training.from_onnx import checkpoint_from_onnx, training_batches
from aerial_gnss_ros.training.offline import go_offline, require_ultralytics

_LAST_RATE = 0.01  # of the first learning rate
_STEPS_BETWEEN_LOOKS = 10  # at how busy the machine is


@dataclass(frozen=True)
class Training:
    """What to train, and how long.

    Attributes:
        data: YOLO data.yaml.
        folder: new folder for weights and the table of losses.
        weights: what to begin with: a network's description (from scratch) or weights (.onnx as
            exported from YOLO11n, or .pt, which runs whatever its author put there).
        minutes: time for training; the learning rate falls to its end within it. 0: `epochs`.
        epochs: passes over the images if `minutes` is 0.
        image_size: side of the square that images are fitted into, px.
        batch: images a step.
        learning_rate: at the start, of AdamW; falls along a cosine to a hundredth.
        seed: of the first weights and of the order of images.
        threads: processor threads; 0: as many as other programs leave free.
        bfloat16: network in 16 bits (losses stay in 32): twice as fast on processors that have
            AVX512-BF16 or AMX, slower on others.
        freeze: so many layers at the start stay as they are, and all normalisations: for
            fine-tuning on images that are not like all of those that the network is to meet. 0:
            everything is trained.
    """

    data: Path
    folder: Path
    weights: str = "yolo11n.yaml"
    minutes: float = 60.0
    epochs: int = 100
    image_size: int = 320
    batch: int = 16
    learning_rate: float = 0.002
    seed: int = 0
    threads: int = 0
    bfloat16: bool = False
    freeze: int = 0


# Seen from above there is no up, and light changes; robots' sizes are in the images already.
AUGMENTATION: dict[str, float] = {
    "hsv_h": 0.02, "hsv_s": 0.5, "hsv_v": 0.3, "degrees": 0.0, "translate": 0.1, "scale": 0.2,
    "shear": 0.0, "fliplr": 0.5, "flipud": 0.3, "mosaic": 0.0, "mixup": 0.0, "erasing": 0.0,
}  # fmt: skip


def train(training: Training) -> Path:
    """Return the trained weights (.pt) in the new folder.

    Raises:
        InputError: the data file is missing.
        ModelError: ultralytics is not installed.
        OutputError: the folder exists.
    """
    if not training.data.is_file():
        raise InputError(f"the data file {training.data} does not exist.")
    if training.folder.exists():
        raise OutputError(f"the folder {training.folder} exists already; give a new one.")
    model = network(training)
    use_processor_well(model, training)
    _fall_with_time(model, training)
    if training.freeze:
        model.add_callback("on_train_batch_start", _keep_normalisations)
    model.train(
        data=str(training.data.resolve()),
        project=str(training.folder.resolve().parent),
        name=training.folder.name,
        time=training.minutes / 60.0 or None,
        device="cpu",
        workers=2,
        cache="ram",
        val=False,
        plots=False,
        **options(training),
    )
    return training.folder / "weights" / "last.pt"


def options(training: Training) -> dict[str, Any]:
    """Return ultralytics' arguments that say how is learnt, whatever from and on which device."""
    return {
        "epochs": training.epochs,
        "imgsz": training.image_size,
        "batch": training.batch,
        "nbs": training.batch,  # a step after every batch: a short training needs them all
        "optimizer": "AdamW",
        "lr0": training.learning_rate,
        "lrf": _LAST_RATE,
        "cos_lr": True,
        "warmup_epochs": 0.25,
        "warmup_bias_lr": 0.0,  # the default is meant for SGD
        "seed": training.seed,
        "deterministic": True,
        # Else ultralytics forgets them.
        "pretrained": training.weights.endswith((".pt", ".onnx")),
        "freeze": training.freeze or None,
        "amp": False,
        "verbose": False,
        **AUGMENTATION,
    }


def network(training: Training) -> Any:
    """Return ultralytics' model with the weights to begin with."""
    require_ultralytics("training")
    go_offline()
    from ultralytics import YOLO

    if not training.weights.endswith(".onnx"):
        return YOLO(training.weights)
    with tempfile.TemporaryDirectory() as folder:
        images = training_batches(training.data, training.image_size)
        start = checkpoint_from_onnx(Path(training.weights), Path(folder) / "start.pt", images)
        return YOLO(str(start))


def _keep_normalisations(trainer: Any) -> None:
    import torch

    for layer in trainer.model.modules():
        if isinstance(layer, torch.nn.BatchNorm2d):
            layer.eval()


def _fall_with_time(model: Any, training: Training) -> None:
    """Let the learning rate fall smoothly with time, not in a few steps, one for each epoch."""
    begun = time.monotonic()

    def start(_: Any) -> None:
        nonlocal begun
        begun = time.monotonic()

    def set_rate(trainer: Any) -> None:
        share = min(1.0, (time.monotonic() - begun) / (60.0 * training.minutes))
        factor = _LAST_RATE + (1.0 - _LAST_RATE) * 0.5 * (1.0 + math.cos(math.pi * share))
        for group in trainer.optimizer.param_groups:
            group["lr"] = training.learning_rate * factor  # overruled during warm-up

    if training.minutes:
        model.add_callback("on_train_start", start)
        model.add_callback("on_train_batch_start", set_rate)


def use_processor_well(model: Any, training: Training) -> None:
    """Give training the cores that are free, and the faster memory layout.

    Measured on two idle cores of an AMD EPYC with AVX512-BF16, a step of 16 images of 320 px: 1.45
    s as ultralytics does it (one thread), 0.65 s with two and channels last, 0.44 s in bfloat16.
    Where others use the cores, threads that wait for one another are worse than one: 24 s against
    2 s, measured with eight other programs running.
    """
    import torch

    cores, steps = os.cpu_count() or 1, 0

    def start(trainer: Any) -> None:
        trainer.model.to(memory_format=torch.channels_last)
        if training.bfloat16:
            trainer.model.forward = _in_bfloat16(trainer.model.forward)

    def set_threads(_: Any) -> None:
        nonlocal steps
        if steps % _STEPS_BETWEEN_LOOKS == 0:
            others = os.getloadavg()[0] - torch.get_num_threads()
            free = max(1, min(cores, round(cores - others)))
            torch.set_num_threads(training.threads or free)
        steps += 1

    model.add_callback("on_train_start", start)
    model.add_callback("on_train_batch_start", set_threads)


def _in_bfloat16(forward: Any) -> Any:
    """Return the network's `forward` run in bfloat16, its results in 32 bits for the loss."""
    import torch

    def run(x: Any, *args: Any, **kwargs: Any) -> Any:
        if isinstance(x, dict):  # images and labels: the loss, which calls us again with images
            return forward(x, *args, **kwargs)
        with torch.autocast("cpu", dtype=torch.bfloat16):
            return _to_float(forward(x, *args, **kwargs))

    return run


def _to_float(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _to_float(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(_to_float(item) for item in value)
    return value.float() if hasattr(value, "is_floating_point") else value


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line; returns the exit status."""
    parser = argparse.ArgumentParser(prog="train", description=__doc__)
    parser.add_argument("data", type=Path, help="YOLO data.yaml")
    parser.add_argument("-o", "--output", type=Path, required=True, help="new folder")
    parser.add_argument("--weights", default=Training.weights)
    parser.add_argument("--minutes", type=float, default=Training.minutes)
    parser.add_argument("--epochs", type=int, default=Training.epochs)
    parser.add_argument("--image-size", type=int, default=Training.image_size)
    parser.add_argument("--batch", type=int, default=Training.batch)
    parser.add_argument("--learning-rate", type=float, default=Training.learning_rate)
    parser.add_argument("--seed", type=int, default=Training.seed)
    parser.add_argument("--threads", type=int, default=Training.threads)
    parser.add_argument("--freeze", type=int, default=Training.freeze)
    parser.add_argument("--bfloat16", action="store_true")
    given = vars(parser.parse_args(arguments))
    folder = given.pop("output")
    try:
        weights = train(Training(folder=folder, **given))
    except AerialGnssError as error:
        sys.stderr.write(f"train: {error}\n")
        return 2
    sys.stdout.write(f"{weights}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
