# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trains the small detector without ultralytics: weights under a licence of your own.

python -m aerial_gnss_ros.training.small FOLDER ... -o RUN --start nanodet.json --time 1

RUN has state.pt, from which a training that was stopped goes on when the same command is given
again, and at the end small.onnx.
"""

from __future__ import annotations

import argparse
import copy
import math
import os
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.core.values.errors import AerialGnssError, ConfigError, InputError, ModelError
from aerial_gnss_ros.resources import install_hint
from aerial_gnss_ros.text.sentences import counted
from aerial_gnss_ros.training.labelled import LabelledImage, read_labels
from aerial_gnss_ros.training.labelled_bag import is_bag, read_bag
from aerial_gnss_ros.training.small_samples import Pool

STATE, RESULT = "state.pt", "small.onnx"
_DECAY = 0.02
_WARM_UP = 100  # steps
_LAST_RATE = 0.01  # of the first learning rate
_AVERAGED = 0.998
_REPORTED_EVERY = 50
_SAVED_EVERY_S = 120.0


@dataclass(frozen=True)
class SmallPlan:
    """How to train.

    Attributes:
        hours: of training; the learning rate falls to its end within it. 0: `steps`.
        steps: how many, if `hours` is 0: the same weights again on one kind of processor.
        side: of a crop, px; a multiple of 32.
        batch: crops a step.
        learning_rate: at the start, of AdamW; falls along a cosine to a hundredth.
        seed: of the first weights and of the crops.
        threads: of the processor; 0: the library decides.
        device: of torch, such as cpu or cuda.
        bfloat16: compute in 16 bits: faster with AVX512-BF16, AMX or a GPU.

    Raises:
        ConfigError: a value out of its range.
    """

    hours: float = 0.0
    steps: int = 0
    side: int = 320
    batch: int = 16
    learning_rate: float = 0.002
    seed: int = 0
    threads: int = 0
    device: str = "cpu"
    bfloat16: bool = False

    def __post_init__(self) -> None:
        for name, value, low, high in (
            ("time", self.hours, 0.0, 10_000.0), ("steps", self.steps, 0, 10**9),
            ("side", self.side, 64, 2048), ("batch", self.batch, 1, 4096),
            ("learning-rate", self.learning_rate, 1e-7, 1.0), ("threads", self.threads, 0, 1024),
        ):  # fmt: skip
            if not low <= value <= high:
                raise ConfigError(f"--{name} must lie within {low:g} to {high:g}, got {value:g}.")
        if (self.hours > 0.0) == (self.steps > 0):
            raise ConfigError("give --time or --steps: how long to train.")
        if self.side % 32:
            raise ConfigError(f"--side must be a multiple of 32 px, got {self.side}.")

    def done(self, step: int, spent_s: float) -> float:
        """Return the share of the training that is done."""
        return step / self.steps if self.steps else spent_s / (3600.0 * self.hours)


def fit(
    pool: Pool,
    plan: SmallPlan,
    folder: Path,
    names: tuple[str, ...],
    start: Path | None = None,
    report: Callable[[int, float, float], None] | None = None,
) -> Path:
    """Train to the end of the plan, from the folder's state if it has one; return the .onnx file.

    Args:
        pool: of labelled images.
        plan: how.
        folder: of the run; created if it is missing.
        names: of the classes.
        start: what to begin from (`started`); None: random weights.
        report: called periodically with the step, the mean loss, and the share of the time used.

    Raises:
        InputError: a state that cannot be read.
        ModelError: a network to start from that is of another kind.
    """
    import torch

    from aerial_gnss_ros.training.small_batch import Sampler
    from aerial_gnss_ros.training.small_network import loss, write

    if plan.threads:
        torch.set_num_threads(plan.threads)
    torch.manual_seed(plan.seed)
    torch.backends.cudnn.benchmark = True
    folder.mkdir(parents=True, exist_ok=True)
    network = started(start, len(names)).to(plan.device, memory_format=torch.channels_last)
    mean = copy.deepcopy(network)
    optimizer = torch.optim.AdamW(network.parameters(), plan.learning_rate, weight_decay=_DECAY)
    step, spent = 0, 0.0
    state = folder / STATE
    if state.is_file():
        stored = _stored(state)
        network.load_state_dict(stored["network"])
        mean.load_state_dict(stored["mean"])
        optimizer.load_state_dict(stored["optimizer"])
        step, spent = stored["step"], stored["spent"]
    sampler = Sampler(pool, plan.side, len(names), plan.device)
    rng = np.random.default_rng([plan.seed, step])
    begun, saved, losses = time.monotonic() - spent, time.monotonic(), list[Any]()
    network.train()
    while (share := plan.done(step, time.monotonic() - begun)) < 1.0:
        rate = _rate(plan.learning_rate, step, share)
        for group in optimizer.param_groups:
            group["lr"] = rate
        batch = sampler.draw(rng, plan.batch)
        with torch.autocast(plan.device.split(":")[0], torch.bfloat16, enabled=plan.bfloat16):
            maps = network(batch.images.contiguous(memory_format=torch.channels_last))
        error = loss(maps.float(), batch.wanted, batch.weight, batch.truth)
        optimizer.zero_grad()
        error.backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), 10.0)
        optimizer.step()
        step += 1
        _average(mean, network, min(_AVERAGED, step / (step + 10)))
        losses = [*losses[1 - _REPORTED_EVERY :], error.detach()]
        if report is not None and step % _REPORTED_EVERY == 0:
            report(step, float(torch.stack(losses).mean()), share)
        if time.monotonic() - saved > _SAVED_EVERY_S:
            _save(state, network, mean, optimizer, step, time.monotonic() - begun)
            saved = time.monotonic()
    _save(state, network, mean, optimizer, step, time.monotonic() - begun)
    write(mean.cpu(), names, folder / RESULT)
    return folder / RESULT


def started(start: Path | None, classes: int) -> Any:
    """Return a network to train.

    Args:
        start: another run's state.pt; an .onnx file of a small detector; nanodet.json, whose
            weights know COCO's photographs (`backbone.load_coco`); None: random weights.
        classes: number of classes.

    Raises:
        InputError: a state that cannot be read.
        ModelError: another file that cannot be read, or another network's.
    """
    from aerial_gnss_ros.training.small_network import SmallDetector, from_coco, read

    if start is None:
        return SmallDetector(classes)
    if start.suffix == ".json":
        return from_coco(start, classes)
    if start.suffix == ".onnx":
        return read(start, classes)
    network = SmallDetector(classes)
    network.load_state_dict(_stored(start)["mean"])
    return network


def _rate(first: float, step: int, share: float) -> float:
    """Return the learning rate at a share of the time: along a cosine, after a warm-up."""
    fallen = _LAST_RATE + (1.0 - _LAST_RATE) * 0.5 * (1.0 + math.cos(math.pi * min(1.0, share)))
    return first * fallen * min(1.0, (step + 1) / _WARM_UP)


def _average(mean: Any, network: Any, kept: float) -> None:
    values = network.state_dict()
    for name, value in mean.state_dict().items():
        if value.dtype.is_floating_point:
            value.mul_(kept).add_(values[name], alpha=1.0 - kept)
        else:
            value.copy_(values[name])


def _save(path: Path, network: Any, mean: Any, optimizer: Any, step: int, spent: float) -> None:
    import torch

    partial = path.with_name(f".{path.name}.partial")
    torch.save(
        {
            "network": network.state_dict(), "mean": mean.state_dict(),
            "optimizer": optimizer.state_dict(), "step": step, "spent": spent,
        },
        partial,
    )  # fmt: skip
    partial.replace(path)


def _stored(path: Path) -> dict[str, Any]:
    """Return a state; numbers only, so that a foreign file cannot run code.

    Raises:
        InputError: it cannot be read.
    """
    import torch

    try:
        stored: dict[str, Any] = torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # pickle, zip and torch each raise their own
        raise InputError(f"{path} is not a state of this training, or is damaged.") from error
    return stored


def read_pool(folders: Sequence[tuple[Path, float]]) -> Pool:
    """Return the labelled images of folders, each with its weight.

    Raises:
        InputError: a folder without images, or a label that cannot be read.
    """

    def of(one: tuple[Path, float]) -> Pool:
        pool = Pool()
        pool.add(images_of(one[0]), one[1])
        return pool

    whole = Pool()
    with ThreadPoolExecutor(os.cpu_count()) as readers:
        for part in readers.map(of, folders):
            whole.extend(part)
    return whole


def images_of(folder: Path) -> Iterable[LabelledImage]:
    """Return the labelled images of a flight, or of a data set's train split."""
    return read_bag(folder) if is_bag(folder) else read_labels(folder, "train")


def main(arguments: list[str] | None = None) -> int:
    """Run from the command line; returns the exit status."""
    given = _parser().parse_args(arguments)
    try:
        _train(given)
    except AerialGnssError as error:
        sys.stderr.write(f"small: {error}\n")
        return 2
    return 0


def _train(given: argparse.Namespace) -> None:
    plan = SmallPlan(
        given.time, given.steps, given.side, given.batch, given.learning_rate, given.seed,
        given.threads, given.device, given.bfloat16,
    )  # fmt: skip
    try:
        import torch  # noqa: F401 - looked for before images are read
    except ImportError as error:
        raise ModelError(
            f"training a small detector needs torch; install it with {install_hint('ultralytics')}."
        ) from error
    weighted = [(1.0, given.folders), *map(_weighted, given.times)]
    pool = read_pool([(Path(folder), weight) for weight, some in weighted for folder in some])
    robots = sum(map(len, pool.corners))
    _say(f"{counted(len(pool.images), 'image')}, {counted(robots, 'robot')}")
    file = fit(
        pool, plan, given.output, tuple(given.names), given.start,
        lambda step, error, share: _say(f"step {step}: loss {error:.3f}, {100 * share:.0f} %"),
    )  # fmt: skip
    _say(f"{file}")


def _weighted(given: list[str]) -> tuple[float, list[str]]:
    try:
        return float(given[0]), given[1:]
    except ValueError as error:
        raise ConfigError(
            f"--times needs a number before its folders, got {given[0]!r}."
        ) from error


def _say(words: str) -> None:
    sys.stdout.write(f"{words}\n")
    sys.stdout.flush()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="small", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", nargs="+", help="labelled images (split train) or flights")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="RUN")
    parser.add_argument("--time", type=float, default=SmallPlan.hours, metavar="HOURS")
    parser.add_argument("--steps", type=int, default=SmallPlan.steps, help="instead of --time")
    parser.add_argument(
        "--times", nargs="+", action="append", default=[], metavar="N FOLDER",
        help="a number and further folders, each counted that many times; may be repeated",
    )  # fmt: skip
    parser.add_argument(
        "--start", type=Path, metavar="FILE",
        help="state.pt or .onnx to go on from, or nanodet.json",
    )  # fmt: skip
    parser.add_argument("--names", nargs="+", default=["aqua"], help="of the classes")
    parser.add_argument("--side", type=int, default=SmallPlan.side, help="of a crop, px")
    parser.add_argument("--batch", type=int, default=SmallPlan.batch, help="crops a step")
    parser.add_argument("--learning-rate", type=float, default=SmallPlan.learning_rate)
    parser.add_argument("--seed", type=int, default=SmallPlan.seed)
    parser.add_argument("--threads", type=int, default=SmallPlan.threads)
    parser.add_argument("--device", default=SmallPlan.device, help="cpu or cuda (default cpu)")
    parser.add_argument("--bfloat16", action="store_true", help="compute in 16 bits")
    return parser


if __name__ == "__main__":
    sys.exit(main())
