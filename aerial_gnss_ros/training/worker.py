# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The process that trains: `python -m aerial_gnss_ros.training.worker RUN`, started by supervise.

It reports on standard output, a JSON object on each line: {"epoch": n} after n epochs of all
phases, {"minute": n} after n minutes of a given time, {"doing": words}, {"error": sentence}. Output
of libraries goes to standard error. It ends when its standard input does, so it never outlives its
parent.
"""

from __future__ import annotations

import errno
import json
import math
import os
import shutil
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from aerial_gnss_ros.core.values.errors import AerialGnssError, ConfigError, ModelError
from aerial_gnss_ros.text.sentences import counted
from aerial_gnss_ros.training import train
from aerial_gnss_ros.training.curves import read_epochs
from aerial_gnss_ros.training.data_view import write_view
from aerial_gnss_ros.training.inspection import Inspection
from aerial_gnss_ros.training.offline import keep_to_itself
from aerial_gnss_ros.training.phases import Phase, members
from aerial_gnss_ros.training.run_folder import Plan, RunFolder, planned_data, write_whole

Say = Callable[..., None]
Report = Callable[[int, float], None]  # epochs and seconds of a phase that are done
_LARGE_SHARE = 0.25  # of the free memory, for images that are kept decoded


def main(arguments: list[str]) -> int:
    """Train in a run folder; 0 when all is written, 2 after {"error": ...}."""
    # Libraries print to standard output, which only `say` may use.
    channel = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    threading.Thread(target=_end_with_parent, daemon=True).start()

    def say(**event: Any) -> None:
        channel.write(json.dumps(event) + "\n")
        channel.flush()

    run = RunFolder(Path(arguments[0]))
    try:
        with run.locked():
            _train(run, say)
    except AerialGnssError as error:
        say(error=str(error))
    except Exception as error:
        words = _what_ran_out(error)
        if not words:
            raise  # the log gets it all
        say(error=f"{words}: aerial-gnss train --resume {run.path}")
    else:
        return 0
    return 2


def _end_with_parent() -> None:
    while os.read(0, 1024):  # nothing is sent; not sys.stdin, whose lock outlives the process
        pass
    os._exit(1)


def _what_ran_out(error: BaseException) -> str:
    """Return the start of a sentence if memory or disk ran out, else nothing."""
    words = str(error).lower()
    if isinstance(error, OSError) and error.errno == errno.ENOSPC:
        return "the disk is full; free some space and continue"
    if isinstance(error, MemoryError) or any(
        said in words
        for said in ("out of memory", "can't allocate memory", "cannot allocate memory")
    ):
        return "memory ran out; continue with a smaller --batch, or start again with smaller images"
    return ""


def _train(run: RunFolder, say: Say) -> None:
    plan = run.load()
    say(doing="inspecting the data set")
    found = planned_data(plan)
    say(doing="starting torch")
    keep_to_itself(plan.threads)
    for number in range(len(plan.phases)):
        if not run.phase_weights(number).is_file():
            _train_phase(run, plan, number, found, say)
    say(doing="scoring")
    from aerial_gnss_ros.training.results import write_results

    write_results(run, plan, found)
    for spare in (run.data, run.settings):
        shutil.rmtree(spare, ignore_errors=True)


def _train_phase(run: RunFolder, plan: Plan, number: int, found: Inspection, say: Say) -> None:
    from ultralytics.utils.torch_utils import strip_optimizer

    phase = plan.phases[number]
    examples = members(phase, found.examples["train"])
    say(
        doing=f"phase {number + 1} of {len(plan.phases)}: {phase.words}, "
        f"{counted(len(examples), 'image')}"
    )
    before = sum(phase.epochs for phase in plan.phases[:number])
    if not _is_done(run, number, phase):
        splits = {"train": examples, "val": found.examples["val"]}
        data = write_view(run.data / f"phase{number + 1}", splits, found.dataset.names)
        _fit(run, plan, number, data, lambda *done: say(**_amount(phase, before, *done)))
    say(**_amount(phase, before, phase.epochs, 60.0 * math.ceil(60.0 * phase.hours)))
    stripped = run.phase(number) / ".best.pt.partial"
    # For a given time, the last weights: they have seen the lowest learning rate, and no epoch
    # before was scored.
    kept = run.checkpoint(number) if phase.hours else run.checkpoint_best(number)
    shutil.copyfile(kept, stripped)
    strip_optimizer(str(stripped))
    stripped.replace(run.phase_weights(number))
    for spare in (run.checkpoint(number), run.checkpoint_best(number)):
        spare.unlink()
    shutil.rmtree(run.phase(number) / "weights")  # ultralytics' own copies


def _epochs_done(run: RunFolder, number: int) -> int:
    """Return the number of epochs in the phase's checkpoint; 0 without one."""
    if not run.checkpoint(number).is_file():
        return 0
    from ultralytics.utils.patches import torch_load

    return int(torch_load(run.checkpoint(number), map_location="cpu")["epoch"]) + 1


def _seconds_done(run: RunFolder, number: int) -> float:
    """Return the training time of a phase up to its checkpoint, s; 0 without one."""
    epochs = str(_epochs_done(run, number))
    rows = read_epochs([run.phase(number) / "results.csv"])
    return next((float(row["time"]) for row in rows if row["epoch"] == epochs), 0.0)


def _is_done(run: RunFolder, number: int, phase: Phase) -> bool:
    if phase.hours:
        return _seconds_done(run, number) >= 3600.0 * phase.hours
    return _epochs_done(run, number) >= phase.epochs


def _amount(phase: Phase, before: int, epochs: int, seconds: float) -> dict[str, int]:
    """Return the progress over all phases from that of this one."""
    if phase.hours:
        return {"minute": int(seconds / 60.0)}
    return {"epoch": before + epochs}


def _fit(run: RunFolder, plan: Plan, number: int, data: Path, report: Report) -> None:
    """Train a phase from its present state to its end."""
    from ultralytics import YOLO

    phase, folder, checkpoint = plan.phases[number], run.phase(number), run.checkpoint(number)
    start = plan.weights if number == 0 else str(run.phase_weights(number - 1))
    training = train.Training(
        data=data,
        weights=start,
        hours=phase.hours,
        epochs=phase.epochs or train.Training.epochs,
        image_size=plan.image_size,
        batch=plan.batch,
        learning_rate=plan.learning_rate,
        seed=plan.seed,
        threads=plan.threads,
        bfloat16=plan.bfloat16,
        freeze=plan.freeze,
    )
    resumed = checkpoint.is_file()
    if resumed:
        model = YOLO(str(checkpoint))
    else:
        shutil.rmtree(folder, ignore_errors=True)  # of an epoch that was not finished
        folder.mkdir()
        model = _network(training)
    own = _own_options(plan, data, folder)
    # Scoring each epoch would cost training time, and select nothing.
    own["val"] = not phase.hours
    model.add_callback("on_model_save", lambda trainer: _keep(run, number, trainer, report))
    train.add_callbacks(model, training, _seconds_done(run, number))
    options: dict[str, Any] = {"resume": True} if resumed else train.options(training)
    if plan.online == "none":
        options.update(dict.fromkeys(train.AUGMENTATION, 0.0))
    model.train(**{**options, **own})


def _network(training: train.Training) -> Any:
    """Return the initial model; raise ModelError."""
    try:
        model = train.network(training)
    except (AerialGnssError, MemoryError):
        raise
    except Exception as error:  # ultralytics and torch raise arbitrary exceptions on damage
        words = str(error).strip().splitlines() or [type(error).__name__]
        raise ModelError(f"{training.weights} cannot be trained further: {words[0]}") from error
    if model.task != "detect":
        raise ModelError(f"{training.weights} is for the task {model.task}, not for detection.")
    layers = len(model.model.model)
    if training.freeze >= layers:
        raise ConfigError(
            f"--freeze {training.freeze} leaves nothing to train: {Path(training.weights).name} "
            f"has {layers} layers; give {layers - 1} at most."
        )
    return model


def _keep(run: RunFolder, number: int, trainer: Any, report: Report) -> None:
    """Keep a checkpoint that is complete even if the process is killed now."""
    if trainer.best_fitness == trainer.fitness or not run.checkpoint_best(number).is_file():
        write_whole(run.checkpoint_best(number), Path(trainer.best).read_bytes())
    write_whole(run.checkpoint(number), Path(trainer.last).read_bytes())
    report(trainer.epoch + 1, time.time() - trainer.train_time_start)


def _own_options(plan: Plan, data: Path, folder: Path) -> dict[str, Any]:
    """Return options that differ from ultralytics' defaults, and may differ after resuming."""
    import torch

    gpus = torch.cuda.device_count() if torch.cuda.is_available() else 0
    device = plan.device or ("0" if gpus else "cpu")
    if device.isdecimal() and int(device) >= gpus:
        there = f"GPUs 0 to {gpus - 1}; give one of them" if gpus else "no GPU; leave it out"
        raise ConfigError(f"--device {device}: torch sees {there}, or give cpu.")
    on_gpu = device != "cpu"
    if on_gpu:
        # ultralytics tests 16 bits on a network that it downloads; every recent GPU supports them.
        from ultralytics.engine import trainer

        trainer.check_amp = lambda _: True
    return {
        "data": str(data),
        "save_dir": str(folder),
        "batch": plan.batch,
        "device": device,
        "amp": on_gpu,
        "workers": min(plan.threads or os.cpu_count() or 1, 8) if on_gpu else 0,
        "plots": False,
        "patience": 1_000_000,  # the number of epochs is the requested one
        "cache": "ram" if _fits_memory(plan, data) else False,
    }


def _fits_memory(plan: Plan, data: Path) -> bool:
    images = sum(1 for _ in (data.parent / "images").rglob("*"))
    free = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    return bool(images * 3 * plan.image_size**2 < _LARGE_SHARE * free)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
