# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trains the network that `aerial-gnss teach` makes: early stopping, and a state to go on from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch.nn import functional

from aerial_gnss_ros.core.values.errors import OutputError
from aerial_gnss_ros.detection.second_look_terms import Terms
from aerial_gnss_ros.training.second_look_network import Network
from aerial_gnss_ros.training.second_look_network_fit import Fitting
from aerial_gnss_ros.training.second_look_network_views import Variation, network_inputs
from aerial_gnss_ros.training.taught_examples import Examples

# A robot is known by its colours.
_VARIATION = Variation(greyed=0.2, exchanged=0.0, sharpened=0.0, unsure=0.0)


@dataclass(frozen=True)
class Stopping:
    """When a training ends.

    Attributes:
        steps: greatest number, of 128 boxes each.
        every: steps between two looks at the part kept for stopping.
        patience: so many looks without a smaller loss end it.
        better: a loss counts as smaller below this share of the least one so far.
    """

    steps: int = 400
    every: int = 25
    patience: int = 4
    better: float = 0.98


def fit_taught(
    examples: Examples,
    aside: Examples,
    terms: Terms,
    stopping: Stopping,
    seed: int,
    state: Path,
    report: Callable[[int], None],
    threads: int = 0,
) -> Network:
    """Return the network with the least loss on examples kept aside; from scratch.

    Args:
        examples: to learn from.
        aside: to decide when to stop.
        terms: of the look.
        stopping: when it ends.
        seed: same seed, examples and threads, same network.
        state: file with the state of a training of the same examples, to go on from; written at
            each look.
        report: called with the number of steps done.
        threads: of the processor; 0: one for each core.

    Raises:
        OutputError: the state cannot be written.
    """
    if threads:
        torch.set_num_threads(threads)
    fitting = Fitting(examples.proposals, terms, stopping.steps, seed, examples.wanted, _VARIATION)
    inputs = network_inputs(aside.proposals, terms)
    wanted = torch.from_numpy(aside.wanted)
    least, without, best = np.inf, 0, fitting.averaged()
    if state.is_file():
        stored = torch.load(state, weights_only=True)
        fitting.restore(stored["fitting"])
        least, without = stored["least"], stored["without"]
        best.load_state_dict(stored["best"])
        report(fitting.step)
    while fitting.step < stopping.steps and without < stopping.patience:
        fitting.advance()
        report(fitting.step)
        if fitting.step % stopping.every:
            continue
        network = fitting.averaged()
        loss = _loss(network, inputs, wanted)
        without += 1
        if loss < stopping.better * least:
            least, without, best = loss, 0, network
        _store(state, {
            "fitting": fitting.state(), "least": least, "without": without,
            "best": best.state_dict(),
        })  # fmt: skip
    return best


def _loss(network: Network, inputs: tuple[Any, Any], wanted: Any) -> float:
    with torch.no_grad():
        odds = network(*inputs)
        # Robots and others count alike, however many there are of each.
        robot = wanted.amax(1) > 0
        each = functional.binary_cross_entropy_with_logits(odds, wanted, reduction="none").sum(1)
        parts = [each[kind].mean() for kind in (robot, ~robot) if bool(kind.any())]
        return float(torch.stack(parts).mean()) if parts else 0.0


def _store(path: Path, state: dict[str, Any]) -> None:
    hidden = path.with_name(f".{path.name}.partial")
    try:
        torch.save(state, hidden)
        hidden.replace(path)
    except (OSError, RuntimeError) as error:  # torch reports a full disk as RuntimeError
        hidden.unlink(missing_ok=True)
        raise OutputError(f"{path} cannot be written: {error}.") from error
