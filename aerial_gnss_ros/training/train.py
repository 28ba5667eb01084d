# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Options and callbacks of ultralytics (AGPL-3.0, the extra [ultralytics])."""

from __future__ import annotations

import math
import os
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aerial_gnss_ros.training.from_onnx import checkpoint_from_onnx, training_batches
from aerial_gnss_ros.training.offline import go_offline, require_ultralytics

_LAST_RATE = 0.01  # of the first learning rate
_MANY_EPOCHS = 1_000_000
_STEPS_BETWEEN_LOOKS = 10  # at how busy the machine is


@dataclass(frozen=True)
class Training:
    """Settings of a training.

    Attributes:
        data: YOLO data.yaml.
        weights: initial weights: a network's description (from scratch) or weights (.onnx as
            exported from YOLO11n, or .pt, which can run arbitrary code).
        hours: time for training; the learning rate falls to its end within it. 0: `epochs`.
        epochs: passes over the images if `hours` is 0.
        image_size: side of the square that images are fitted into, px.
        batch: images a step.
        learning_rate: at the start, of AdamW; falls along a cosine to a hundredth.
        seed: of the first weights and of the order of images.
        threads: processor threads; 0: as many as other programs leave free.
        bfloat16: network in 16 bits (losses stay in 32): twice as fast on processors that have
            AVX512-BF16 or AMX, slower on others.
        freeze: number of first layers that stay fixed, with all normalisations: for fine-tuning on
            images that do not represent all expected ones. 0: everything is trained.
    """

    data: Path
    weights: str = "yolo11n.yaml"
    hours: float = 0.0
    epochs: int = 100
    image_size: int = 320
    batch: int = 16
    learning_rate: float = 0.002
    seed: int = 0
    threads: int = 0
    bfloat16: bool = False
    freeze: int = 0


# From above there is no preferred orientation, and light changes; the images already contain robots
# of all sizes.
AUGMENTATION: dict[str, float] = {
    "hsv_h": 0.02, "hsv_s": 0.5, "hsv_v": 0.3, "degrees": 0.0, "translate": 0.1, "scale": 0.2,
    "shear": 0.0, "fliplr": 0.5, "flipud": 0.3, "mosaic": 0.0, "mixup": 0.0, "erasing": 0.0,
}  # fmt: skip


def options(training: Training) -> dict[str, Any]:
    """Return ultralytics' arguments of the optimisation, independent of data and device."""
    return {
        "epochs": training.epochs,
        "time": training.hours or None,
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
        # Otherwise ultralytics drops them.
        "pretrained": training.weights.endswith((".pt", ".onnx")),
        "freeze": training.freeze or None,
        "amp": False,
        "verbose": False,
        **AUGMENTATION,
    }


def network(training: Training) -> Any:
    """Return ultralytics' model with the initial weights."""
    require_ultralytics("training")
    go_offline()
    from ultralytics import YOLO

    if not training.weights.endswith(".onnx"):
        return YOLO(training.weights)
    with tempfile.TemporaryDirectory() as folder:
        images = training_batches(training.data, training.image_size)
        start = checkpoint_from_onnx(Path(training.weights), Path(folder) / "start.pt", images)
        return YOLO(str(start))


def add_callbacks(model: Any, training: Training, spent_s: float = 0.0) -> None:
    """Add behaviour for which ultralytics has no options; also after resuming.

    Args:
        model: of ultralytics.
        training: its settings.
        spent_s: elapsed time of `training.hours`, s.
    """
    _use_processor_well(model, training)
    if training.hours:
        _fall_with_time(model, training, spent_s)
    else:
        _fall_with_steps(model, training)
    if training.freeze:
        model.add_callback("on_train_batch_start", _keep_normalisations)


def _keep_normalisations(trainer: Any) -> None:
    import torch

    for layer in trainer.model.modules():
        if isinstance(layer, torch.nn.BatchNorm2d):
            layer.eval()


def _fall_with_time(model: Any, training: Training, spent_s: float) -> None:
    """Let the learning rate fall smoothly with time, not in a few steps, one for each epoch."""
    seconds, begun = 3600.0 * training.hours, time.monotonic()

    def prepare(trainer: Any) -> None:
        # ultralytics' guess at the number of epochs, kept from before a kill, may be exhausted.
        trainer.epochs = max(trainer.epochs, _MANY_EPOCHS) if spent_s else trainer.epochs

    def start(trainer: Any) -> None:
        nonlocal begun
        begun = time.monotonic() - spent_s
        trainer.train_time_start -= spent_s  # it would restart counting

    def start_epoch(trainer: Any) -> None:
        trainer.start_epoch = 0  # its start of counting; otherwise it stops as soon as it resumes

    def set_rate(trainer: Any) -> None:
        _set_rate(trainer, training, min(1.0, (time.monotonic() - begun) / seconds))

    model.add_callback("on_pretrain_routine_start", prepare)
    model.add_callback("on_train_start", start)
    model.add_callback("on_train_epoch_start", start_epoch)
    model.add_callback("on_train_batch_start", set_rate)


def _fall_with_steps(model: Any, training: Training) -> None:
    """Let the learning rate fall within each epoch, too: in a single one it would stay constant."""
    steps = 0

    def start_epoch(_: Any) -> None:
        nonlocal steps
        steps = 0

    def set_rate(trainer: Any) -> None:
        nonlocal steps
        done = trainer.epoch + steps / len(trainer.train_loader)
        _set_rate(trainer, training, done / trainer.epochs)
        steps += 1

    model.add_callback("on_train_epoch_start", start_epoch)
    model.add_callback("on_train_batch_start", set_rate)


def _set_rate(trainer: Any, training: Training, share: float) -> None:
    """Set the learning rate of a share of the training: along a cosine to a hundredth."""
    factor = _LAST_RATE + (1.0 - _LAST_RATE) * 0.5 * (1.0 + math.cos(math.pi * share))
    for group in trainer.optimizer.param_groups:
        group["lr"] = training.learning_rate * factor  # overruled during warm-up


def _use_processor_well(model: Any, training: Training) -> None:
    """Use the free cores for training, and the faster memory layout.

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
