# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From the labels of a recording to a detector: variants, training, threshold, score."""

from __future__ import annotations

import hashlib
import importlib.util
import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from dataclasses import asdict, dataclass, replace
from functools import partial as bound
from pathlib import Path

import numpy as np

from aerial_gnss_ros.bags.partial import partial
from aerial_gnss_ros.core.values.errors import InputError, ModelError
from aerial_gnss_ros.detection.anomaly import ANOMALY
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.images import read_image
from aerial_gnss_ros.detection.second_look import SecondLook
from aerial_gnss_ros.detection.second_look_terms import Terms
from aerial_gnss_ros.detection.taught import TERMS, TaughtDetector
from aerial_gnss_ros.resources import install_hint
from aerial_gnss_ros.teaching.advice import least_score
from aerial_gnss_ros.teaching.dataset import FOLDER
from aerial_gnss_ros.teaching.threshold import THRESHOLDS, best_threshold
from aerial_gnss_ros.text.json_text import parse_json
from aerial_gnss_ros.text.sentences import counted
from aerial_gnss_ros.training.cut_paste import Cutout, cut_out
from aerial_gnss_ros.training.labelled import LabelledImage, Truth, read_labels
from aerial_gnss_ros.training.layout import open_dataset
from aerial_gnss_ros.training.photographs import photographs_of
from aerial_gnss_ros.training.score import Score
from aerial_gnss_ros.training.share import Share
from aerial_gnss_ros.training.taught_examples import Examples, Frame, examples_of, varied

NETWORK, ABOUT, STATE = "taught.onnx", "taught.json", ".training.pt"
FEWEST = 10
"""Boxes of a class below which nothing can be learnt of it."""
_METHOD = "from the shipped second look"  # another method's network or state is no use
_CHOOSING = 0.2  # share of the images to learn from, their end, that decides the threshold
_MOST_IMAGES, _MOST_CHOOSING = 120, 40  # neighbouring frames are nearly the same
_VARIANTS, _EACH = 120, 8

Progress = Callable[[str, int, str], AbstractContextManager[Callable[[int], None]]]
"""Reports long work: its name, its amount, the unit."""


@dataclass(frozen=True)
class Plan:
    """A training.

    Attributes:
        water: folder of images of water without any robot, to paste robots on; None: only the
            recording's own.
        seed: same seed and labels, same network.
        threads: of the processor; 0: one for each core.
        start: file of the network whose first layers it starts from, see `start_from`; None: the
            shipped second look.
    """

    water: Path | None = None
    seed: int = 0
    threads: int = 0
    start: Path | None = None


@dataclass(frozen=True)
class Learnt:
    """A taught detector.

    Attributes:
        data: fingerprint of labels, images, plan and method.
        classes: their names.
        threshold: score threshold with the best F0.5 on the last of the images to learn from.
        confirm_score: that nearly all boxes on robots kept aside exceed; 0: not known.
        images: number that was kept aside to score on.
        robots: labelled in them.
        found: of these.
        false: boxes that are on none.
        boxes: number of boxes learnt from.
        training_s: time of examples and training, without what an earlier, killed run did, s.
        image_ms: processor's time for an image, ms.
    """

    data: str
    classes: tuple[str, ...]
    threshold: float
    confirm_score: float
    images: int
    robots: int
    found: int
    false: int
    boxes: int
    training_s: float
    image_ms: float

    @property
    def precision(self) -> float:
        """Share of the boxes that are robots."""
        return self.found / max(1, self.found + self.false)

    @property
    def recall(self) -> float:
        """Share of the robots that are found."""
        return self.found / max(1, self.robots)


def learn(project: Path, plan: Plan, progress: Progress) -> Learnt:
    """Train a detector on the data set of a project; write network and scores into it.

    What is trained already is not trained again; a killed training goes on.

    Args:
        project: folder with the data set.
        plan: how.
        progress: reports long work.

    Raises:
        InputError: too few boxes of a class, robots that do not stand out from the water, or no
            images in the folder of water.
        ModelError: torch or onnx is missing.
        OutputError: a result cannot be written.
    """
    for library in ("torch", "onnx"):
        if importlib.util.find_spec(library) is None:
            raise ModelError(
                f"training needs {library}; install it with {install_hint('training')}, and start "
                "the same command again."
            )
    dataset = project / FOLDER
    names = open_dataset(dataset).names
    images = list(read_labels(dataset, "train"))
    first = len(images) - max(1, round(_CHOOSING * len(images)))
    learning, choosing = images[:first], images[first:]
    _check(learning, names)
    data = _fingerprint(dataset, plan)
    known = _known(project, data)
    if known is not None:
        return known
    state = project / STATE
    if not _is_of(state, data):
        state.unlink(missing_ok=True)
        _sign(state).write_text(data, encoding="ascii")
    began = time.perf_counter()
    terms = replace(TERMS, class_names=names)
    waters = _waters(plan.water)
    rng = np.random.default_rng(plan.seed)
    examples = _examples(rng, _some(learning, _MOST_IMAGES), waters, terms, progress)
    _check_seen(examples, names, project)
    _train(project, examples, terms, plan, progress)
    trained = time.perf_counter() - began
    second = SecondLook(project / NETWORK, plan.threads)
    detector = _detector(second, THRESHOLDS[0])
    threshold = best_threshold(detector, _some(choosing, _MOST_CHOOSING), plan.seed)
    kept = list(read_labels(dataset, "val")) if any((dataset / "images/val").glob("*")) else []
    scored, scores, image_ms = _scored(second, threshold, kept)
    overall = scored.overall
    learnt = Learnt(
        data, names, threshold, least_score(scores, threshold), len(kept), overall.robots,
        overall.found, overall.false, len(examples.proposals), round(trained, 1),
        round(image_ms, 1),
    )  # fmt: skip
    (project / ABOUT).write_text(json.dumps(asdict(learnt), indent=2), encoding="utf-8")
    state.unlink(missing_ok=True)
    _sign(state).unlink(missing_ok=True)
    return learnt


def _check(images: Sequence[LabelledImage], names: Sequence[str]) -> None:
    found = np.zeros(len(names), np.int64)
    for image in images:
        np.add.at(found, image.truth.class_ids, 1)
    poor = [
        f"{name} has {counted(int(count), 'box')}"
        for name, count in zip(names, found, strict=True)
        if count < FEWEST
    ]
    if poor:
        raise InputError(
            f"too few labels to train on: {', '.join(poor)} in the part that is learnt from; mark "
            f"it in more frames, until there are {FEWEST} at the least."
        )


def _check_seen(examples: Examples, names: Sequence[str], project: Path) -> None:
    robots = examples.wanted[examples.proposals.is_robot] > 0.0
    for name, count in zip(names, robots.sum(axis=0), strict=True):
        if count < FEWEST:
            raise InputError(
                f"only {counted(int(count), 'box')} of {name} found: its colours are too much like "
                f"the water's for this detector; train a larger network on {project / FOLDER} "
                "(aerial-gnss train)."
            )


def _train(project: Path, examples: Examples, terms: Terms, plan: Plan, progress: Progress) -> None:
    """Train and write the network."""
    from aerial_gnss_ros.training.second_look_network import write
    from aerial_gnss_ros.training.second_look_network_taught import STEPS, fit_taught

    with progress("training", STEPS, "steps") as report:
        network = fit_taught(
            examples, terms, STEPS, plan.seed, project / STATE, report, plan.threads, plan.start
        )
    with partial(project / NETWORK) as file:
        write(network, terms, Share(), file)


def _examples(
    rng: np.random.Generator,
    images: Sequence[LabelledImage],
    waters: Sequence[LabelledImage],
    terms: Terms,
    progress: Progress,
) -> Examples:
    """Return what is learnt from images, and from their robots pasted onto water."""
    robots: list[Cutout] = []
    seen = [*images, *waters]
    with progress("examples", len(seen) + _VARIANTS, "images") as report:

        def read() -> Iterator[Frame]:
            for number, one in enumerate(seen, 1):
                image = one.read()
                robots.extend(cut_out(image, one.truth))
                yield image, one.truth
                report(number)

        def variants() -> Iterator[Frame]:
            for number, frame in enumerate(varied(rng, seen, robots, _VARIANTS, _EACH), 1):
                yield frame
                report(len(seen) + number)

        return examples_of(read(), variants(), terms, len(terms.class_names))


def _waters(folder: Path | None) -> list[LabelledImage]:
    if folder is None:
        return []
    none = np.zeros(0)
    empty = Truth(np.zeros((0, 4)), np.zeros(0, np.bool_), none, none, np.zeros(0, np.int64))
    found = [
        LabelledImage(path.name, empty, bound(read_image, path))
        for path, _ in photographs_of(folder, None)
    ]
    return _some(found, _MOST_IMAGES)


def _some(images: Sequence[LabelledImage], most: int) -> list[LabelledImage]:
    """Return at most so many images, at equal distances."""
    chosen = np.unique(np.linspace(0, len(images) - 1, min(most, len(images))).round().astype(int))
    return [images[i] for i in chosen]


def _detector(second: SecondLook, threshold: float) -> TaughtDetector:
    config = DetectorConfig(model=ANOMALY, second_look=str(second.name), score_threshold=threshold)
    return TaughtDetector(config, second)


def _scored(
    second: SecondLook, threshold: float, images: Sequence[LabelledImage]
) -> tuple[Score, list[float], float]:
    """Return the score on images, the scores of boxes on robots, and the time an image took, ms."""
    began, detector = time.process_time(), _detector(second, threshold)
    result, scores = Score(), list[float]()
    for image in images:
        found = detector.detect(image.read())
        matched = result.add(found, image.truth)
        scores.extend(found.scores[matched.robot >= 0].tolist())
    return result, scores, 1e3 * (time.process_time() - began) / max(1, len(images))


def _fingerprint(dataset: Path, plan: Plan) -> str:
    digest = hashlib.sha256(f"{_METHOD} {plan.seed} {plan.water} {plan.start}".encode())
    for path in sorted((dataset / "labels").rglob("*.txt")):
        digest.update(f"{path.relative_to(dataset)}\n".encode() + path.read_bytes())
    for path in sorted((dataset / "images").rglob("*")):
        digest.update(f"{path.relative_to(dataset)} {path.stat().st_size}\n".encode())
    digest.update((dataset / "data.yaml").read_bytes())
    return digest.hexdigest()


def _known(project: Path, data: str) -> Learnt | None:
    """Return what was learnt before from the same labels."""
    try:
        content = parse_json((project / ABOUT).read_text(encoding="utf-8"))
        learnt = Learnt(**{**content, "classes": tuple(content["classes"])})
    except (OSError, ValueError, TypeError, KeyError):
        return None
    return learnt if learnt.data == data and (project / NETWORK).is_file() else None


def _sign(state: Path) -> Path:
    """Return the file that says to which data a training's state belongs."""
    return state.with_suffix(".sha256")


def _is_of(state: Path, data: str) -> bool:
    sign = _sign(state)
    return state.is_file() and sign.is_file() and sign.read_text(encoding="ascii") == data
