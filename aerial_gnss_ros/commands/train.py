# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss train`: the paper's curriculum on a labelled data set, resumable after a kill."""

from __future__ import annotations

import argparse
import json
import math
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from aerial_gnss_ros.bags.partial import refuse_existing
from aerial_gnss_ros.commands.dataset_arguments import inspected
from aerial_gnss_ros.commands.ending import ended_cleanly
from aerial_gnss_ros.commands.notices import note
from aerial_gnss_ros.commands.progress import progress
from aerial_gnss_ros.commands.train_arguments import add_arguments, phases_of, plan_of, plan_resumed
from aerial_gnss_ros.core.values.errors import ConfigError, InputError
from aerial_gnss_ros.teaching.dataset import FEW
from aerial_gnss_ros.text.sentences import counted
from aerial_gnss_ros.training.inspection import Inspection
from aerial_gnss_ros.training.layout import open_dataset
from aerial_gnss_ros.training.model_card import figure
from aerial_gnss_ros.training.offline import require_ultralytics
from aerial_gnss_ros.training.phases import members
from aerial_gnss_ros.training.results import written
from aerial_gnss_ros.training.run_folder import Plan, RunFolder, planned_data
from aerial_gnss_ros.training.supervise import TrainingError, train_in_process

__all__ = ["add_arguments", "run"]

NEEDED = ("train", "val")
INTERRUPTED = 130


def run(args: argparse.Namespace) -> int:
    """Train, or resume, and report the result.

    Raises:
        AerialGnssError: wrong arguments, a data set with errors, a training that ended early.
    """
    if args.check:
        return _check(args)
    with _stopped_politely(args):
        folder, plan = _resumed(args) if args.resume else _begun(args)
        folder.save(plan)
        try:
            _follow(folder, plan)
        except TrainingError as error:
            if error.explained and not args.resume and not folder.has_learnt:
                shutil.rmtree(folder.path)  # nothing to resume; frees the name
            raise
    scores = json.loads((folder.path / "scores.json").read_text(encoding="utf-8"))
    if args.json:
        print(json.dumps({"run": str(folder.path), "scores": scores}, indent=2))
        return 0
    print(_summary(scores))
    for file in written(folder.path):
        print(file)
    return 0


def _summary(scores: dict[str, Any]) -> str:
    where = f"on {scores['images']} held-out images ({scores['split']})"
    precise = f"mAP50-95 {figure(scores['map50_95'])}"
    if not scores["recall"]:  # 0, or no labelled robot
        return f"{where}: {precise}, no robot found at score {scores['score_threshold']:g} or more"
    return (
        f"{where}: {precise}, precision {figure(scores['precision'])}, recall "
        f"{figure(scores['recall'])}, box centre off by "
        f"{figure(scores['centre_error_median_px'], 1)} px"
    )


def _check(args: argparse.Namespace) -> int:
    if args.dataset is None:
        raise ConfigError("--check needs a DATASET.")
    found = inspected(args, NEEDED)
    counts = {}
    for split, examples in found.examples.items():
        held = [len(example.boxes) for example in examples]
        counts[split] = {
            "images": len(held), "robots": sum(held), "one": held.count(1),
            "several": sum(count > 1 for count in held), "none": held.count(0),
        }  # fmt: skip
    if args.json:
        print(json.dumps({"splits": counts, "fingerprint": found.fingerprint()}, indent=2))
    else:
        for split, n in counts.items():
            print(
                f"{split}: {counted(n['images'], 'image')}, {counted(n['robots'], 'robot')}; "
                f"images with one: {n['one']}, several: {n['several']}, none: {n['none']}"
            )
        print(f"fingerprint {found.fingerprint()}")
    _note_few(found)
    for phase in phases_of(args):
        members(phase, found.examples["train"])  # errors that training would refuse
    return 0


def _note_few(found: Inspection) -> None:
    """Say so where there are too few robots to learn from, or none to choose the weights by."""
    shown = {
        split: sum(len(one.boxes) for one in examples) for split, examples in found.examples.items()
    }
    if shown["train"] < FEW:
        note(
            f"the training images show {counted(shown['train'], 'robot')}, too few to train on; "
            f"label more, {FEW} at the least."
        )
    if not shown["val"]:
        note("no robot is in the validation images, so nothing tells which weights are the best.")


def _begun(args: argparse.Namespace) -> tuple[RunFolder, Plan]:
    if args.dataset is None or args.output is None:
        raise ConfigError("give a DATASET and -o RUN, or --resume RUN.")
    refuse_existing(args.output)
    plan = plan_of(args)
    require_ultralytics("training")
    found = inspected(args, NEEDED)
    _note_few(found)
    for phase in plan.phases:
        members(phase, found.examples["train"])
    folder = RunFolder(args.output)
    folder.path.mkdir(parents=True)
    file = found.dataset.file.resolve()
    return folder, replace(plan, dataset=file, fingerprint=found.fingerprint())


def _resumed(args: argparse.Namespace) -> tuple[RunFolder, Plan]:
    folder = RunFolder(args.resume)
    plan = plan_resumed(folder.load(), args)
    if folder.weights.exists():
        raise InputError(f"{folder.path} is already finished; its result is {folder.weights}.")
    if args.dataset is not None:  # it has moved, and no other file may replace it
        plan = replace(plan, dataset=open_dataset(args.dataset).file.resolve())
        planned_data(plan)
    require_ultralytics("training")
    with folder.locked():
        pass
    return folder, plan


def _follow(folder: RunFolder, plan: Plan) -> None:
    hours = sum(phase.hours for phase in plan.phases)
    total = math.ceil(60.0 * hours) or sum(phase.epochs for phase in plan.phases)
    with progress("training", total, "minutes" if hours else "epochs") as report:

        def on_event(event: dict[str, Any]) -> None:
            if "epoch" in event:
                report(event["epoch"])
            elif "minute" in event:
                report(event["minute"])
            elif "doing" in event:
                print(event["doing"], file=sys.stderr)

        train_in_process(folder, plan.threads, on_event)


@contextmanager
def _stopped_politely(args: argparse.Namespace) -> Iterator[None]:
    """Print how to resume a stopped training; no finished epoch is lost."""
    try:
        with ended_cleanly():
            yield
    except KeyboardInterrupt:
        folder = args.resume or args.output
        if folder is None or not RunFolder(folder).plan_file.is_file():
            raise
        result = RunFolder(folder).weights
        if result.is_file():
            words = f"stopped after its end; its result is {result}"
        else:
            words = f"stopped; continue with aerial-gnss train --resume {folder}"
        print(f"aerial-gnss: {words}", file=sys.stderr)
        raise SystemExit(INTERRUPTED) from None
