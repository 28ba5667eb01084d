# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trains the network of the second look, with torch."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn
from torch.nn import functional

from aerial_gnss_ros.detection.second_look_terms import Terms
from aerial_gnss_ros.training.proposals import Proposals
from aerial_gnss_ros.training.second_look_network_views import Variation, varied

BATCH = 128
_RATE, _WARM_UP, _DECAY = 5e-4, 100, 0.02
_AVERAGED = 0.998
_ROBOT_SHARE = 0.5
_SOFT = 0.01  # labels of 0.01 and 0.99: a few are wrong
_REPORTED_EVERY = 500
_EASY = (
    0.15  # relative frequency of boxes about which the detector is quite right; 1.15: quite wrong
)


def multiplies_bfloat16(capabilities: Mapping[str, Any] | None = None) -> bool:
    """Return whether the processor multiplies bfloat16 itself; torch emulates it on others.

    Emulation is slower than 32 bits.

    Args:
        capabilities: what torch says of the processor; None: torch is asked. Old versions of torch
            cannot tell, which counts as no.
    """
    if capabilities is None:
        capabilities = getattr(torch.cpu, "get_capabilities", dict)()
    return bool(capabilities.get("avx512_bf16") or capabilities.get("amx_bf16"))


_MULTIPLIES_BFLOAT16 = multiplies_bfloat16()


def fit(
    proposals: Proposals,
    terms: Terms,
    steps: int,
    seed: int,
    network: Any,
    threads: int = 0,
    report: Callable[[int, float], None] | None = None,
    device: str = "cpu",
    batch: int = BATCH,
) -> Any:
    """Return a network trained on the proposals, averaged over its last states.

    Args:
        proposals: training data; robots and others are drawn equally often, the detector's errors
            more often.
        terms: of the look.
        steps: of `batch` boxes each.
        seed: same seed, same network, on one kind of processor.
        network: to go on from.
        threads: of the processor; 0: one for each core.
        report: called periodically with the step and the mean loss.
        device: of torch, to train on.
        batch: boxes of a step.
    """
    if threads:
        torch.set_num_threads(threads)
    fitting = Fitting(proposals, terms, steps, seed, network, device=device, batch=batch)
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
        network: as for `fit`.
        wanted: (n, k) how well a proposal fits a robot of each class, 0 to 1; None: one output,
            `is_robot`.
        variation: of the views.
        device: as for `fit`.
        batch: as for `fit`.
    """

    def __init__(
        self,
        proposals: Proposals,
        terms: Terms,
        steps: int,
        seed: int,
        network: Any,
        wanted: NDArray[np.float32] | None = None,
        variation: Variation | None = None,
        device: str = "cpu",
        batch: int = BATCH,
    ) -> None:
        torch.manual_seed(seed)
        self._device, self._batch = device, batch
        self._rng = np.random.default_rng(seed)
        self._proposals, self._terms, self._steps = proposals, terms, steps
        self._variation = variation or Variation()
        self._wanted = proposals.is_robot.astype(np.float32) if wanted is None else wanted
        self.step = 0
        self.network = network
        self.network.to(device, memory_format=torch.channels_last)
        self.network.train()
        self._optimizer = torch.optim.AdamW(
            self.network.parameters(), lr=_RATE, weight_decay=_DECAY
        )
        self._mean = {name: value.clone() for name, value in self.network.state_dict().items()}
        self._chances = drawing(proposals)

    def advance(self) -> float:
        """Learn from one batch; return its loss."""
        warm = min(1.0, (self.step + 1) / _WARM_UP)
        rate = _RATE * warm * 0.5 * (1 + math.cos(math.pi * self.step / self._steps))
        for group in self._optimizer.param_groups:
            group["lr"] = rate + 1e-5
        chosen = self._rng.choice(len(self._proposals), self._batch, p=self._chances)
        views, traits = varied(
            self._proposals, chosen, self._terms, self._rng, self._variation, self._device
        )
        with torch.autocast("cpu", dtype=torch.bfloat16, enabled=_MULTIPLIES_BFLOAT16):
            odds = self.network(views.contiguous(memory_format=torch.channels_last), traits)
        wanted = torch.from_numpy(self._wanted[chosen]).to(self._device)
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

    def averaged(self) -> Any:
        """Return the network with the mean of its last states, for use on the processor."""
        network = copy.deepcopy(self.network).cpu()
        network.load_state_dict({name: value.cpu().clone() for name, value in self._mean.items()})
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


def _average(mean: dict[str, Any], network: Any, kept: float) -> None:
    for name, value in network.state_dict().items():
        if value.dtype.is_floating_point:
            mean[name].mul_(kept).add_(value, alpha=1.0 - kept)
        else:
            mean[name].copy_(value)
