# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Converts linear light to an 8-bit image: exposure, colour, tone curve, blur, noise."""

from __future__ import annotations

import cv2
import numpy as np

from aerial_gnss_ros.simulation.planes import F32, U8, merge, transform
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.view import Window

TARGET = 0.22
"""Linear level to which the automatic exposure brings the geometric mean of the picture."""
LUT_RANGE = 2.5
_LUT_STEPS = 4096
_NOISE_SIZE = 512


def _tone_curve() -> U8:
    x = np.arange(_LUT_STEPS) / (_LUT_STEPS - 1) * LUT_RANGE
    # Linear up to one half, then a shoulder that compresses highlights.
    y = np.where(x < 0.5, x, 0.5 + 0.5 * (1.0 - np.exp(-(x - 0.5) / 0.5)))
    srgb = np.where(y < 0.0031308, 12.92 * y, 1.055 * np.maximum(y, 1e-9) ** (1 / 2.4) - 0.055)
    return np.round(np.clip(srgb, 0.0, 1.0) * 255.0).astype(np.uint8)


_CURVE = _tone_curve()


def _light_of_levels() -> F32:
    levels = np.arange(256)
    first = np.searchsorted(_CURVE, levels, "left")
    last = np.searchsorted(_CURVE, levels, "right") - 1
    middle = (
        0.5 * (first + last) + 0.25
    )  # a step is cut off to a whole number: rounding is harmless
    light: F32 = (middle / (_LUT_STEPS - 1) * LUT_RANGE).astype(np.float32)
    return light


_LIGHT = _light_of_levels()


def as_light(image: U8) -> F32:
    """Return the linear light of an 8-bit image: the tone curve backwards."""
    light: F32 = _LIGHT[image]
    return light


def as_levels(light: F32) -> U8:
    """Return linear light, exposed already, as 8-bit levels."""
    steps = np.clip(light, 0.0, LUT_RANGE) * np.float32((_LUT_STEPS - 1) / LUT_RANGE)
    levels: U8 = _CURVE[steps.astype(np.uint16)]
    return levels


class Developer:
    """Exposure and processing of the camera for one scene."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        luma = np.array([0.0722, 0.7152, 0.2126])
        s = scene.saturation
        mix = s * np.eye(3) + (1.0 - s) * np.tile(luma, (3, 1))
        self._colour = mix * np.array(scene.white_balance)[None, :]
        rng = np.random.default_rng([scene.seed, 4])
        noise = rng.standard_normal((_NOISE_SIZE, _NOISE_SIZE, 3), dtype=np.float32)
        self._noise = np.round(noise * np.float32(scene.noise)).astype(np.int16)

    def gain(self, coarse: list[F32]) -> float:
        """Exposure for a coarse rendering (three planes) of the whole picture."""
        luma = 0.0722 * coarse[0] + 0.7152 * coarse[1] + 0.2126 * coarse[2]
        mean = float(np.exp(np.log(np.maximum(luma, 1e-3)).mean()))
        # A camera also meters the bright parts: it does not overexpose a third of the image.
        bright = float(np.quantile(luma, 0.85))
        return self._scene.exposure * min(TARGET / mean, 0.95 / max(bright, 1e-3))

    def tone(self, planes: list[F32], gain: float, window: Window, size: tuple[int, int]) -> U8:
        """Linear planes to 8-bit blue, green, red (h, w, 3), without blur and noise."""
        if self._scene.vignette > 0.0:
            fall = self._vignette(window, size)
            planes = [plane * fall for plane in planes]
        image = transform(merge(planes), self._colour * gain)
        return as_levels(image)

    def finish(self, image: U8, frame_seed: int) -> U8:
        """Lens softness, motion blur and sensor noise."""
        if self._scene.blur_px > 0.15:
            image = np.asarray(cv2.GaussianBlur(image, (0, 0), self._scene.blur_px), np.uint8)
        if max(map(abs, self._scene.motion_px)) > 0.3:
            image = np.asarray(cv2.filter2D(image, -1, _streak(self._scene.motion_px)), np.uint8)
        if self._scene.noise > 0.0:
            rng = np.random.default_rng([self._scene.seed, 3, frame_seed])
            dy, dx = rng.integers(_NOISE_SIZE, size=2)
            h, w = image.shape[:2]
            repeats = (-(-(h + dy) // _NOISE_SIZE), -(-(w + dx) // _NOISE_SIZE), 1)
            noise = np.tile(self._noise, repeats)[dy : dy + h, dx : dx + w]
            image = np.asarray(cv2.add(image, noise, dtype=cv2.CV_8U), np.uint8)
        return image

    def _vignette(self, window: Window, size: tuple[int, int]) -> F32:
        """Brightness (h, w) relative to the image's middle."""
        x = (np.arange(window.width) + window.x) / (size[0] - 1) * 2.0 - 1.0
        y = (np.arange(window.height) + window.y) / (size[1] - 1) * 2.0 - 1.0
        half = 0.5 * self._scene.vignette
        across, down = (half * x**2).astype(np.float32), (1.0 - half * y**2).astype(np.float32)
        fall: F32 = down[:, None] - across[None, :]
        return fall


def _streak(motion: tuple[float, float]) -> F32:
    """Kernel of a straight motion (right, down) in px during the exposure."""
    half = int(np.ceil(max(map(abs, motion)) / 2.0)) + 1
    kernel = np.zeros((2 * half + 1, 2 * half + 1), np.float32)
    for step in np.linspace(-0.5, 0.5, 33):
        x, y = half + step * motion[0], half + step * motion[1]
        x0, y0 = int(np.floor(x)), int(np.floor(y))
        for i, wy in ((y0, y0 + 1 - y), (y0 + 1, y - y0)):
            for j, wx in ((x0, x0 + 1 - x), (x0 + 1, x - x0)):
                kernel[i, j] += wx * wy
    result: F32 = kernel / kernel.sum()
    return result
