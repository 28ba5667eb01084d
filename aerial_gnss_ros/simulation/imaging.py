# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Renders and encodes the images of a flight in a few processes, in order, in bounded memory."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context

import cv2

from aerial_gnss_ros.core.camera.model import CameraModel
from aerial_gnss_ros.core.values.errors import OutputError
from aerial_gnss_ros.simulation.hexapod import RobotState
from aerial_gnss_ros.simulation.labels import RobotLabel
from aerial_gnss_ros.simulation.mesh import Mesh
from aerial_gnss_ros.simulation.renderer import Renderer
from aerial_gnss_ros.simulation.scene import Scene
from aerial_gnss_ros.simulation.view import ViewPose
from aerial_gnss_ros.simulation.water_photograph import WaterPhotograph, WaterRenderer
from aerial_gnss_ros.simulation.workers import begin, killed_process_named

WORKERS = max(2, min(8, os.cpu_count() or 2))
"""Rendering processes."""
AHEAD = 4
"""Images in progress or waiting beyond one per process; this bounds the memory."""
_KILLED = (
    "a rendering process was killed, probably because memory ran out; choose a smaller --size."
)


@dataclass(frozen=True)
class Picture:
    """What to render.

    Attributes:
        pose: of the camera.
        t: s, moves the waves.
        robots: at that time.
        props: other things afloat.
    """

    pose: ViewPose
    t: float
    robots: list[RobotState]
    props: tuple[Mesh, ...] = ()


@dataclass(frozen=True)
class Rendered:
    """An image as bytes (JPEG, or rows of blue, green, red) and the truth about its robots."""

    data: bytes
    labels: list[RobotLabel]


class Studio:
    """Renderer and encoder of one process."""

    def __init__(
        self,
        scene: Scene,
        camera: CameraModel,
        jpeg_quality: int | None,
        water: WaterPhotograph | None = None,
    ) -> None:
        """Set up.

        Args:
            scene: appearance of the scene.
            camera: lens and image size.
            jpeg_quality: 1 to 100; None for raw pixels.
            water: a photograph in place of rendered water.
        """
        self._renderer = Renderer(scene) if water is None else WaterRenderer(scene, water)
        self._camera = camera
        self._quality = jpeg_quality

    def render(self, picture: Picture) -> Rendered:
        """Render one image."""
        image, labels = self._renderer.render(
            self._camera, picture.pose, picture.t, picture.robots, picture.props
        )
        if self._quality is None:
            return Rendered(image.tobytes(), labels)
        done, data = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, self._quality])
        if not done:
            raise OutputError(f"an image of {image.shape} could not be encoded as JPEG.")
        return Rendered(data.tobytes(), labels)


def render_all(
    pictures: Iterable[Picture],
    scene: Scene,
    camera: CameraModel,
    jpeg_quality: int | None = 92,
    workers: int = WORKERS,
    water: WaterPhotograph | None = None,
) -> Iterator[Rendered]:
    """Yield the rendered pictures in their order; the bytes do not depend on the processes.

    Args:
        pictures: what to render, consumed as needed.
        scene: appearance of the scene.
        camera: lens and image size.
        jpeg_quality: 1 to 100; None for raw pixels.
        workers: processes; 0 renders in this one.
        water: a photograph in place of rendered water.

    Raises:
        OutputError: a process died, probably out of memory.
    """
    if workers == 0:
        studio = Studio(scene, camera, jpeg_quality, water)
        yield from map(studio.render, pictures)
        return
    # Not forked: OpenCV's threads do not survive a fork.
    pool = ProcessPoolExecutor(
        workers, get_context("spawn"), _open_studio, (scene, camera, jpeg_quality, water)
    )
    waiting: deque[Future[Rendered]] = deque()
    try:
        with killed_process_named(pool, _KILLED):
            for picture in pictures:
                waiting.append(pool.submit(_render, picture))
                if len(waiting) >= workers + AHEAD:
                    yield waiting.popleft().result()
            while waiting:
                yield waiting.popleft().result()
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


_studio: Studio | None = None  # of a worker process; nowhere else


def _open_studio(
    scene: Scene, camera: CameraModel, jpeg_quality: int | None, water: WaterPhotograph | None
) -> None:
    global _studio  # noqa: PLW0603  (a pool's initializer has no other place to put it)
    begin()
    _studio = Studio(scene, camera, jpeg_quality, water)


def _render(picture: Picture) -> Rendered:
    if _studio is None:
        raise RuntimeError("the worker was not set up.")
    return _studio.render(picture)
