# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Makes things of the pictures of a colour font: people, boats, animals, tools, flags, fruit.

Outlines and colours that somebody drew differ more from each other than those that a program draws
at random (`figures.py`), and none is a robot. A picture is turned, mirrored, squeezed, recoloured,
perhaps cut, and perhaps fades towards one side, as what hangs down into the water does.

The font is not part of this package: Debian's `fonts-noto-color-emoji` (SIL Open Font License; its
pictures Apache License 2.0) has 3,900 of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import InputError

F32 = NDArray[np.float32]
Picture = NDArray[np.uint8]  # (height, width, 4) blue, green, red, coverage
_ROOM = 1.5  # side of a drawing, lengths


def pictures_of(font: Path) -> list[Picture]:
    """Return the pictures of a font with coloured bitmaps (table CBDT), in the order of names.

    Raises:
        InputError: the file is no such font.
    """
    from fontTools.ttLib import TTFont, TTLibError

    try:
        strikes: Any = TTFont(font)["CBDT"].strikeData
    except (OSError, KeyError, TTLibError) as error:
        raise InputError(f"{font} is not a font with coloured bitmaps: {error}") from error
    found = []
    for _, glyph in sorted(strikes[0].items()):
        made = cv2.imdecode(np.frombuffer(glyph.imageData, np.uint8), cv2.IMREAD_UNCHANGED)
        if made is not None and made.ndim == 3 and made.shape[2] == 4 and made[..., 3].any():
            found.append(np.asarray(made, np.uint8))
    return found


def drawing(
    rng: np.random.Generator, length: float, pictures: Sequence[Picture]
) -> tuple[F32, F32]:
    """Return one of the pictures as a thing about `length` px long.

    Args:
        rng: all randomness.
        length: of its longer side, px.
        pictures: to choose from.

    Returns:
        Coverage (side, side), 0 to 1, and colours (side, side, 3), blue, green, red.
    """
    side = int(_ROOM * length) + 8
    picture = _part(rng, pictures[int(rng.integers(len(pictures)))].astype(np.float32))
    height, width = picture.shape[:2]
    scale = length / max(height, width)
    slender = float(np.exp(-abs(rng.normal(0.0, 0.3))))
    turn, mirrored = rng.uniform(0.0, 2.0 * np.pi), rng.choice([-1.0, 1.0])
    turning = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    linear = scale * turning @ np.diag([mirrored * slender, 1.0])
    shift = np.full(2, side / 2.0) - linear @ (np.array([width, height]) / 2.0)
    softness = max(0.0, 0.4 / scale - 0.4)  # against aliasing
    # Colours weighted by coverage, so that none comes in from beyond the outline.
    cover = picture[..., 3:] / 255.0
    soft = np.concatenate([picture[..., :3] * cover, cover], axis=2)
    if softness > 0.1:
        soft = cv2.GaussianBlur(soft, (0, 0), softness, borderType=cv2.BORDER_CONSTANT)
    moved = cv2.warpAffine(soft, np.hstack([linear, shift[:, None]]), (side, side))
    share = np.asarray(moved[..., 3], np.float32)
    colours = np.asarray(moved[..., :3] / np.maximum(share, 1e-3)[..., None], np.float32)
    return _fading(rng, share), recoloured(rng, colours)


def _part(rng: np.random.Generator, picture: F32) -> F32:
    """Return a picture without its empty edges, or a part of it."""
    rows, columns = np.nonzero(picture[..., 3] > 0)
    picture = picture[rows.min() : rows.max() + 1, columns.min() : columns.max() + 1]
    if rng.random() < 0.2:
        y, x = (int(rng.integers(0, size // 2 + 1)) for size in picture.shape[:2])
        height, width = (max(2, size // 2) for size in picture.shape[:2])
        part = picture[y : y + height, x : x + width]
        return part if part[..., 3].mean() > 20.0 else picture
    return picture


def _fading(rng: np.random.Generator, share: F32) -> F32:
    """Return a coverage, or one that falls towards one side: what is deeper shows less."""
    if rng.random() < 0.6:
        return np.asarray(share, np.float32)
    side = len(share)
    angle = rng.uniform(0.0, 2.0 * np.pi)
    across = np.linspace(-1.0, 1.0, side)
    along = across[None] * np.cos(angle) + across[:, None] * np.sin(angle)
    depth = np.clip((along - rng.uniform(-0.6, 0.4)) * rng.uniform(1.0, 4.0), 0.0, 1.0)
    return np.asarray(share * (1.0 - depth * rng.uniform(0.4, 1.0)), np.float32)


def recoloured(rng: np.random.Generator, colours: F32) -> F32:
    """Return colours (h, w, 3) exchanged, faded, stronger, darker or with another contrast."""
    if rng.random() < 0.5:
        colours = colours[..., rng.permutation(3)]
    mean = colours.mean(axis=2, keepdims=True)
    colours = mean + (colours - mean) * np.float32(rng.uniform(0.0, 1.5))
    if rng.random() < 0.15:
        colours = 255.0 - colours
    gain = np.exp(rng.normal(0.0, 0.3) + rng.normal(0.0, 0.1, 3)).astype(np.float32)
    made = 128.0 + (colours - 128.0) * np.float32(np.exp(rng.normal(0.0, 0.2)))
    return np.asarray(np.clip(made * gain, 0.0, 255.0), np.float32)
