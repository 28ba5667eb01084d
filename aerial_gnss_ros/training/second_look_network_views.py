# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Views of boxes as the network of the second look sees them, varied for its training."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn import functional

from aerial_gnss_ros.detection.second_look_terms import Terms
from aerial_gnss_ros.training.proposals import ROOM, Proposals

_NOISY, _NOISE = 0.5, 0.03  # share of the views with more noise, its greatest standard deviation
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
        sharpened: share of the views that are sharpened or blurred, as cameras do.
        unsure: share of the views with the detector's score of another box: it is as sure of
            things that it has never seen as of robots.
    """

    greyed: float = 0.4
    exchanged: float = 0.3
    sharpened: float = 0.4
    unsure: float = 0.3


def scaled(values: Any) -> Any:
    """Return views of 0 to 1 as the network takes them."""
    return (values - 0.45) * 4.0


def varied(
    proposals: Proposals,
    chosen: NDArray[np.int64],
    terms: Terms,
    rng: np.random.Generator,
    variation: Variation,
    device: str = "cpu",
) -> tuple[Any, Any]:
    """Return augmented views and traits of some proposals, on torch's `device`."""
    count = len(chosen)

    def there(values: NDArray[Any]) -> Any:
        return torch.from_numpy(np.asarray(values, dtype=np.float32)).to(device)

    views = torch.from_numpy(proposals.views[chosen]).to(device)
    stored = views.permute(0, 3, 1, 2).float() / 255.0
    turns = rng.integers(0, 8, count)
    scales = np.exp(rng.uniform(-0.1, 0.1, count)) / ROOM
    move = np.zeros((count, 2, 3))
    move[:, :, :2] = _WAYS[turns] * scales[:, None, None]
    move[:, :, 2] = rng.normal(0.0, 0.015, (count, 2))
    shape = [count, 6, terms.side, terms.side]
    grid = functional.affine_grid(there(move), shape, align_corners=False)
    seen = functional.grid_sample(stored, grid, padding_mode="border", align_corners=False)
    light = rng.normal(0.0, 0.15, (count, 1, 1, 1)) + np.tile(
        rng.normal(0.0, 0.12, (count, 3, 1, 1)), (1, 2, 1, 1)
    )
    offset = rng.normal(0.0, 0.04, (count, 1, 1, 1))
    seen = seen * there(np.exp(light)) + there(offset)
    seen = _sharpened(_faded(seen, rng, variation), rng, variation)
    noise = np.where(rng.random(count) < _NOISY, rng.uniform(0.0, _NOISE, count), 0.0)
    seen = seen + there(noise).reshape(-1, 1, 1, 1) * torch.randn_like(seen)
    seen = seen.clamp(0.0, 1.0)
    traits = proposals.traits[chosen].copy()
    traits[turns % 2 == 1, 2] *= -1.0  # upright becomes lying
    traits[:, 0] += rng.normal(0.0, 0.15, count)  # it must not rely on the detector's score alone
    traits[:, 0] += np.where(rng.random(count) < 0.15, rng.normal(0.0, 0.7, count), 0.0)
    if variation.unsure:
        others = rng.permutation(traits[:, 0])
        traits[:, 0] = np.where(rng.random(count) < variation.unsure, others, traits[:, 0])
    return scaled(seen), there(traits)


def _sharpened(seen: Any, rng: np.random.Generator, variation: Variation) -> Any:
    """Return views (n, 6, side, side), some sharper, with seams along edges, or softer."""
    if not variation.sharpened:
        return seen
    count = len(seen)
    amounts = np.where(
        rng.random(count) < variation.sharpened, rng.uniform(-0.9, 1.5, count), 0.0
    ).astype(np.float32)
    soft = functional.avg_pool2d(seen, 3, 1, 1, count_include_pad=False)
    return seen + torch.from_numpy(amounts).to(seen.device).reshape(-1, 1, 1, 1) * (seen - soft)


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
    columns = torch.from_numpy(np.hstack([order, order + 3])).to(seen.device)
    seen = seen[torch.arange(count, device=seen.device)[:, None], columns]
    both = seen.reshape(count, 2, 3, *seen.shape[2:])
    faded = torch.lerp(
        both, both.mean(2, keepdim=True).expand_as(both),
        torch.from_numpy(share).to(seen.device).reshape(-1, 1, 1, 1, 1),
    )  # fmt: skip
    return faded.reshape(seen.shape)
