# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Rescores uncertain boxes with a second network, from an enlarged crop with more context.

A network that searches the whole image has little context at each position: a bow, a box or a patch
of foam looks like a robot. This one examines few positions, and so can afford to see each well: at
equal size, and with the boat to which the bow belongs.
"""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.base import Detections, Detector, Image, Wrapper
from aerial_gnss_ros.detection.onnx_backend import open_session
from aerial_gnss_ros.detection.onnx_model import check_file
from aerial_gnss_ros.detection.second_look_terms import (
    INPUTS,
    OUTPUT,
    Terms,
    log_odds,
    score_of,
    traits,
)
from aerial_gnss_ros.detection.views import turned, views


class SecondLook:
    """A network that rescores doubtful boxes.

    Args:
        path: the .onnx file.
        threads: of the processor; 0: one for each core.

    Attributes:
        terms: selection and size of its views.

    Raises:
        ModelError: missing, or not such a network.
    """

    def __init__(self, path: Path, threads: int = 0) -> None:
        check_file(path, "the second look")
        self._session = open_session(path, threads)
        self.terms = Terms.read(self._session.get_modelmeta().custom_metadata_map, str(path))
        self.name = path.name
        side = self.terms.side
        self.run(np.zeros((1, side, side, 6), np.uint8), np.zeros((1, 3), np.float32))

    def scores(
        self, image: Image, xywh: NDArray[np.float64], scores: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return scores (n,), with doubtful boxes rescored.

        Args:
            image: (height, width, 3) blue, green, red, all of it.
            xywh: (n, 4) centre and size, px.
            scores: (n,) 0 to 1, the best first.

        Raises:
            ModelError: the runtime failed, for example out of memory; the next image may succeed.
        """
        chosen = self.terms.doubtful(scores)
        judged = scores.copy()
        if len(chosen):
            shown = views(image, xywh[chosen], self.terms)
            judged[chosen] = self.judged(shown, traits(xywh[chosen], scores[chosen]))
        return judged

    def judged(self, shown: NDArray[np.uint8], traits: NDArray[np.float32]) -> NDArray[np.float64]:
        """Return the scores (n,) of views and traits, looked at in all ways where it matters.

        A robot is one whichever way the image is turned; what the network has never seen is often
        taken for one in some ways only.

        Raises:
            ModelError: as for `run`.
        """
        scores = self.run(shown, traits)
        if self.terms.ways == 1 or scores.ndim > 1:
            return scores
        unsure = (scores >= self.terms.again_from) & (scores <= self.terms.again_to)
        again = np.flatnonzero(unsure)
        if len(again):
            ways = [turned(shown[again], traits[again], k) for k in range(1, self.terms.ways)]
            further = self.run(*(np.concatenate(part) for part in zip(*ways, strict=True)))
            odds = log_odds(np.concatenate([scores[again], further])).reshape(self.terms.ways, -1)
            scores[again] = score_of(odds.mean(axis=0))
        return scores

    def run(self, shown: NDArray[np.uint8], traits: NDArray[np.float32]) -> NDArray[np.float64]:
        """Return the network's scores (n,) of views and traits; (n, k) if it has k classes.

        Raises:
            ModelError: the runtime failed, or the file has another number of classes than it says.
        """
        try:
            (found,) = self._session.run([OUTPUT], dict(zip(INPUTS, (shown, traits), strict=True)))
        except Exception as error:  # ONNX Runtime has no common error
            raise ModelError(f"the second look failed: {error}") from error
        scores = np.asarray(found, dtype=np.float64)
        classes = self.terms.class_names
        if scores.shape != ((len(shown), len(classes)) if classes else (len(shown),)):
            raise ModelError(
                f"{self.name} gives scores of the shape {scores.shape} for {len(shown)} boxes and "
                f"{len(classes)} classes; train it again."
            )
        return scores


def words(detector: Detector, second: SecondLook | None) -> str:
    """Return a detector's name, with the second look if there is one."""
    return f"{detector.name}, second look {second.name}" if second else detector.name


class LookingTwice(Wrapper):
    """A Detector that rescores the boxes of another one.

    Args:
        inner: detects boxes, from `SecondLook.terms.from_score` on.
        second: rescores them.
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
