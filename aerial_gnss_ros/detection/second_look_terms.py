# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Which boxes a second look examines, at which size, and with which further inputs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.text.json_text import parse_json

METADATA = "second_look"
INPUTS, OUTPUT = ("views", "traits"), "scores"
ODDS_UNIT = 3.0  # scale of log odds, as given to the network


@dataclass(frozen=True)
class Terms:
    """Selection and views of the second look, stored in the network's file.

    Attributes:
        side: of a view, px.
        near: side of the near view in the image, long sides of the box.
        wide: of the wide view.
        least: shortest side of the near view in the image, px.
        from_score: boxes below are not rescored, and so not reported.
        to_score: boxes above keep their score.
        most: greatest number of boxes of an image; each costs some milliseconds.
        class_names: of a network that gives a score for each class; empty: one score, and the
            detector's class.
        ways: in how many ways, turned and mirrored, a box is looked at; the log odds are averaged.
        again_from: score at the first look from which the other ways follow.
        again_to: and up to which; the network is sure of what has more.
        parts: whether the boxes around and across anomalies are examined, too (`taught.py`).
    """

    side: int = 64
    near: float = 2.0
    wide: float = 6.0
    least: float = 30.0
    from_score: float = 0.03
    to_score: float = 0.8
    most: int = 32
    class_names: tuple[str, ...] = ()
    parts: bool = False
    ways: int = 1
    again_from: float = 0.1
    again_to: float = 0.8

    @classmethod
    def read(cls, metadata: Mapping[str, str], where: str) -> Terms:
        """Return the terms in an ONNX model's metadata.

        Raises:
            ModelError: there are none; the model has another purpose.
        """
        try:
            stored = cls(**parse_json(metadata[METADATA]))
            stored.check()
            stored = replace(
                stored, side=int(stored.side), ways=int(stored.ways),
                class_names=tuple(map(str, stored.class_names)),
            )  # fmt: skip
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise ModelError(
                f"{where} is not a network for the second look; give one that "
                "aerial_gnss_ros.training.second_look made, or set second_look to off."
            ) from error

        return stored

    def check(self) -> None:
        """Raise ValueError for an implausible value."""
        if not (
            8 <= self.side <= 1024
            and float(self.side).is_integer()
            and 0.0 < self.near <= self.wide <= 100.0
            and 0.0 <= self.least <= 10_000.0
            and 0.0 <= self.from_score <= self.to_score <= 1.0
            and 1 <= self.most <= 10_000
            and self.parts in (True, False)
            and 1 <= self.ways <= 8
            and float(self.ways).is_integer()
            and 0.0 <= self.again_from <= self.again_to <= 1.0
            and isinstance(self.class_names, tuple | list)
        ):
            raise ValueError(self.text[:200])

    @property
    def text(self) -> str:
        """The text that `read` parses."""
        return json.dumps(asdict(self))

    def doubtful(self, scores: NDArray[np.float64]) -> NDArray[np.int64]:
        """Return the indices of the boxes to rescore, from scores with the best first."""
        within = (scores >= self.from_score) & (scores < self.to_score)
        return np.flatnonzero(within)[: self.most]


def log_odds(scores: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Return log(p / (1 - p)), of 0.0001 to 0.9999."""
    within = np.clip(np.asarray(scores, dtype=np.float64), 1e-4, 1.0 - 1e-4)
    odds: NDArray[np.float64] = np.log(within / (1.0 - within))
    return odds


def score_of(odds: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Return the score of log odds."""
    return np.asarray(1.0 / (1.0 + np.exp(-np.asarray(odds, dtype=np.float64))))


def traits(xywh: NDArray[np.float64], scores: NDArray[np.float64]) -> NDArray[np.float32]:
    """Return (n, 3) inputs besides the views: log odds, log size and log aspect of each box."""
    size = np.maximum(xywh[:, 2:], 1e-3)
    columns = [
        log_odds(scores) / ODDS_UNIT,
        np.log(np.maximum(size.max(axis=1), 1.0) / 40.0),
        np.log(size[:, 0] / size[:, 1]),
    ]
    return np.stack(columns, axis=1).astype(np.float32)
