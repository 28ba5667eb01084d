# SPDX-License-Identifier: Apache-2.0
"""What training data is worth: renderers, curriculum and augmentation, the same budget each.

Every arm begins with the same weights, sees as many pictures as every other, in the same number of
steps, through `aerial-gnss train`; each is scored on test pictures of both renderers that share no
scene with training. An arm that is done is kept, so a run that was stopped goes on.

aerial-gnss simulate --dataset fast --count 60 --val 0 --seed 501
aerial-gnss simulate --dataset fast_test --count 60 --val 0 --seed 502
aerial-gnss simulate --dataset blender --renderer blender --count 60 --val 0 --seed 200
aerial-gnss simulate --dataset unseen --renderer blender --ranges unseen --count 60 --val 0 \
    --seed 41
python benchmarks/training_data.py --fast fast --blender blender --fast-test fast_test \
    --blender-test unseen -o arms
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.training.held_out import score_weights
from aerial_gnss_ros.training.labelled import read_folder

FIGURES = ("map50", "map50_95", "precision", "recall")
VAL = 8  # pictures by which the best epoch of each arm is chosen
BATCH = 16
RATE = 0.0002  # of fine-tuning; at 0.002 every arm lost what the start knew


@dataclass(frozen=True)
class Arm:
    """One way to train: which pictures, how.

    Attributes:
        name: of the row.
        sources: renderers, in equal parts.
        curriculum: first pictures with one robot, then those with several.
        augmentation: "light" (ultralytics' colours, shifts, flips while training), "none", or
            "paper" (another variant of each picture in each pass, by `aerial-gnss augment`).
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
    parser.add_argument("--train", action="store_true", help="only train, score later")
    parser.add_argument("--table", action="store_true", help="only print what is there")
    given = parser.parse_args()
    given.output.mkdir(parents=True, exist_ok=True)
    wanted = [
        (arm, seed)
        for seed in given.seeds
        for arm in ARMS
        if (given.arms is None or arm.name in given.arms) and (arm.sources or seed == 0)
    ]
    for arm, seed in wanted:
        if not given.table and arm.sources and not weights_of(arm, seed, given.output).exists():
            spent = train(arm, seed, given)
            print(f"trained {arm.name}, seed {seed}, in {spent:.0f} s", flush=True)
    for arm, seed in wanted:
        result = given.output / f"{_plain(arm.name)}_{seed}.json"
        if not given.table and not given.train and not result.exists():
            weights = weights_of(arm, seed, given.output) if arm.sources else Path(given.weights)
            tests = {"fast": given.fast_test, "blender": given.blender_test}
            figures = {name: score(weights, folders) for name, folders in tests.items()}
            result.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
            print(f"{arm.name}, seed {seed}: {figures}", flush=True)
    print(table(given.output))


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
    _command("augment", folder, "-o", augmented, "--processes", "1", "--variants", given.passes)
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


def score(weights: Path, folders: list[Path]) -> dict[str, float]:
    """Return mean average precision, and precision and recall at the default threshold."""
    images = (
        image
        for folder in folders
        for split in sorted(
            path.name for path in (folder / "images").iterdir() if any(path.iterdir())
        )
        for image in read_folder(folder, split)
    )
    whole = score_weights(weights, images, DetectorConfig(image_size=320))
    figures = {key: round(whole[key], 3) for key in FIGURES}
    return {**figures, "robots": whole["overall"]["robots"], "images": whole["images"]}


def table(folder: Path) -> str:
    """Return the results as Markdown: mean over seeds, and their spread."""
    lines = [
        "| trained on | seeds | fast: "
        + " | ".join(FIGURES)
        + " | Blender: "
        + " | ".join(FIGURES)
        + " |",
        "|" + "---|" * (2 + 2 * len(FIGURES)),
    ]
    for arm in ARMS:
        files = sorted(folder.glob(f"{_plain(arm.name)}_[0-9]*.json"))
        if not files:
            continue
        runs = [json.loads(file.read_text()) for file in files]
        cells = [
            _cell([run[test][key] for run in runs])
            for test in ("fast", "blender")
            for key in FIGURES
        ]
        lines.append(f"| {arm.name} | {len(runs)} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _cell(values: list[float]) -> str:
    mean = f"{np.mean(values):.3f}"
    return mean if len(values) == 1 else f"{mean} ± {np.ptp(values) / 2:.3f}"


if __name__ == "__main__":
    main()
