# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The model card of a training in Markdown: data, method and scores."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from aerial_gnss_ros.text.sentences import counted
from aerial_gnss_ros.training.inspection import Inspection
from aerial_gnss_ros.training.run_folder import Plan


@dataclass(frozen=True)
class Split:
    """Content of a split.

    Attributes:
        images: how many.
        robots: of each class, by name.
        empty: images without robots.
        several: images with two or more.
    """

    images: int
    robots: Mapping[str, int]
    empty: int
    several: int


@dataclass(frozen=True)
class Card:
    """Contents of the card.

    Attributes:
        plan: of the training.
        names: of the classes.
        splits: of the data set.
        scores: of `held_out.score_weights`, with the split that they are of.
        versions: of the software.
        epochs: rows of `curves.read_epochs`.
    """

    plan: Plan
    names: Sequence[str]
    splits: Mapping[str, Split]
    scores: Mapping[str, Any]
    versions: Mapping[str, str]
    epochs: Sequence[Mapping[str, str]]


def count_split(found: Inspection, split: str) -> Split:
    """Return the content of a split."""
    examples = found.examples[split]
    classes = np.concatenate([np.zeros(0, np.int64), *(example.classes for example in examples)])
    numbers = np.bincount(classes, minlength=len(found.dataset.names))
    robots = dict(zip(found.dataset.names, map(int, numbers), strict=True))
    held = [len(example.boxes) for example in examples]
    return Split(len(examples), robots, held.count(0), sum(count > 1 for count in held))


def as_markdown(card: Card) -> str:
    """Return the card."""
    return "\n".join(
        [
            "# Model card: best.pt",
            "",
            f"A detector of {', '.join(card.names)}, made by `aerial-gnss train`.",
            "",
            *_scores(card),
            *_data(card),
            *_training(card),
            "## Licence",
            "",
            "Weights trained with ultralytics: it claims AGPL-3.0 for them.",
            "",
        ]
    )


def _scores(card: Card) -> list[str]:
    scores, split = card.scores, card.scores["split"]
    chosen_by_them = split != "test" and not card.plan.phases[-1].hours
    warning = (
        "These images were not used for training."
        if not chosen_by_them
        else "These images were not used for training, but they selected the best epoch, so "
        "the scores are a little too good; a split named test would give unbiased ones."
    )
    overall, threshold = scores["overall"], scores["score_threshold"]
    images, robots = counted(scores["images"], "image"), counted(overall["robots"], "robot")
    lines = [
        "## Scores",
        "",
        f"{images} of the split {split}, {robots}. {warning}",
        "",
        "| figure | value |",
        "|---|---|",
        f"| mAP50-95 | {figure(scores['map50_95'])} |",
        f"| mAP50 | {figure(scores['map50'])} |",
        f"| precision at IoU 0.5, score {threshold:g} | {figure(scores['precision'])} |",
        f"| recall, the same | {figure(scores['recall'])} |",
        f"| best F1 score, on these images | {figure(scores['best_f1'])} |",
        f"| at score_threshold | {figure(scores['best_score_threshold'], 2)} |",
        f"| box centre, error median | {figure(scores['centre_error_median_px'], 2, ' px')} |",
        f"| box centre, error p95 | {figure(scores['centre_error_p95_px'], 2, ' px')} |",
        "",
        "| long side, px | robots | found | false boxes |",
        "|---|---|---|---|",
    ]
    for name, tally in scores["by_long_side_px"].items():
        lines.append(f"| {name} | {tally['robots']} | {tally['found']} | {tally['false']} |")
    return [*lines, "", "![course](curves.png)", ""]


def _data(card: Card) -> list[str]:
    file = card.plan.dataset
    lines = [
        "## Data",
        "",
        f"`{file.parent.name}/{file.name}`, fingerprint `{card.plan.fingerprint}`",
        "(SHA-256 over classes, and names and contents of all images and labels).",
        "",
        "| split | images | without robots | with several | robots |",
        "|---|---|---|---|---|",
    ]
    for name, split in card.splits.items():
        robots = ", ".join(f"{count} {kind}" for kind, count in split.robots.items())
        lines.append(f"| {name} | {split.images} | {split.empty} | {split.several} | {robots} |")
    return [*lines, ""]


def _training(card: Card) -> list[str]:
    plan = card.plan
    lines = ["## Training", "", f"Started from {_origin(plan.weights)}.", ""]
    for number, phase in enumerate(plan.phases, start=1):
        done = sum(row["phase"] == str(number) for row in card.epochs)
        amount, kept = f"{done} of {counted(phase.epochs, 'epoch')}", ""
        if phase.hours:
            amount = f"{phase.hours:g} hours, {counted(done, 'epoch')} (the last one incomplete),"
            kept = "; the last weights are kept"
        lines.append(f"{number}. {amount} on images with {phase.words}{kept}")
    lines += ["", "| parameter | value |", "|---|---|"]
    for name in (
        "image_size", "batch", "learning_rate", "seed", "online", "freeze", "device", "threads",
        "bfloat16",
    ):  # fmt: skip
        value = getattr(plan, name)
        lines.append(f"| {name} | {'automatic' if value in ('', None) else value} |")
    numbered = ", ".join(f"{name} {number}" for name, number in card.versions.items())
    return [*lines, "", f"Versions: {numbered}.", ""]


def _origin(weights: str) -> str:
    path = Path(weights)
    if path.suffix in (".yaml", ".yml"):
        return f"random weights ({path.name}, from scratch)"
    if not path.is_file():
        return path.name
    return f"{path.name}, SHA-256 {hashlib.sha256(path.read_bytes()).hexdigest()}"


def figure(value: float | None, digits: int = 3, unit: str = "") -> str:
    """Return a figure as text; without robots or boxes there is none."""
    return "none" if value is None or math.isnan(value) else f"{value:.{digits}f}{unit}"
