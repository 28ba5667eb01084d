# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What lies in the folder of a training, and what is remembered of it from start to resumption."""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.text.json_text import parse_json
from aerial_gnss_ros.training.inspection import Inspection, inspect
from aerial_gnss_ros.training.layout import open_dataset
from aerial_gnss_ros.training.phases import Phase

FORMAT = 1
ONLINE = ("light", "none")


@dataclass(frozen=True)
class Plan:
    """Everything that a training depends on.

    Attributes:
        dataset: data.yaml, an absolute path.
        fingerprint: of its content.
        unlabelled_is_empty: whether images without a label file show no robot.
        phases: in their order.
        weights: what to begin with: an .onnx or .pt file, or a network's description (.yaml).
        image_size: side of the square that images are fitted into, px.
        batch: images a step.
        learning_rate: at the start of each phase; falls along a cosine to a hundredth.
        seed: of the first weights and of the order of images.
        online: light: colour, small shifts and flips, drawn anew each epoch; none: images as
            they are.
        threads: of the processor; 0: as many as other programs leave free.
        device: such as cpu or 0; empty: a GPU where there is one.
        bfloat16: on a processor: calculate in 16 bits.
        freeze: so many of the first layers stay as they are, and all normalisations.
    """

    dataset: Path
    fingerprint: str
    unlabelled_is_empty: bool
    phases: tuple[Phase, ...]
    weights: str
    image_size: int = 1280
    batch: int = 16
    learning_rate: float = 0.002
    seed: int = 0
    online: str = "light"
    threads: int = 0
    device: str = ""
    bfloat16: bool = False
    freeze: int = 0


@dataclass(frozen=True)
class RunFolder:
    """The files of a training.

    Attributes:
        path: the folder. Results (best.pt and its description) appear at the end; until then
            it holds what a resumption needs.
    """

    path: Path

    @property
    def plan_file(self) -> Path:
        """The plan, which makes the folder one of a training."""
        return self.path / "plan.json"

    @property
    def log(self) -> Path:
        """What ultralytics says."""
        return self.path / "training.log"

    @property
    def weights(self) -> Path:
        """The result."""
        return self.path / "best.pt"

    @property
    def data(self) -> Path:
        """What ultralytics is shown of the data set."""
        return self.path / "data"

    @property
    def settings(self) -> Path:
        """Where ultralytics keeps its settings."""
        return self.path / ".ultralytics"

    def phase(self, number: int) -> Path:
        """Return the folder of a phase, from 0."""
        return self.path / f"phase{number + 1}"

    def phase_weights(self, number: int) -> Path:
        """Return the best weights of a phase: they exist when it is done."""
        return self.phase(number) / "best.pt"

    def checkpoint(self, number: int) -> Path:
        """Return where a phase goes on after its last whole epoch."""
        return self.phase(number) / "resume.pt"

    def checkpoint_best(self, number: int) -> Path:
        """Return the best weights up to that epoch."""
        return self.phase(number) / "resume_best.pt"

    @property
    def has_learnt(self) -> bool:
        """Whether any epoch was finished."""
        return any(self.path.glob("phase*/*.pt"))

    def save(self, plan: Plan) -> None:
        """Write the plan."""
        stored = {"format": FORMAT, **asdict(plan), "dataset": str(plan.dataset)}
        write_whole(self.plan_file, (json.dumps(stored, indent=2) + "\n").encode())

    def load(self) -> Plan:
        """Return the plan.

        Raises:
            InputError: the folder is none of a training.
        """
        try:
            stored: dict[str, Any] = parse_json(self.plan_file.read_text(encoding="utf-8"))
            if stored.pop("format") != FORMAT:
                raise InputError(f"{self.path} was written by another version of this program.")
            phases = tuple(Phase(**phase) for phase in stored.pop("phases"))
            return Plan(dataset=Path(stored.pop("dataset")), phases=phases, **stored)
        except FileNotFoundError as error:
            raise InputError(
                f"{self.path} is no training that could be resumed: it has no plan.json."
            ) from error
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise InputError(f"{self.plan_file} is damaged: {error}.") from error

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Keep other trainings out of the folder.

        Raises:
            InputError: one is at work in it.
        """
        with (self.path / ".lock").open("w") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise InputError(f"another process is training in {self.path}.") from error
            yield


def planned_data(plan: Plan) -> Inspection:
    """Return what a training learns from, if that is what it was when the training began.

    Raises:
        DatasetError: the data set has errors.
        InputError: it is not there, or another one.
    """
    found = inspect(open_dataset(plan.dataset), unlabelled_is_empty=plan.unlabelled_is_empty)
    found.refuse_problems()
    if found.fingerprint() != plan.fingerprint:
        raise InputError(
            f"{plan.dataset} is not what this training began with, or has changed since; begin a "
            "new one, or bring the old images and labels back."
        )
    return found


def write_whole(file: Path, content: bytes) -> None:
    """Write a file that is complete whenever it exists, also after a kill."""
    partial = file.with_name(f".{file.name}.partial")
    with partial.open("wb") as stream:
        stream.write(content)
        stream.flush()
        os.fsync(stream.fileno())
    partial.replace(file)
