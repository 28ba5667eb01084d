# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Draws rendered robots and other things into photographs of water.

A scene is shaded twice where something is: without and with it. What the water does to a body
under it (refraction, colour, wake, shadow, foam at the waterline) is the ratio of both and is
multiplied into the photograph's linear light; what is over water replaces it, at the exposure of
the photograph.
"""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.simulation.composite import contrasts, paint_above
from aerial_gnss_ros.simulation.develop import as_levels, as_light
from aerial_gnss_ros.simulation.hexapod import RobotState
from aerial_gnss_ros.simulation.labels import RobotLabel
from aerial_gnss_ros.simulation.mesh import Mesh
from aerial_gnss_ros.simulation.planes import F32, U8, merge
from aerial_gnss_ros.simulation.renderer import Renderer
from aerial_gnss_ros.simulation.view import ViewPose, Window

LUMA = np.array([0.0722, 0.7152, 0.2126], dtype=np.float32)
_STEP = 16  # px between the rays that match the exposure
_GAINS = (0.3, 2.0)  # level of a white sheet in daylight that a camera's exposure gives
_RATIOS = (0.1, 8.0)
_UNCHANGED = 1.0 / 512.0


class PhotographRenderer(Renderer):
    """Renders the bodies of a scene; the water is a photograph's."""

    def draw_into(
        self,
        photograph: U8,
        camera: CameraModel,
        pose: ViewPose,
        t_s: float,
        robots: Sequence[RobotState],
        props: Sequence[Mesh] = (),
        *,
        window: Window,
        softness_px: float = 0.5,
        brightness: float = 1.0,
    ) -> tuple[U8, list[RobotLabel]]:
        """Return a photograph with robots and other things in it, and the robots' labels.

        Args:
            photograph: (height, width, 3) of the window's size; what is not touched stays as it is.
            camera: assumed for the photograph.
            pose: assumed for it, too.
            t_s: time of the scene, moves the waves that bend the view of what is under water.
            robots: to be drawn.
            props: other things in local ENU, drawn without label.
            window: pixels of the camera that the photograph fills.
            softness_px: of the photograph: standard deviation of a Gaussian for what is drawn.
            brightness: of what is drawn over water, relative to the matched exposure.

        Returns:
            The image, and labels in pixels of the *camera*, as `Renderer.render` gives them.
        """
        self._shader.sea.set_time(t_s)
        angle = self._pixel_angle(camera)
        rays = self._window_rays(camera, window)
        rotation = pose.enu_from_optical.astype(np.float32)
        bodies = self._bodies(camera, pose, robots, props, window)
        coarse = np.ascontiguousarray(rays[::_STEP, ::_STEP])
        sea = self._shader.shade(self._directions(coarse, rotation), pose.position, angle * _STEP)
        gain = matching_gain(photograph, sea, brightness)
        image = photograph.copy()
        contrast: dict[str, float] = {}
        for area in self._areas(camera, pose, robots, bodies, window):
            y, x = area.y - window.y, area.x - window.x
            here = slice(y, y + area.height), slice(x, x + area.width)
            block = self._directions(np.ascontiguousarray(rays[here]), rotation)
            before = self._shader.shade(block, pose.position, angle)
            effects = self._effects(bodies, robots, area, pose, angle)
            after = self._shader.shade(block, pose.position, angle, effects)
            through, added = _ratios(before, after), [np.zeros_like(p) for p in before]
            kept = [np.ones_like(p) for p in before]
            for body in bodies:
                paint_above(added, body.layer, area)
                paint_above(kept, body.layer, area)
            shares = merge([t * (k - a) for t, k, a in zip(through, kept, added, strict=True)])
            image[here] = _composed(photograph[here], shares, merge(added) * gain, softness_px)
            contrast.update(contrasts(bodies, area, photograph[here], image[here]))
        labels = [
            label
            for body in bodies
            if (label := self._label(body, camera, pose, window, contrast)) is not None
        ]
        return image, sorted(labels, key=lambda label: label.robot_id)


def matching_gain(photograph: U8, sea: list[F32], brightness: float = 1.0) -> F32:
    """Return the exposure at which a rendered sea is as bright as a photograph.

    Args:
        photograph: (height, width, 3).
        sea: planes of linear light, anywhere on the sea that it shows.
        brightness: factor on the exposure.
    """
    seen = float(np.median(as_light(photograph[::4, ::4]) @ LUMA))
    rendered = float(np.median(np.stack(sea, axis=-1) @ LUMA))
    gain = brightness * seen / max(rendered, 1e-4)
    return np.asarray(np.clip(gain, *_GAINS), dtype=np.float32)


def _ratios(before: list[F32], after: list[F32]) -> list[F32]:
    """Return what becomes of the water's light, per colour."""
    floor = np.float32(1e-3)
    return [
        np.clip((b + floor) / (a + floor), *_RATIOS) for a, b in zip(before, after, strict=True)
    ]


def _composed(photograph: U8, shares: F32, added: F32, softness_px: float) -> U8:
    """Return a photograph's light times `shares` plus `added`; untouched pixels as they are."""
    if softness_px > 0.15:
        shares = np.asarray(cv2.GaussianBlur(shares, (0, 0), softness_px), np.float32)
        added = np.asarray(cv2.GaussianBlur(added, (0, 0), softness_px), np.float32)
    light = as_light(photograph)
    drawn = as_levels(light * shares + added)
    touched = (np.abs(shares - 1.0) > _UNCHANGED) | (added > _UNCHANGED)
    return np.where(touched.any(axis=-1, keepdims=True), drawn, photograph)
