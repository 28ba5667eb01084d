# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cuts training samples of the small detector out of images, on any device of torch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch.nn import functional

from aerial_gnss_ros.training.small_network import STRIDE
from aerial_gnss_ros.training.small_samples import Crop, Pool, random_crop

_LEAST_SIGMA, _SIGMA = 0.45, 0.11  # of a centre: places, and of a robot's side
_FADED, _EXCHANGED, _NOISY = 0.2, 0.1, 0.3  # shares of the crops
_NOISE = 6.0 / 255.0  # largest


@dataclass(frozen=True)
class Batch:
    """What `small_network.loss` needs.

    Attributes:
        images: (n, 3, side, side) red, green, blue, 0 to 1.
        wanted: (n, classes, h, w) map of centres.
        weight: (n, 1, h, w) 0 where nothing is known.
        truth: (n, 4, h, w) centre and size of the robot that a place belongs to, px.
    """

    images: Any
    wanted: Any
    weight: Any
    truth: Any


class Sampler:
    """Draws batches from a pool of images, which it keeps on a device.

    Args:
        pool: of images.
        side: of a crop, px; a multiple of 32.
        classes: how many.
        device: of torch.
    """

    def __init__(self, pool: Pool, side: int, classes: int, device: str) -> None:
        self._pool, self._side, self._classes, self._device = pool, side, classes, device
        self._images = [torch.from_numpy(image).to(device) for image in pool.images]

    def draw(self, rng: np.random.Generator, count: int) -> Batch:
        """Return a batch of varied crops; all randomness is of `rng`."""
        crops, cut = [], []
        for number in self._pool.drawn(rng, count):
            image = self._images[number]
            size = image.shape[1], image.shape[0]
            of = self._pool.corners[number], self._pool.classes[number]
            crops.append(random_crop(rng, size, *of, self._side))
            cut.append(cut_out(image, crops[-1], self._side))
        images = coloured(rng, torch.stack(cut))
        return Batch(images, *maps_of(crops, self._side, self._classes, self._device))


def cut_out(image: Any, crop: Crop, side: int) -> Any:
    """Return a crop (3, side, side), red, green, blue, 0 to 1, of a tensor of bytes (h, w, 3)."""
    part = image[crop.top : crop.top + crop.reach, crop.left : crop.left + crop.reach]
    part = torch.rot90(part, crop.turns) if crop.turns else part
    part = part.flip(1) if crop.mirrored else part
    levels = part.permute(2, 0, 1)[None].float() / 255.0
    sized = functional.interpolate(
        levels, size=(side, side), mode="bilinear", align_corners=False, antialias=True
    )
    return sized[0].flip(0)


def coloured(rng: np.random.Generator, images: Any) -> Any:
    """Return images (n, 3, side, side) in other lights and with other colours, some with noise."""
    count = len(images)
    colours = np.tile(np.eye(3), (count, 1, 1))
    for number in np.flatnonzero(rng.random(count) < _EXCHANGED):
        colours[number] = colours[number][rng.permutation(3)]
    light = rng.normal(0.0, 0.18, (count, 1, 1)) + rng.normal(0.0, 0.08, (count, 3, 1))
    colours *= np.exp(light)
    faded = np.where(rng.random(count) < _FADED, rng.random(count), 0.0)[:, None, None]
    colours += faded * (colours.mean(1, keepdims=True) - colours)
    offset = rng.normal(0.0, 8.0 / 255.0, (count, 1, 1, 1))
    noise = np.where(rng.random(count) < _NOISY, rng.uniform(0.0, _NOISE, count), 0.0)
    on = {"device": images.device, "dtype": images.dtype}
    made = torch.einsum("nij,njhw->nihw", torch.tensor(colours, **on), images)
    made = made + torch.tensor(offset, **on)
    made += torch.tensor(noise, **on)[:, None, None, None] * torch.randn_like(made)
    return made.clamp(0.0, 1.0)


def maps_of(crops: Sequence[Crop], side: int, classes: int, device: str) -> tuple[Any, Any, Any]:
    """Return the wanted maps of centres, their weights, and the box that each place belongs to.

    Args:
        crops: with their robots.
        side: of the crops, px.
        classes: how many.
        device: of torch.

    Returns:
        (n, classes, h, w), (n, 1, h, w) and (n, 4, h, w), as in `Batch`.
    """
    n, places, most = len(crops), side // STRIDE, max(1, *(len(c.corners) for c in crops))
    table = np.zeros((n, most, 6))  # centre, size, class, whether there is one
    weight = np.ones((n, 1, places, places), np.float32)
    for i, crop in enumerate(crops):
        for left, top, right, bottom in crop.partly / STRIDE:
            rows = slice(int(top), int(np.ceil(bottom)))
            weight[i, 0, rows, int(left) : int(np.ceil(right))] = 0.0
        low, high = crop.corners[:, :2], crop.corners[:, 2:]
        size = np.maximum(high - low, 1.0)
        kinds = np.stack([crop.classes, np.ones(len(low))], 1)
        table[i, : len(low)] = np.hstack([(low + high) / 2, size, kinds])
        columns, rows = np.minimum((table[i, : len(low), :2] // STRIDE).astype(int), places - 1).T
        weight[i, 0, rows, columns] = 1.0
    known = torch.from_numpy(table.astype(np.float32)).to(device)
    middle = torch.arange(places, device=device) + 0.5
    centre, size = known[..., :2] / STRIDE, known[..., 2:4] / STRIDE
    sigma = (_SIGMA * size).clamp(min=_LEAST_SIGMA)
    across, down = ((middle - centre[..., a : a + 1]) / sigma[..., a : a + 1] for a in (0, 1))
    bump = torch.exp(-0.5 * (across[:, :, None, :] ** 2 + down[:, :, :, None] ** 2))
    at = centre.long().clamp(max=places - 1)
    peak = torch.arange(places, device=device)
    here = (peak == at[..., 0:1])[:, :, None, :] & (peak == at[..., 1:2])[:, :, :, None]
    bump = torch.where(here, 1.0, bump) * known[..., 5, None, None]
    wanted = torch.stack(
        [(bump * (known[..., 4] == kind)[..., None, None]).amax(1) for kind in range(classes)], 1
    )
    nearest = bump.argmax(1)  # (n, h, w)
    truth = torch.gather(
        known[..., :4].permute(0, 2, 1), 2, nearest.flatten(1)[:, None].expand(-1, 4, -1)
    ).reshape(n, 4, places, places)
    truth[:, 2:] = truth[:, 2:].clamp(min=1.0)
    return wanted, torch.from_numpy(weight).to(device), truth
