# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What training data is worth: renderers, curriculum and augmentation, the same budget each.

Every arm begins with the same weights, sees as many pictures as every other, in the same number of
steps, through `aerial-gnss train`; each is scored on test pictures of both renderers that share no
scene with training. An arm that is done is kept, so a run that was stopped goes on. The commands
that make the pictures: docs/results/training.md.

Standard errors have two parts: test scenes drawn anew, the same for every arm
(`training.drawn_anew`), and what training varies from seed to seed, pooled over the arms. The
figure to judge by, chosen before any arm was scored: mAP50-95.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.simulation.dataset import SCENE_IMAGES
from aerial_gnss_ros.training.compare import for_scoring
from aerial_gnss_ros.training.drawn_anew import FIGURES, draws, figures_of_draws
from aerial_gnss_ros.training.labelled import LabelledImage, read_folder

Array = NDArray[np.float64]

TESTS = ("fast", "blender")
NAMES = {"map50": "mAP50", "map50_95": "mAP50-95"}
DRAWS = 400
VAL = 8  # pictures by which the best epoch of each arm is chosen
BATCH = 16
SAME_VARIANT = 5  # passes: were each variant seen once, in one epoch, the rate would not fall
RATE = 0.0002  # of fine-tuning; at 0.002 every arm lost what the start knew


@dataclass(frozen=True)
class Arm:
    """One way to train: which pictures, how.

    Attributes:
        name: of the row.
        sources: renderers, in equal parts.
        curriculum: first pictures with one robot, then those with several.
        augmentation: "light" (ultralytics' colours, shifts, flips while training), "none", or
            "paper" (variants of each picture by `aerial-gnss augment`, a new one in every so many
            passes: `SAME_VARIANT`).
    """

    name: str
    sources: tuple[str, ...]
    curriculum: bool = False
    augmentation: str = "light"


ARMS = (
    Arm("start", ()),
    Arm("fast", ("fast",)),
    Arm("blender", ("blender",)),
    Arm("both", ("fast", "blender")),
    Arm("both, curriculum", ("fast", "blender"), curriculum=True),
    Arm("both, no augmentation", ("fast", "blender"), augmentation="none"),
    Arm("both, paper's augmentation", ("fast", "blender"), augmentation="paper"),
)

COMPARED = (
    ("fast", "start"),
    ("blender", "start"),
    ("blender", "fast"),
    ("both", "fast"),
    ("both", "blender"),
    ("both, curriculum", "both"),
    ("both", "both, no augmentation"),
    ("both, paper's augmentation", "both, no augmentation"),
)


def main() -> None:
    """Train and score what is missing, print the table of what is there."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("fast", "blender", "fast-test", "blender-test"):
        parser.add_argument(f"--{name}", type=Path, nargs="+", required=True, metavar="FOLDER")
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--weights", default="aqua_yolo11n.onnx", help="that every arm begins with")
    parser.add_argument("--images", type=int, default=48, help="to train on in each arm")
    parser.add_argument("--passes", type=int, default=10, help="over the images")
    parser.add_argument("--seeds", type=int, nargs="+", default=[0])
    parser.add_argument("--arms", nargs="+", choices=[arm.name for arm in ARMS])
    parser.add_argument("--table", action="store_true", help="only print what is there")
    given = parser.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    wanted = [
        (arm, seed)
        for seed in given.seeds
        for arm in ARMS
        if (given.arms is None or arm.name in given.arms) and (arm.sources or seed == 0)
    ]
    for arm, seed in wanted if not given.table else ():
        if arm.sources and not weights_of(arm, seed, given.output).exists():
            spent = train(arm, seed, given)
            print(f"trained {arm.name}, seed {seed}, in {spent:.0f} s", flush=True)
        result = given.output / f"{_plain(arm.name)}_{seed}.json"
        if not result.exists():
            weights = weights_of(arm, seed, given.output) if arm.sources else Path(given.weights)
            figures = {
                "fast": score(weights, given.fast_test),
                "blender": score(weights, given.blender_test),
            }
            result.write_text(json.dumps(figures) + "\n", encoding="utf-8")
            print(f"scored {arm.name}, seed {seed}", flush=True)
    print(tables(given.output))


def _plain(name: str) -> str:
    return "".join(c if c.isalnum() else "_" for c in name)


def weights_of(arm: Arm, seed: int, folder: Path) -> Path:
    """Return where the trained weights of an arm lie."""
    return folder / f"{_plain(arm.name)}_{seed}.pt"


def gather(arm: Arm, given: argparse.Namespace, folder: Path) -> Path:
    """Write the arm's data set: equal parts of its sources, and others to choose the epoch by."""
    for kind in ("images", "labels"):
        for split in ("train", "val"):
            (folder / kind / split).mkdir(parents=True)
    for source in arm.sources:
        pictures = pictures_of(getattr(given, source))
        share, spare = given.images // len(arm.sources), VAL // len(arm.sources)
        if len(pictures) < share + spare:
            sys.exit(f"{source}: {len(pictures)} pictures, but {share + spare} are needed.")
        for i, picture in enumerate(pictures[: share + spare]):
            split = "train" if i < share else "val"
            name = f"{source}_{i:04d}"
            shutil.copy(picture, folder / "images" / split / f"{name}.jpg")
            shutil.copy(label_of(picture), folder / "labels" / split / f"{name}.txt")
    (folder / "data.yaml").write_text("train: images/train\nval: images/val\nnames: {0: aqua}\n")
    if arm.augmentation != "paper":
        return folder
    augmented = folder.with_name("augmented")
    variants = max(1, given.passes // SAME_VARIANT)
    _command("augment", folder, "-o", augmented, "--processes", "1", "--variants", variants)
    return augmented


def pictures_of(folders: list[Path]) -> list[Path]:
    """Return all pictures of data sets, in order."""
    return [p for folder in folders for p in sorted((folder / "images").rglob("*.jpg"))]


def label_of(picture: Path) -> Path:
    """Return the label file of a picture in YOLO's layout."""
    split, folder = picture.parent.name, picture.parent.parent.parent
    return folder / "labels" / split / f"{picture.stem}.txt"


def train(arm: Arm, seed: int, given: argparse.Namespace) -> float:
    """Run `aerial-gnss train`, the same number of steps for every arm; return the seconds."""
    work = given.output / f"{_plain(arm.name)}_{seed}"
    shutil.rmtree(work, ignore_errors=True)
    data = gather(arm, given, work / "data")
    steps = given.passes * given.images / BATCH
    counts = [_robots(p) for p in pictures_of([data]) if p.parent.name == "train"]
    parts = [sum(n <= 1 for n in counts), sum(n != 1 for n in counts)]
    if not arm.curriculum:
        parts = [len(counts)]
    epochs = [max(1, round(steps / len(parts) * BATCH / part)) for part in parts]
    begun = time.monotonic()
    _command(
        "train", data, "-o", work / "run", "--weights", given.weights,
        "--epochs", ",".join(map(str, epochs)), *([] if arm.curriculum else ["--one-phase"]),
        "--image-size", "320", "--batch", BATCH, "--learning-rate", RATE, "--seed", seed,
        "--threads", "1", "--device", "cpu", "--bfloat16",
        "--online", "light" if arm.augmentation == "light" else "none",
    )  # fmt: skip
    shutil.copy(work / "run" / "best.pt", weights_of(arm, seed, given.output))
    shutil.rmtree(work)
    return time.monotonic() - begun


def _robots(picture: Path) -> int:
    return len(label_of(picture).read_text().splitlines())


def _command(*words: object) -> None:
    """Run `aerial-gnss`."""
    command = [sys.executable, "-m", "aerial_gnss_ros.cli", *map(str, words)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)  # noqa: S603


def score(weights: Path, folders: list[Path]) -> dict[str, Any]:
    """Return the figures at the default threshold, of all test pictures and of each draw."""
    config = DetectorConfig(model=str(weights), allow_pickle=True, image_size=320)
    detector = load_detector(for_scoring(config))
    pairs = [(detector.detect(image.read()), image.truth) for image in pictured(folders)]
    threshold, every = DetectorConfig().score_threshold, np.arange(len(pairs))
    whole = figures_of_draws(pairs, [every], threshold)
    drawn = figures_of_draws(pairs, draws(len(pairs), SCENE_IMAGES, DRAWS), threshold)
    return {
        **{key: round(float(values[0]), 5) for key, values in whole.items()},
        "robots": sum(int(truth.counted.sum()) for _, truth in pairs),
        "images": len(pairs),
        "draws": {key: np.round(values, 5).tolist() for key, values in drawn.items()},
    }


def pictured(folders: list[Path]) -> Iterator[LabelledImage]:
    """Yield the pictures of all splits of data sets, in order."""
    for folder in folders:
        for split in sorted(path.name for path in (folder / "images").iterdir()):
            if any((folder / "images" / split).iterdir()):
                yield from read_folder(folder, split)


@dataclass(frozen=True)
class Scores:
    """What an arm scored with all its seeds, each figure of each test.

    Attributes:
        seeds: (seeds, columns) figures.
        draws: (draws, columns) mean over the seeds in each draw of test scenes.
    """

    seeds: Array
    draws: Array


def tables(folder: Path) -> str:
    """Return the results, and their differences, as Markdown with standard errors."""
    scores = {arm.name: found for arm in ARMS if (found := _read(arm, folder)) is not None}
    several = [s.seeds for s in scores.values() if len(s.seeds) > 1]
    varies = np.sqrt(np.mean([s.var(axis=0, ddof=1) for s in several], axis=0)) if several else 0.0
    names = [NAMES.get(key, key) for key in FIGURES]
    head = [f"{test}: {names[0]}" for test in ("fast", "Blender")]
    head = [head[0], *names[1:], head[1], *names[1:]]
    rows = [("trained on", "seeds", *head), ("---",) * (2 + len(head))]
    for name, arm in scores.items():
        trained = varies / np.sqrt(len(arm.seeds)) if name != "start" else 0.0
        errors = np.hypot(arm.draws.std(axis=0), trained)
        cells = [f"{m:.3f} ± {e:.3f}" for m, e in zip(arm.seeds.mean(axis=0), errors, strict=True)]
        rows.append((name, str(len(arm.seeds)), *cells))
    rows += [(), ("difference", *head), ("---",) * (1 + len(head))]
    for one, other in COMPARED:
        if one in scores and other in scores:
            a, b = scores[one], scores[other]
            parts = [1 / len(s.seeds) for s, name in ((a, one), (b, other)) if name != "start"]
            errors = np.hypot((a.draws - b.draws).std(axis=0), varies * np.sqrt(sum(parts)))
            means = a.seeds.mean(axis=0) - b.seeds.mean(axis=0)
            cells = [f"{m:+.3f} ± {e:.3f}" for m, e in zip(means, errors, strict=True)]
            rows.append((f"{one} - {other}", *cells))
    return "\n".join(f"| {' | '.join(row)} |" if row else "" for row in rows)


def _read(arm: Arm, folder: Path) -> Scores | None:
    files = sorted(folder.glob(f"{_plain(arm.name)}_[0-9]*.json"))
    if not files:
        return None
    runs = [json.loads(file.read_text(encoding="utf-8")) for file in files]
    seeds = [[run[test][key] for test in TESTS for key in FIGURES] for run in runs]
    drawn = [[run[test]["draws"][key] for test in TESTS for key in FIGURES] for run in runs]
    return Scores(np.array(seeds), np.mean(drawn, axis=0).T)


if __name__ == "__main__":
    main()
