# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Results of a training: weights, learning curves, scores, model card."""

from __future__ import annotations

import json
import math
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from platform import python_version
from typing import Any

from aerial_gnss_ros import __version__
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.training.curves import as_csv, draw_curves, read_epochs, without_scores
from aerial_gnss_ros.training.held_out import held_out_images, held_out_split, score_weights
from aerial_gnss_ros.training.inspection import Inspection
from aerial_gnss_ros.training.model_card import Card, as_markdown, count_split
from aerial_gnss_ros.training.run_folder import Plan, RunFolder, write_whole

_LIBRARIES = (
    "ultralytics",
    "torch",
    "numpy",
    "opencv-python-headless",
    "opencv-python",
    "albumentations",
)


def write_results(run: RunFolder, plan: Plan, found: Inspection) -> None:
    """Score the last phase's weights and write everything into the run's folder.

    The weights are written last: if they exist, the rest does.
    """
    rows = read_epochs([run.phase(n) / "results.csv" for n in range(len(plan.phases))])
    if plan.phases[-1].hours:
        rows = [*map(without_scores, rows[:-1]), *rows[-1:]]
    write_whole(run.path / "metrics.csv", as_csv(rows).encode())
    draw_curves(rows, run.path / "curves.png")
    weights = run.phase_weights(len(plan.phases) - 1)
    split = held_out_split(found)
    config = DetectorConfig(image_size=plan.image_size, device=plan.device)
    scores = {"split": split, **score_weights(weights, held_out_images(found, split), config)}
    write_whole(
        run.path / "scores.json", (json.dumps(_without_nan(scores), indent=2) + "\n").encode()
    )
    counts = {name: count_split(found, name) for name in found.examples}
    card = Card(plan, found.dataset.names, counts, scores, versions(), rows)
    write_whole(run.path / "model_card.md", as_markdown(card).encode())
    write_whole(run.weights, weights.read_bytes())


def _without_nan(value: Any) -> Any:
    """Return the figures with null for NaN, which JSON lacks."""
    if isinstance(value, dict):
        return {name: _without_nan(item) for name, item in value.items()}
    if isinstance(value, list):
        return [_without_nan(item) for item in value]
    return None if isinstance(value, float) and math.isnan(value) else value


def versions() -> dict[str, str]:
    """Return the versions of the software."""
    installed = {name: _version(name) for name in _LIBRARIES}
    known = {name: number for name, number in installed.items() if number}
    return {"aerial_gnss_ros": __version__, "Python": python_version(), **known}


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def written(run: Path) -> list[Path]:
    """Return the files of `write_results` that are meant for people."""
    names = ("best.pt", "model_card.md", "metrics.csv", "scores.json", "curves.png")
    return [run / name for name in names]
