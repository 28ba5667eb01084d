# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The network of the second look and its training: 350,000 weights, with torch."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn
from torch.nn import functional

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.second_look_terms import (
    INPUTS,
    METADATA,
    ODDS_UNIT,
    OUTPUT,
    Terms,
)
from aerial_gnss_ros.training.proposals import ROOM, Proposals
from aerial_gnss_ros.training.share import Share

_OPSET, _IR_VERSION = 17, 8  # read by ONNX Runtime 1.17 and later
_BATCH = 128
_RATE, _WARM_UP, _DECAY = 2e-3, 100, 0.02
_FURTHER_RATE = 7e-4  # from a trained network on
_AVERAGED = 0.998
_ROBOT_SHARE = 0.5
_EASY = (
    0.15  # relative frequency of boxes about which the detector is quite right; 1.15: quite wrong
)
_SOFT = 0.01  # labels of 0.01 and 0.99: a few are wrong
_REPORTED_EVERY = 500
_NOISY, _NOISE = 0.5, 0.03  # share of the views with more noise, its greatest standard deviation
_MEASURED = 2048  # boxes on which normalisations are restored
_WIDTHS = (24, 32, 64, 96)
_HIDDEN = 64
_QUARTER, _MIRROR = np.array([[0.0, -1.0], [1.0, 0.0]]), np.diag([-1.0, 1.0])
_WAYS = np.array([
    np.linalg.matrix_power(_QUARTER, k % 4) @ (_MIRROR if k >= 4 else np.eye(2)) for k in range(8)
])  # fmt: skip
"""A square's rotations and reflections; the odd ones exchange height and width."""


@dataclass(frozen=True)
class Variation:
    """How much the colours of views are varied.

    Attributes:
        greyed: share of the views whose colours are faded.
        exchanged: share of the views whose colours are exchanged: what is no robot may have any
            colour. Not for robots that are known by theirs.
    """

    greyed: float = 0.4
    exchanged: float = 0.3


class Network(nn.Module):  # type: ignore[misc]  # torch is optional
    """Views (n, 6, side, side) and traits (n, 3) to log odds: (n,), or (n, classes).

    Args:
        classes: number of classes that it tells apart; 0: it says only whether a box fits.
    """

    def __init__(self, classes: int = 0) -> None:
        super().__init__()
        self.classes = classes
        first, second, third, fourth = _WIDTHS
        self.body = nn.Sequential(
            _halved(6, first), _halved(first, second), _Residual(second), _halved(second, third),
            _Residual(third), _halved(third, fourth), _Residual(fourth),
        )  # fmt: skip
        self.head = nn.Sequential(
            nn.Linear(2 * fourth + 3, _HIDDEN), nn.SiLU(), nn.Linear(_HIDDEN, max(1, classes))
        )

    def forward(self, views: Any, traits: Any) -> Any:
        """Return log odds that a box fits a robot."""
        seen = self.body(views)
        features = torch.cat([seen.mean((2, 3)), seen.amax((2, 3)), traits], 1)
        odds = self.head(features)
        return odds if self.classes else odds[:, 0]


class _Residual(nn.Module):  # type: ignore[misc]
    def __init__(self, channels: int) -> None:
        super().__init__()
        self.inner = nn.Sequential(
            nn.Conv2d(channels, channels, 3, 1, 1, bias=False), nn.BatchNorm2d(channels), nn.SiLU(),
            nn.Conv2d(channels, channels, 3, 1, 1, bias=False), nn.BatchNorm2d(channels),
        )  # fmt: skip

    def forward(self, x: Any) -> Any:
        return functional.silu(x + self.inner(x))


def _halved(channels: int, out: int) -> Any:
    return nn.Sequential(
        nn.Conv2d(channels, out, 3, 2, 1, bias=False), nn.BatchNorm2d(out), nn.SiLU()
    )


class _FromBytes(nn.Module):  # type: ignore[misc]
    """The network with its pre- and post-processing, as exported."""

    def __init__(self, network: Network, share: Share) -> None:
        super().__init__()
        self.network = network
        self.share = share

    def forward(self, views: Any, traits: Any) -> Any:
        values = _scaled(views.permute(0, 3, 1, 2).float() / 255.0)
        odds = self.share.weight * self.network(values, traits)
        first = (1.0 - self.share.weight) * ODDS_UNIT * traits[:, 0]
        first = first[:, None] if self.network.classes else first
        return torch.sigmoid(odds + first + self.share.shift)


def _scaled(values: Any) -> Any:
    return (values - 0.45) * 4.0


def fit(
    proposals: Proposals,
    terms: Terms,
    steps: int,
    seed: int,
    threads: int = 0,
    report: Callable[[int, float], None] | None = None,
    start: Path | None = None,
) -> Network:
    """Return a network trained on the proposals, averaged over its last states.

    Args:
        proposals: training data; robots and others are drawn equally often, the detector's errors
            more often.
        terms: of the look.
        steps: of 128 boxes each.
        seed: same seed, same network, on one kind of processor.
        threads: of the processor; 0: one for each core.
        report: called periodically with the step and the mean loss.
        start: a second look to go on from; None: from scratch.

    Raises:
        ModelError: `start` is no network of this kind.
    """
    if threads:
        torch.set_num_threads(threads)
    fitting = Fitting(proposals, terms, steps, seed, start=start)
    losses = []
    for step in range(steps):
        losses.append(fitting.advance())
        if report is not None and (step + 1) % _REPORTED_EVERY == 0:
            report(step + 1, float(np.mean(losses[-_REPORTED_EVERY:])))
    return fitting.averaged()


class Fitting:
    """A training, step by step, which can be stored and gone on with.

    Args:
        proposals: as for `fit`.
        terms: of the look.
        steps: planned; the learning rate falls over them.
        seed: as for `fit`.
        wanted: (n, k) 1 where a proposal is of a class, else 0; None: one output, `is_robot`.
        variation: of the views.
        start: as for `fit`.
    """

    def __init__(
        self,
        proposals: Proposals,
        terms: Terms,
        steps: int,
        seed: int,
        wanted: NDArray[np.float32] | None = None,
        variation: Variation | None = None,
        start: Path | None = None,
    ) -> None:
        torch.manual_seed(seed)
        self._rng = np.random.default_rng(seed)
        self._proposals, self._terms, self._steps = proposals, terms, steps
        self._variation = variation or Variation()
        self._wanted = proposals.is_robot.astype(np.float32) if wanted is None else wanted
        self.step = 0
        self.network = Network(0 if wanted is None else wanted.shape[1])
        if start is not None:
            fill(self.network, start)
            _restore_normalisation(self.network, proposals, terms, self._rng)
            self.network.train()
        self.network.to(memory_format=torch.channels_last)
        self._optimizer = torch.optim.AdamW(
            self.network.parameters(), lr=_RATE, weight_decay=_DECAY
        )
        self._mean = {name: value.clone() for name, value in self.network.state_dict().items()}
        self._chances = drawing(proposals)
        self._first = _RATE if start is None else _FURTHER_RATE

    def advance(self) -> float:
        """Learn from one batch; return its loss."""
        warm = min(1.0, (self.step + 1) / _WARM_UP)
        rate = self._first * warm * 0.5 * (1 + math.cos(math.pi * self.step / self._steps))
        for group in self._optimizer.param_groups:
            group["lr"] = rate + 1e-5
        chosen = self._rng.choice(len(self._proposals), _BATCH, p=self._chances)
        views, traits = _varied(self._proposals, chosen, self._terms, self._rng, self._variation)
        with torch.autocast("cpu", dtype=torch.bfloat16):
            odds = self.network(views.contiguous(memory_format=torch.channels_last), traits)
        wanted = torch.from_numpy(self._wanted[chosen])
        loss = functional.binary_cross_entropy_with_logits(
            odds.float(), wanted * (1.0 - 2.0 * _SOFT) + _SOFT
        )
        self._optimizer.zero_grad()
        loss.backward()
        nn.utils.clip_grad_norm_(self.network.parameters(), 5.0)
        self._optimizer.step()
        _average(self._mean, self.network, min(_AVERAGED, (self.step + 1) / (self.step + 11)))
        self.step += 1
        return float(loss.detach())

    def averaged(self) -> Network:
        """Return the network with the mean of its last states, for use."""
        network = Network(self.network.classes)
        network.load_state_dict({name: value.clone() for name, value in self._mean.items()})
        network.to(memory_format=torch.channels_last)
        network.eval()
        return network

    def state(self) -> dict[str, Any]:
        """Return all that a continuation needs, for `torch.save`."""
        return {
            "step": self.step,
            "network": self.network.state_dict(),
            "mean": self._mean,
            "optimizer": self._optimizer.state_dict(),
            "numpy": self._rng.bit_generator.state,
            "torch": torch.get_rng_state(),
        }

    def restore(self, state: dict[str, Any]) -> None:
        """Go on from a state."""
        self.step = state["step"]
        self.network.load_state_dict(state["network"])
        self._mean = state["mean"]
        self._optimizer.load_state_dict(state["optimizer"])
        self._rng.bit_generator.state = state["numpy"]
        torch.set_rng_state(state["torch"])


def drawing(proposals: Proposals) -> NDArray[np.float64]:
    """Return the probability with which each proposal (n,) is drawn."""
    wrong = np.where(proposals.is_robot, 1.0 - proposals.scores, proposals.scores)
    chances = proposals.weights * (_EASY + wrong)
    for kind, share in (
        (proposals.is_robot, _ROBOT_SHARE),
        (~proposals.is_robot, 1 - _ROBOT_SHARE),
    ):
        chances[kind] *= share / max(chances[kind].sum(), np.finfo(float).tiny)
    return np.asarray(chances / chances.sum(), dtype=np.float64)


def _average(mean: dict[str, Any], network: Network, kept: float) -> None:
    for name, value in network.state_dict().items():
        if value.dtype.is_floating_point:
            mean[name].mul_(kept).add_(value, alpha=1.0 - kept)
        else:
            mean[name].copy_(value)


def _varied(
    proposals: Proposals,
    chosen: NDArray[np.int64],
    terms: Terms,
    rng: np.random.Generator,
    variation: Variation,
) -> tuple[Any, Any]:
    """Return augmented views and traits of some proposals."""
    count = len(chosen)
    stored = torch.from_numpy(proposals.views[chosen]).permute(0, 3, 1, 2).float() / 255.0
    turns = rng.integers(0, 8, count)
    scales = np.exp(rng.uniform(-0.1, 0.1, count)) / ROOM
    move = np.zeros((count, 2, 3))
    move[:, :, :2] = _WAYS[turns] * scales[:, None, None]
    move[:, :, 2] = rng.normal(0.0, 0.015, (count, 2))
    grid = functional.affine_grid(
        torch.from_numpy(move.astype(np.float32)), [count, 6, terms.side, terms.side],
        align_corners=False,
    )  # fmt: skip
    seen = functional.grid_sample(stored, grid, padding_mode="border", align_corners=False)
    light = rng.normal(0.0, 0.15, (count, 1, 1, 1)) + np.tile(
        rng.normal(0.0, 0.12, (count, 3, 1, 1)), (1, 2, 1, 1)
    )
    offset = rng.normal(0.0, 0.04, (count, 1, 1, 1))
    seen = seen * torch.from_numpy(np.exp(light).astype(np.float32))
    seen = seen + torch.from_numpy(offset.astype(np.float32))
    seen = _faded(seen, rng, variation)
    noise = np.where(rng.random(count) < _NOISY, rng.uniform(0.0, _NOISE, count), 0.0)
    sizes = torch.from_numpy(noise.astype(np.float32)).reshape(-1, 1, 1, 1)
    seen = (seen + sizes * torch.randn_like(seen)).clamp(0.0, 1.0)
    traits = proposals.traits[chosen].copy()
    traits[turns % 2 == 1, 2] *= -1.0  # upright becomes lying
    traits[:, 0] += rng.normal(0.0, 0.15, count)  # it must not rely on the detector's score alone
    traits[:, 0] += np.where(rng.random(count) < 0.15, rng.normal(0.0, 0.7, count), 0.0)
    return _scaled(seen), torch.from_numpy(traits)


def network_inputs(proposals: Proposals, terms: Terms) -> tuple[Any, Any]:
    """Return the views and traits of proposals as the exported network sees them."""
    edge = (proposals.views.shape[1] - terms.side) // 2
    here = slice(edge, edge + terms.side)
    seen = torch.from_numpy(proposals.views[:, here, here]).permute(0, 3, 1, 2).float() / 255.0
    return _scaled(seen), torch.from_numpy(proposals.traits)


def _faded(seen: Any, rng: np.random.Generator, variation: Variation) -> Any:
    """Return views (n, 6, side, side), some with faded or exchanged colours, near and wide alike.

    What is no robot may have any colour, whatever colours it had in training.
    """
    count = len(seen)
    share = np.where(rng.random(count) < variation.greyed, rng.random(count), 0.0).astype(
        np.float32
    )
    order = np.tile(np.arange(3), (count, 1))
    order[rng.random(count) < variation.exchanged] = rng.permutation(3)
    columns = torch.from_numpy(np.hstack([order, order + 3]))
    seen = seen[torch.arange(count)[:, None], columns]
    both = seen.reshape(count, 2, 3, *seen.shape[2:])
    faded = torch.lerp(
        both, both.mean(2, keepdim=True).expand_as(both),
        torch.from_numpy(share).reshape(-1, 1, 1, 1, 1),
    )  # fmt: skip
    return faded.reshape(seen.shape)


def fill(network: Network, path: Path) -> None:
    """Set a network's weights to an exported one's, its normalisations to the identity.

    Raises:
        ModelError: the file is no network of this kind.
    """
    import onnx
    from onnx import numpy_helper

    try:
        graph = onnx.load(path).graph
    except Exception as error:  # protobuf raises its own, which is no part of onnx's interface
        raise ModelError(f"{path} is not an ONNX model: {error}") from error
    stored = {item.name: numpy_helper.to_array(item) for item in graph.initializer}
    # The export merges each normalisation into the convolution before it, and keeps their order.
    merged = [node.input for node in graph.node if node.op_type == "Conv"]
    convolutions = [layer for layer in network.modules() if isinstance(layer, nn.Conv2d)]
    norms = [layer for layer in network.modules() if isinstance(layer, nn.BatchNorm2d)]
    try:
        with torch.no_grad():
            for conv, norm, (_, weight, bias) in zip(convolutions, norms, merged, strict=True):
                conv.weight.copy_(torch.from_numpy(stored[weight].copy()))
                norm.running_var.fill_(1.0 - norm.eps)
                norm.bias.copy_(torch.from_numpy(stored[bias].copy()))
            for name, value in network.head.named_parameters():
                value.copy_(torch.from_numpy(stored[f"network.head.{name}"].copy()))
    except (KeyError, ValueError, RuntimeError) as error:
        raise ModelError(
            f"{path} is not a second look of this architecture; give one that "
            "aerial_gnss_ros.training.second_look made."
        ) from error


def _restore_normalisation(
    network: Network, proposals: Proposals, terms: Terms, rng: np.random.Generator
) -> None:
    """Let normalisations know the mean and variance that they see, with unchanged output."""
    convolutions = [layer for layer in network.modules() if isinstance(layer, nn.Conv2d)]
    norms = [layer for layer in network.modules() if isinstance(layer, nn.BatchNorm2d)]
    seen: dict[Any, list[Any]] = {conv: [] for conv in convolutions}
    hooks = [
        conv.register_forward_hook(
            lambda layer, _, output: seen[layer].append(
                torch.stack([output.mean((0, 2, 3)), output.square().mean((0, 2, 3))])
            )
        )
        for conv in convolutions
    ]
    network.eval()
    with torch.no_grad():
        for _ in range(_MEASURED // _BATCH):
            chosen = rng.choice(len(proposals), _BATCH, p=drawing(proposals))
            network(*_varied(proposals, chosen, terms, rng, Variation()))
        for hook in hooks:
            hook.remove()
        for conv, norm in zip(convolutions, norms, strict=True):
            mean, square = torch.stack(seen[conv]).mean(0)
            norm.running_mean.copy_(mean)
            norm.running_var.copy_((square - mean.square()).clamp(min=0.0))
            norm.weight.copy_((norm.running_var + norm.eps).sqrt())
            norm.bias.add_(mean)


def write(network: Network, terms: Terms, share: Share, path: Path) -> None:
    """Write the .onnx file that `detection.second_look` reads.

    Args:
        network: learnt.
        terms: of the look.
        share: of the second look in the score.
        path: of the file, which is overwritten.
    """
    import onnx

    example = (torch.zeros((2, terms.side, terms.side, 6), dtype=torch.uint8), torch.zeros((2, 3)))
    with warnings.catch_warnings():
        # Warning about another exporter, which needs another package.
        warnings.simplefilter("ignore")
        torch.onnx.export(
            _FromBytes(network, share).eval(), example, str(path), input_names=list(INPUTS),
            output_names=[OUTPUT], opset_version=_OPSET, dynamo=False,
            dynamic_axes={name: {0: "boxes"} for name in (*INPUTS, OUTPUT)},
        )  # fmt: skip
    model = onnx.load(path)
    model.ir_version = _IR_VERSION
    item = model.metadata_props.add()
    item.key, item.value = METADATA, terms.text
    onnx.save(model, path)
