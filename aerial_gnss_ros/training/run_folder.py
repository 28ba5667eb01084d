# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The folder of a training, and the state for resuming it."""

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
    """Everything that determines a training.

    Attributes:
        dataset: data.yaml, an absolute path.
        fingerprint: of its content.
        unlabelled_is_empty: whether images without a label file show no robot.
        phases: in their order.
        weights: initial weights: an .onnx or .pt file, or a network's description (.yaml).
        image_size: side of the square that images are fitted into, px.
        batch: images per step.
        learning_rate: at the start of each phase; falls along a cosine to a hundredth.
        seed: of the first weights and of the order of images.
        online: light: colour, small shifts and flips, drawn in each epoch; none: images unchanged.
        threads: of the processor; 0: as many as other programs leave free.
        device: such as cpu or 0; empty: a GPU where there is one.
        bfloat16: on a processor: calculate in 16 bits.
        freeze: number of first layers that stay fixed, with all normalisations.
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
        path: the folder. Results (best.pt and its description) are written at the end; until then
            it holds the state for resuming.
    """

    path: Path

    @property
    def plan_file(self) -> Path:
        """The plan, which marks the folder as a training's."""
        return self.path / "plan.json"

    @property
    def log(self) -> Path:
        """Log of ultralytics."""
        return self.path / "training.log"

    @property
    def weights(self) -> Path:
        """The result."""
        return self.path / "best.pt"

    @property
    def data(self) -> Path:
        """View of the data set for ultralytics."""
        return self.path / "data"

    @property
    def settings(self) -> Path:
        """Settings of ultralytics."""
        return self.path / ".ultralytics"

    def phase(self, number: int) -> Path:
        """Return the folder of a phase, from 0."""
        return self.path / f"phase{number + 1}"

    def phase_weights(self, number: int) -> Path:
        """Return the best weights of a phase, which exist once it is finished."""
        return self.phase(number) / "best.pt"

    def checkpoint(self, number: int) -> Path:
        """Return the checkpoint of a phase's last complete epoch."""
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
            InputError: the folder is not a training's.
        """
        try:
            stored: dict[str, Any] = parse_json(self.plan_file.read_text(encoding="utf-8"))
            if stored.pop("format") != FORMAT:
                raise InputError(f"{self.path} was written by another version of this program.")
            phases = tuple(Phase(**phase) for phase in stored.pop("phases"))
            return Plan(dataset=Path(stored.pop("dataset")), phases=phases, **stored)
        except FileNotFoundError as error:
            raise InputError(
                f"{self.path} is not a training that can be resumed: it has no plan.json."
            ) from error
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise InputError(f"{self.plan_file} is damaged: {error}.") from error

    @contextmanager
    def locked(self) -> Iterator[None]:
        """Lock the folder against other trainings.

        Raises:
            InputError: another one is running in it.
        """
        with (self.path / ".lock").open("w") as file:
            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError as error:
                raise InputError(f"another process is training in {self.path}.") from error
            yield


def planned_data(plan: Plan) -> Inspection:
    """Return the data set of a training, if it is unchanged since the training began.

    Raises:
        DatasetError: the data set has errors.
        InputError: it is missing or has changed.
    """
    found = inspect(open_dataset(plan.dataset), unlabelled_is_empty=plan.unlabelled_is_empty)
    found.refuse_problems()
    if found.fingerprint() != plan.fingerprint:
        raise InputError(
            f"{plan.dataset} is not the data set of this training, or has changed since; start a "
            "new training, or restore the old images and labels."
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
