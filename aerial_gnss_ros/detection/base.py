# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The detector's interface and its result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Image = NDArray[np.uint8]
_FIRST_PIXEL_MIDDLE = (
    0.5  # from coordinates of pixel edges (networks, labels) to pixel centres (camera models)
)


@dataclass(frozen=True)
class Detections:
    """Boxes found in one image, best score first.

    Attributes:
        xywh: (n, 4) centre u, v, width and height, pixels of the source image. As in OpenCV and
            CameraInfo the centre of the first pixel is (0, 0): the image reaches from -0.5 to its
            width - 0.5, and boxes are within.
        scores: (n,) 0 to 1.
        class_ids: (n,) index into `class_names`.
        class_names: the model's classes.
        timings_ms: milliseconds per stage: `pre`, `infer`, `post`.
    """

    xywh: NDArray[np.float64]
    scores: NDArray[np.float64]
    class_ids: NDArray[np.int64]
    class_names: tuple[str, ...]
    timings_ms: dict[str, float] = field(default_factory=dict, compare=False)

    def __post_init__(self) -> None:
        count = len(self.scores)
        _check_shape("xywh", self.xywh, (count, 4))
        _check_shape("scores", self.scores, (count,))
        _check_shape("class_ids", self.class_ids, (count,))
        if count == 0:
            return
        if not np.isfinite(self.xywh).all() or (self.xywh[:, 2:] < 0).any():
            raise ValueError("xywh must be finite, with sizes of 0 or more")
        if not ((self.scores >= 0) & (self.scores <= 1)).all():
            raise ValueError(f"scores must lie within 0 to 1, got {self.scores}")
        if self.class_ids.min() < 0 or self.class_ids.max() >= len(self.class_names):
            raise ValueError(
                f"class_ids must lie within 0 to {len(self.class_names) - 1}, got {self.class_ids}"
            )

    def __len__(self) -> int:
        return len(self.scores)

    @property
    def names(self) -> tuple[str, ...]:
        """The class name of each box."""
        return tuple(self.class_names[i] for i in self.class_ids)

    @property
    def xyxy(self) -> NDArray[np.float64]:
        """(n, 4) left, top, right, bottom, pixels of the source image."""
        half = self.xywh[:, 2:] / 2
        return np.hstack([self.xywh[:, :2] - half, self.xywh[:, :2] + half])


def _check_shape(name: str, array: Any, shape: tuple[int, ...]) -> None:
    if np.shape(array) != shape:
        raise ValueError(f"{name} must have shape {shape}, got {np.shape(array)}")


def within_image(
    xyxy: NDArray[Any],
    scores: NDArray[Any],
    class_ids: NDArray[Any],
    class_names: tuple[str, ...],
    size: tuple[int, int],
    timings_ms: dict[str, float] | None = None,
) -> Detections:
    """Return detections from corners: clipped to the image, without those left empty.

    Args:
        xyxy: (n, 4) left, top, right, bottom, source pixels; here, as in networks, the first pixel
            reaches from 0 to 1.
        scores: (n,) 0 to 1.
        class_ids: (n,) whole numbers.
        class_names: the model's classes.
        size: width and height of the source image, px.
        timings_ms: milliseconds per stage.
    """
    corners = np.asarray(xyxy, dtype=np.float64).reshape(-1, 4)
    corners = np.clip(corners, 0.0, np.array([*size, *size], dtype=np.float64))
    extent = corners[:, 2:] - corners[:, :2]
    kept = np.isfinite(corners).all(axis=1) & (extent > 0).all(axis=1)
    xywh = np.hstack([corners[:, :2] + extent / 2 - _FIRST_PIXEL_MIDDLE, extent])[kept]
    return Detections(
        xywh,
        np.clip(np.asarray(scores, dtype=np.float64)[kept], 0.0, 1.0),
        np.asarray(class_ids)[kept].astype(np.int64),
        class_names,
        timings_ms or {},
    )


class Detector(Protocol):
    """Detects robots in an image."""

    @property
    def name(self) -> str:
        """Model, back end and device in words, for the message at start."""

    @property
    def class_names(self) -> tuple[str, ...]:
        """The model's classes."""

    def detect(self, image: Image) -> Detections:
        """Return the boxes found.

        Args:
            image: (height, width, 3) blue, green, red.

        Raises:
            ModelError: this image could not be processed, for example out of memory; the next one
                may succeed.
        """


def detect_all(detector: Detector, images: Sequence[Image]) -> list[Detections]:
    """Return the boxes of each image, processed in parallel if the detector can.

    Raises:
        ModelError: as `Detector.detect`.
    """
    together = getattr(detector, "detect_all", None)
    if together is None:
        return [detector.detect(image) for image in images]
    found: list[Detections] = together(images)
    return found


class Wrapper:
    """Base of Detectors that use another one.

    Args:
        inner: the other one.
    """

    def __init__(self, inner: Detector) -> None:
        self._inner = inner

    @property
    def class_names(self) -> tuple[str, ...]:
        """The model's classes."""
        return self._inner.class_names

    def close(self) -> None:
        """Release the inner detector's resources."""
        close = getattr(self._inner, "close", None)
        if close is not None:
            close()
