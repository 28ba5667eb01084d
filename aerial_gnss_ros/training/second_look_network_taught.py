# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Trains the network that `aerial-gnss teach` makes, with a state to go on from.

Its first layers are those of the second look that ships: what they know of photographs and of water
tells robots from other things on water that the recording does not show.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import torch

from aerial_gnss_ros.core.values.errors import OutputError
from aerial_gnss_ros.detection.second_look_terms import Terms
from aerial_gnss_ros.training.second_look_network_fit import Fitting
from aerial_gnss_ros.training.second_look_network_pretrained import PretrainedNetwork, start_from
from aerial_gnss_ros.training.second_look_network_views import Variation
from aerial_gnss_ros.training.taught_examples import Examples

STEPS = 500
"""Of 128 boxes each. Judged."""
_SIDE = 64  # of what the backbone sees, px: half the time of the shipped second look's 96
_STORED_EVERY = 50
# A robot is known by its colours.
_VARIATION = Variation(greyed=0.2, exchanged=0.0, sharpened=0.0, unsure=0.0)


def fit_taught(
    examples: Examples,
    terms: Terms,
    steps: int,
    seed: int,
    state: Path,
    report: Callable[[int], None],
    threads: int = 0,
    start: Path | None = None,
) -> PretrainedNetwork:
    """Return the network.

    Args:
        examples: to learn from.
        terms: of the look.
        steps: of 128 boxes each.
        seed: same seed, examples and threads, same network.
        state: file with the state of a training of the same examples, to go on from; written now
            and then.
        report: called with the number of steps done.
        threads: of the processor; 0: one for each core.
        start: file of the first layers, see `start_from`; None: the shipped second look.

    Raises:
        ModelError: that file is missing or another network's.
        OutputError: the state cannot be written.
    """
    if threads:
        torch.set_num_threads(threads)
    network = _begun(len(terms.class_names), seed, start)
    fitting = Fitting(
        examples.proposals, terms, steps, seed, network, examples.wanted, _VARIATION
    )  # fmt: skip
    if state.is_file():
        fitting.restore(torch.load(state, weights_only=True))
        report(fitting.step)
    while fitting.step < steps:
        fitting.advance()
        report(fitting.step)
        if fitting.step % _STORED_EVERY == 0:
            _store(state, fitting.state())
    learnt: PretrainedNetwork = fitting.averaged()
    return learnt


def _begun(classes: int, seed: int, start: Path | None) -> PretrainedNetwork:
    """Return a network with another one's first layers, and a head that knows nothing."""
    torch.manual_seed(seed)
    network = PretrainedNetwork(classes, _SIDE)
    network.backbone.load_state_dict(start_from(start).backbone.state_dict())
    return network


def _store(path: Path, state: dict[str, Any]) -> None:
    hidden = path.with_name(f".{path.name}.partial")
    try:
        torch.save(state, hidden)
        hidden.replace(path)
    except (OSError, RuntimeError) as error:  # torch reports a full disk as RuntimeError
        hidden.unlink(missing_ok=True)
        raise OutputError(f"{path} cannot be written: {error}.") from error
