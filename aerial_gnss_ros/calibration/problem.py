# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sets up a fit at assumed delays: images, boxes, their association, and the unknowns."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.calibration.evidence import Evidence, State
from aerial_gnss_ros.calibration.geometry import Boxes, on_water
from aerial_gnss_ros.calibration.layout import Layout
from aerial_gnss_ros.calibration.measurement_model import MeasurementModel
from aerial_gnss_ros.calibration.motion import Motion
from aerial_gnss_ros.calibration.prior import Prior
from aerial_gnss_ros.calibration.recording import Recording
from aerial_gnss_ros.calibration.tracks import link
from aerial_gnss_ros.calibration.unknowns import BOX, FIX_DELAY, LATENCY, POINTING
from aerial_gnss_ros.core.camera.model import CameraModel

Array = NDArray[np.float64]
Index = NDArray[np.intp]

LIMIT_S = 3.0
"""Latencies are searched from minus to plus this, s."""
MARGIN_S = 0.5
FIRST_SPEED = 0.2
FIRST_PIXELS = 4.0


@dataclass(frozen=True)
class Linked:
    """Boxes associated with robots.

    Attributes:
        evidence: their likelihood.
        state: initial state.
        clutter: negative log likelihood of the boxes without a robot, uniform over the image.
        share: of the boxes whose images have telemetry at these delays.
    """

    evidence: Evidence
    state: State
    clutter: float
    share: float


class Problem:
    """The images of a recording, set up for a fit.

    Args:
        recording: after the replay.
        motion: its poses.
        most_images: greatest number of images, evenly sampled.
        within_ns: first and last stamp of images to use; None: all.
        throughout: use only images with telemetry at every latency.

    Attributes:
        stamps_ns: of the images used.
        boxes: of these images.
    """

    def __init__(
        self,
        recording: Recording,
        motion: Motion,
        most_images: int,
        within_ns: tuple[int, int] | None = None,
        throughout: bool = False,
    ) -> None:
        self._noise, self._motion = recording.config.noise, motion
        self._max_speed = recording.config.tracks.max_speed
        stamps = _usable(recording, motion, throughout)
        if within_ns is not None:
            stamps = [stamp for stamp in stamps if within_ns[0] <= stamp <= within_ns[1]]
        self.stamps_ns, self.boxes, self._names = _boxes(recording, stamps, most_images)
        gaps = np.diff(self.stamps_ns) * 1e-9
        self._step_s = float(np.median(gaps)) if len(gaps) else 1.0
        sizes = [camera.width * camera.height for camera, _ in self.boxes.cameras]
        self._clutter = math.log(max(sizes, default=1))

    def evidence(
        self, latency_s: float, fix_delay_s: float, speed_mps: float = FIRST_SPEED
    ) -> Linked | None:
        """Return the association at assumed delays; None if no robot is seen often enough.

        Args:
            latency_s: of the images.
            fix_delay_s: of fixes and heights against orientations.
            speed_mps: initial speed of robots.
        """
        poses = self._motion.at(self.stamps_ns, latency_s, fix_delay_s)
        for side in (-MARGIN_S, MARGIN_S):  # latencies that a fit may reach
            poses.known[:] &= self._motion.at(self.stamps_ns, latency_s + side, fix_delay_s).known
        places, ranges = on_water(self.boxes, poses)
        t: Array = np.asarray((self.stamps_ns - self._motion.start_ns) * 1e-9, dtype=np.float64)
        tracks = link(t, self.boxes.images, places, ranges, self.boxes.kinds, self._max_speed)
        rows = np.flatnonzero(tracks >= 0)
        if not len(rows):
            return None
        model = self._model(rows, tracks[rows], places[rows], ranges[rows], latency_s)
        range_m = float(np.median(ranges[rows]))
        unknowns = self._first(model, places[rows], range_m)
        unknowns[LATENCY], unknowns[FIX_DELAY] = latency_s, fix_delay_s
        sigmas = np.full(model.layout.processes, speed_mps)
        sigmas[POINTING], sigmas[BOX] = self._pointing(range_m), 0.5
        evidence = Evidence(model, Prior(model.layout, self._noise))
        state = evidence.start(unknowns, FIRST_PIXELS, sigmas)
        known = int(np.sum(poses.known[self.boxes.images]))
        share = known / len(self.boxes.images)
        return Linked(evidence, state, self._clutter * (known - len(rows)), share)

    def _model(
        self, rows: Index, tracks: Index, places: Array, ranges: Array, latency_s: float
    ) -> MeasurementModel:
        """Return the model of the boxes in some rows, with their tracks, places and ranges."""
        used = self.boxes.only(rows)
        stamps = self.stamps_ns[used.images]
        coarse = self._motion.interpolation(stamps, latency_s, np.maximum(ranges, 1.0))
        white = self._pointing(float(np.median(ranges)))
        sizes = np.sqrt(1.0 + np.square(coarse / white))
        t: Array = np.asarray((stamps - self._motion.start_ns) * 1e-9, dtype=np.float64)
        layout = Layout(t, tracks, self._step_s, self._motion.smoothing_s, sizes)
        robots = range(int(tracks.max()) + 1)
        centres = np.array([np.median(places[tracks == r], axis=0) for r in robots])
        kinds = [used.kinds[np.argmax(tracks == r)] for r in robots]
        names = tuple(f"{self._names[kind]} {r + 1}" for r, kind in enumerate(kinds))
        return MeasurementModel(self._motion, self.stamps_ns, used, tracks, layout, centres, names)

    def _pointing(self, range_m: float) -> float:
        """Return one sigma of white pointing errors by the noise set, rad."""
        turned = math.radians(self._noise.value("gimbal_white_deg"))
        return max(math.hypot(turned, self._noise.value("gnss_white_m") / max(range_m, 1.0)), 1e-5)

    def _first(self, model: MeasurementModel, places: Array, range_m: float) -> Array:
        """Return initial unknowns: no errors, robots where their boxes lie on the water."""
        layout = model.layout
        unknowns = np.zeros(layout.size)
        off = places - model.places(unknowns)
        for first, path in zip(layout.first_path, layout.paths, strict=True):
            table = np.zeros((len(path.rows), path.count))
            np.put_along_axis(table, path.columns, path.weights, axis=1)
            noise = 0.01 * range_m
            normal = table.T @ table / noise**2 + path.rough / FIRST_SPEED**2
            normal += 1e-4 * np.outer(path.middle, path.middle)
            solved = np.linalg.solve(normal, table.T @ off[path.rows] / noise**2)
            unknowns[first : first + 2 * path.count] = solved.T.ravel()
        return unknowns


def _usable(recording: Recording, motion: Motion, throughout: bool) -> list[int]:
    """Return the stamps of images with boxes, a camera, and telemetry at any or every latency."""
    stamps = sorted(stamp for stamp, frame in recording.frames.items() if len(frame))
    stamps = [stamp for stamp in stamps if recording.camera(stamp) is not None]
    table = np.array(stamps, dtype=np.int64)
    ends = LIMIT_S + (MARGIN_S if throughout else 0.0)
    known = [motion.at(table, late, 0.0).known for late in np.arange(-ends, ends + 0.01, 0.5)]
    good = np.all(known, axis=0) if throughout else np.any(known, axis=0)
    return [stamp for stamp, one in zip(stamps, good, strict=True) if one]


def _boxes(
    recording: Recording, stamps: list[int], most: int
) -> tuple[NDArray[np.int64], Boxes, list[str]]:
    """Return the stamps of the images used, their boxes, and the names of classes."""
    if len(stamps) > most:
        picked = np.unique(np.linspace(0, len(stamps) - 1, most, dtype=int))
        stamps = [stamps[i] for i in picked]
    frames = [recording.frames[stamp] for stamp in stamps]
    names = sorted({name for frame in frames for name in frame.class_ids})
    counts = [len(frame) for frame in frames]
    images = np.repeat(np.arange(len(frames)), counts)
    models: dict[int, CameraModel] = {}
    which = []
    for stamp in stamps:
        camera = recording.camera(stamp)
        assert camera is not None  # noqa: S101 - chosen so
        models[id(camera)] = camera
        which.append(id(camera))
    pixels = np.concatenate([frame.centers for frame in frames]) if frames else np.zeros((0, 2))
    rays = np.full((len(pixels), 3), np.nan)
    cameras = []
    for key, camera in models.items():
        rows = np.flatnonzero(np.repeat(which, counts) == key)
        found, good = camera.rays(pixels[rows])
        rays[rows[good]] = found[good] / np.linalg.norm(found[good], axis=1, keepdims=True)
        cameras.append((camera, rows))
    kinds = [names.index(name) for frame in frames for name in frame.class_ids]
    depths = [recording.depths(frame) for frame in frames]
    boxes = Boxes(
        images, pixels, rays, np.concatenate(depths) if depths else np.zeros(0),
        np.array(kinds, dtype=np.intp), tuple(cameras),
    )  # fmt: skip
    return np.array(stamps, dtype=np.int64), boxes, names
