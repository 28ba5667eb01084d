# SPDX-License-Identifier: Apache-2.0
"""Looks again, larger and with more of what lies around, at boxes that a network is not sure of.

A network that goes over the whole image decides on each place by little more than the place
itself: a bow, a box or a patch of foam looks like a robot there. This one sees few places, so that
it can afford to see each well: in equal size, and with the boat to which the bow belongs.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.errors import ModelError
from aerial_gnss_ros.detection.base import Detections, Detector, Image, Wrapper
from aerial_gnss_ros.detection.onnx_backend import open_session
from aerial_gnss_ros.detection.onnx_model import check_file

METADATA = "second_look"
INPUTS, OUTPUT = ("views", "traits"), "scores"
ODDS_UNIT = 3.0  # of log odds, as the network is told of them
_MOST = 32  # boxes of an image; each costs about half a millisecond


@dataclass(frozen=True)
class Terms:
    """What is looked at again, and how; the file of the network carries it.

    Attributes:
        side: of a view, px.
        near: side of the near view in the image, long sides of the box.
        wide: of the wide view.
        least: shortest side of the near view in the image, px.
        from_score: boxes of less are not looked at again, and so not reported.
        to_score: the network is believed from here on.
    """

    side: int = 64
    near: float = 2.0
    wide: float = 6.0
    least: float = 30.0
    from_score: float = 0.03
    to_score: float = 0.8

    @classmethod
    def read(cls, metadata: Mapping[str, str], where: str) -> Terms:
        """Return the terms in an ONNX model's metadata.

        Raises:
            ModelError: there are none; the model is for something else.
        """
        try:
            return cls(**json.loads(metadata[METADATA]))
        except (KeyError, TypeError, ValueError) as error:
            raise ModelError(
                f"{where} is no network for a second look; give one that "
                "aerial_gnss_ros.training.second_look made, or set second_look to off."
            ) from error

    @property
    def text(self) -> str:
        """What `read` reads."""
        return json.dumps(asdict(self))

    def doubtful(self, scores: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the indices of the boxes to look at again, of scores with the best first."""
        within = (scores >= self.from_score) & (scores < self.to_score)
        return np.flatnonzero(within)[:_MOST]


def log_odds(scores: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Return log(p / (1 - p)), of 0.0001 to 0.9999."""
    within = np.clip(np.asarray(scores, dtype=np.float64), 1e-4, 1.0 - 1e-4)
    odds: NDArray[np.float64] = np.log(within / (1.0 - within))
    return odds


def views(
    image: Image, xywh: NDArray[np.float64], terms: Terms, room: float = 1.0
) -> NDArray[np.uint8]:
    """Return the near and the wide view of boxes: (n, side, side, 6), blue green red of each.

    Args:
        image: (height, width, 3) blue, green, red; beyond its edge its last pixels go on.
        xywh: (n, 4) centre and size, px, the middle of the first pixel being (0, 0).
        terms: sizes.
        room: views so many times as large, in as many times the pixels.
    """
    pixels = round(terms.side * room)
    made = np.empty((len(xywh), pixels, pixels, 6), dtype=np.uint8)
    levels = [image]
    for row, (u, v, width, height) in zip(made, xywh, strict=True):
        near = max(terms.near * max(width, height), terms.least)
        row[..., :3] = _view(levels, u, v, near * room, pixels)
        row[..., 3:] = _view(levels, u, v, near * terms.wide / terms.near * room, pixels)
    return made


def _view(levels: list[Image], u: float, v: float, side: float, pixels: int) -> Image:
    """Return the square of `side` round a place, in `pixels`; shrunk without aliasing.

    Args:
        levels: the image, and as far as they were needed its half, quarter and so on.
        u: of the place in the image, px.
        v: of the place.
        side: px of the image.
        pixels: of the view.
    """
    wanted = max(0, math.floor(math.log2(side / pixels)))
    while len(levels) <= wanted and min(levels[-1].shape[:2]) >= 2:
        height, width = (length // 2 for length in levels[-1].shape[:2])
        even = levels[-1][: 2 * height, : 2 * width]
        levels.append(_drawn(cv2.resize(even, (width, height), interpolation=cv2.INTER_AREA)))
    level = min(wanted, len(levels) - 1)
    factor = 2.0**level
    return _square(levels[level], (u + 0.5) / factor, (v + 0.5) / factor, side / factor, pixels)


def _square(image: Image, x: float, y: float, side: float, pixels: int) -> Image:
    """Return the square round a place, from the corner of the image; shrunk by less than 2."""
    left, top, scale = x - side / 2, y - side / 2, side / pixels
    if scale <= 1.0:
        to_view = np.array([
            [1 / scale, 0.0, -(left - 0.5) / scale - 0.5],
            [0.0, 1 / scale, -(top - 0.5) / scale - 0.5],
        ])  # fmt: skip
        whole = (pixels, pixels)
        edge = cv2.BORDER_REPLICATE
        return _drawn(
            cv2.warpAffine(image, to_view, whole, flags=cv2.INTER_LINEAR, borderMode=edge)
        )
    height, width = image.shape[:2]
    x0, y0 = math.floor(left), math.floor(top)
    x1, y1 = math.ceil(left + side), math.ceil(top + side)
    part = image[max(y0, 0) : min(y1, height), max(x0, 0) : min(x1, width)]
    beyond = (max(-y0, 0), max(y1 - height, 0), max(-x0, 0), max(x1 - width, 0))
    if any(beyond):
        part = _drawn(cv2.copyMakeBorder(part, *beyond, cv2.BORDER_REPLICATE))
    return _drawn(cv2.resize(part, (pixels, pixels), interpolation=cv2.INTER_AREA))


def _drawn(array: Any) -> Image:
    return np.asarray(array, dtype=np.uint8)


def traits(xywh: NDArray[np.float64], scores: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return (n, 3) what the views do not show: log odds, log size and log shape of each box."""
    size = np.maximum(xywh[:, 2:], 1e-3)
    columns = [
        log_odds(scores) / ODDS_UNIT,
        np.log(np.maximum(size.max(axis=1), 1.0) / 40.0),
        np.log(size[:, 0] / size[:, 1]),
    ]
    return np.stack(columns, axis=1).astype(np.float32)


class SecondLook:
    """A network that gives doubtful boxes a new score.

    Args:
        path: the .onnx file.
        threads: of the processor; 0: one for each core.

    Attributes:
        terms: what it looks at.

    Raises:
        ModelError: missing, or not such a network.
    """

    def __init__(self, path: Path, threads: int = 0) -> None:
        check_file(path)
        self._session = open_session(path, threads)
        self.terms = Terms.read(self._session.get_modelmeta().custom_metadata_map, str(path))
        self.name = path.name
        side = self.terms.side
        self._run(np.zeros((1, side, side, 6), np.uint8), np.zeros((1, 3), np.float32))

    def scores(
        self, image: Image, xywh: NDArray[np.float64], scores: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return scores (n,), those of doubtful boxes given anew.

        Args:
            image: (height, width, 3) blue, green, red, all of it.
            xywh: (n, 4) centre and size, px.
            scores: (n,) 0 to 1, the best first.

        Raises:
            ModelError: the runtime failed, such as for want of memory; the next image may do.
        """
        chosen = self.terms.doubtful(scores)
        judged = scores.copy()
        if len(chosen):
            shown = views(image, xywh[chosen], self.terms)
            judged[chosen] = self._run(shown, traits(xywh[chosen], scores[chosen]))
        return judged

    def _run(self, shown: NDArray[np.uint8], told: NDArray[np.float32]) -> NDArray[np.float64]:
        try:
            (found,) = self._session.run([OUTPUT], dict(zip(INPUTS, (shown, told), strict=True)))
        except Exception as error:  # ONNX Runtime has no common error
            raise ModelError(f"the second look failed: {error}") from error
        return np.asarray(found, dtype=np.float64).reshape(len(shown))


def words(detector: Detector, second: SecondLook | None) -> str:
    """Return a detector in words, with the second look where there is one."""
    return f"{detector.name}, second look {second.name}" if second else detector.name


class LookingTwice(Wrapper):
    """A Detector that has the boxes of another one looked at again.

    Args:
        inner: finds boxes, from `SecondLook.terms.from_score` on.
        second: looks at them again.
        score_threshold: boxes below are not reported.
    """

    def __init__(self, inner: Detector, second: SecondLook, score_threshold: float) -> None:
        super().__init__(inner)
        self._second = second
        self._threshold = score_threshold

    @property
    def name(self) -> str:
        """The inner detector's, and the second network."""
        return words(self._inner, self._second)

    def detect(self, image: Image) -> Detections:
        """Return the boxes found in `image` (height, width, 3), blue, green, red."""
        found = self._inner.detect(image)
        started = time.perf_counter()
        scores = self._second.scores(image, found.xywh, found.scores)
        order = np.argsort(-scores, kind="stable")
        order = order[scores[order] >= self._threshold]
        spent = dict(found.timings_ms)
        spent["post"] = spent.get("post", 0.0) + 1e3 * (time.perf_counter() - started)
        return replace(
            found, xywh=found.xywh[order], scores=scores[order], class_ids=found.class_ids[order],
            timings_ms=spent,
        )  # fmt: skip
