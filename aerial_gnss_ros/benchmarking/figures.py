# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Measurements as JSON figures and as a Markdown table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from aerial_gnss_ros.benchmarking.live import Live
from aerial_gnss_ros.benchmarking.one_process import Run
from aerial_gnss_ros.text.sentences import counted

STAGES = ("decode", "pre", "infer", "post", "publish boxes", "estimate", "publish")
Figures = dict[str, Any]


def spread(samples: Sequence[float]) -> dict[str, float] | None:
    """Return mean, median and p95; None without samples."""
    values = np.array(samples, dtype=np.float64)
    values = values[np.isfinite(values)]
    if not len(values):
        return None
    return {
        "mean": round(float(values.mean()), 3),
        "median": round(float(np.median(values)), 3),
        "p95": round(float(np.percentile(values, 95)), 3),
    }


def one_process_figures(run: Run) -> Figures:
    """Return the figures of the pipeline without nodes."""
    infer = sum(run.samples_ms.get("infer", [])) / 1e3
    return {
        "images": run.images,
        "images_per_s": round(run.images / run.wall_s, 2),
        "ms_per_image": round(1e3 * run.wall_s / run.images, 3),
        "processor_ms_per_image": round(1e3 * run.processor_s / run.images, 3),
        "times_bare_inference": round(run.wall_s / infer, 3) if infer else None,
        "positions": run.positions,
        "stages_ms": {
            stage: spread(run.samples_ms[stage]) for stage in STAGES if stage in run.samples_ms
        },
    }


def live_figures(live: Live) -> Figures:
    """Return the figures of both nodes with camera and subscriber."""
    detector, estimator = (live.samples_ms.get(name, {}) for name in ("detector", "estimator"))
    stages = {stage: detector.get(stage, []) for stage in STAGES[:4]}
    stages["publish boxes"] = detector.get("publish", [])
    stages |= {f"{stage}": estimator.get(stage, []) for stage in ("estimate", "publish", "wait")}
    busy = sum(live.processor_s.values())
    infer = spread(stages["infer"])
    per_s = live.processed / live.seconds
    saturated = live.processed < 0.97 * live.offered
    return {
        "images_offered": live.offered,
        "images_processed": live.processed,
        "images_per_s": round(per_s, 2),
        "times_bare_inference": round(1e3 / per_s / infer["mean"], 3)
        if infer and per_s and saturated
        else None,
        "stamp_to_boxes_ms": spread(live.to_boxes_ms),
        "stamp_to_position_ms": spread(live.to_position_ms),
        "start_to_first_detection_s": round(float(np.median(live.starts_s)), 2),
        "starts_s": [round(seconds, 2) for seconds in sorted(live.starts_s)],
        "processor_cores_busy": {
            name: round(seconds / live.seconds, 3) for name, seconds in live.processor_s.items()
        }
        | {"all": round(busy / live.seconds, 3)},
        "processor_ms_per_image": round(1e3 * busy / live.processed, 2) if live.processed else None,
        "peak_memory_mb": round(live.memory_mb, 1),
        "stages_ms": {stage: spread(samples) for stage, samples in stages.items()},
        "images_dropped_for_newer": live.diagnostics.get("images_dropped_for_newer"),
        "images_lost_in_transport": live.diagnostics.get("images_lost_in_transport"),
    }


def cost_of_a_robot(few: Figures, many: Figures, more: int) -> dict[str, float]:
    """Return the cost of one more robot in each of the last three stages, ms (medians).

    Args:
        few: one-process figures with fewer robots.
        many: with more.
        more: how many more.
    """
    return {
        stage: round(
            (many["stages_ms"][stage]["median"] - few["stages_ms"][stage]["median"]) / more, 3
        )
        for stage in STAGES[4:]
        if few["stages_ms"].get(stage) and many["stages_ms"].get(stage)
    }


def markdown(figures: Figures) -> str:
    """Return all figures as Markdown."""
    machine, runs = figures["machine"], figures["runs"]
    words = ", ".join(f"{key.replace('_', ' ')} {value}" for key, value in machine.items())
    lines = [
        f"Measured {figures['when']} by `{figures['command']}`, version {figures['version']}.",
        "",
        f"- Machine: {words}; load average before the start {figures['load_average_before']}.",
        *(f"- Detector, {search}: {name}." for search, name in _detectors(runs).items()),
        f"- Images: {figures['images']}.",
        f"- Compared with ultralytics: {_compared(figures)}.",
        "",
        "Both nodes in one process, camera and subscriber in separate processes, connected by DDS:",
        "",
        *_table(_LIVE, [run for run in runs if run.get("nodes")], "nodes"),
        "",
        "One process without nodes, as fast as possible:",
        "",
        *_table(_ALONE, [run for run in runs if run.get("one_process")], "one_process"),
    ]
    lines += ["", *(_robot_line(cost) for cost in figures["cost_of_a_robot"])]
    return "\n".join(lines) + "\n"


def _detectors(runs: Sequence[Figures]) -> dict[str, str]:
    return {run["search"]: run["detector"] for run in runs if "detector" in run}


def _compared(figures: Figures) -> str:
    found = figures["ultralytics"]
    if "skipped" in found:
        return str(found["skipped"])
    return (
        f"{found['name']}: median {found['ms']['median']} ms an image, ours in full mode "
        f"{found['ours_ms']['median']} ms, on the same {found['images']} images"
    )


def _robot_line(cost: Mapping[str, Any]) -> str:
    parts = ", ".join(f"{stage} {ms} ms" for stage, ms in cost["ms"].items())
    return f"One more robot, {cost['search']} mode, one process: {parts}."


def _number(value: Any) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "-"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _stage(name: str) -> tuple[str, tuple[str, ...]]:
    return f"{name}, ms (mean / median / p95)", ("stages_ms", name)


_LIVE = (
    ("images offered", ("images_offered",)),
    ("images processed", ("images_processed",)),
    ("images a second", ("images_per_s",)),
    ("time an image / bare inference", ("times_bare_inference",)),
    ("stamp to position, ms (mean / median / p95)", ("stamp_to_position_ms",)),
    ("of it waiting for telemetry, ms", ("stages_ms", "wait")),
    ("stamp to boxes, ms", ("stamp_to_boxes_ms",)),
    *(_stage(name) for name in STAGES),
    ("start to first detection, s (median)", ("start_to_first_detection_s",)),
    ("each start, s", ("starts_s",)),
    ("cores busy: nodes", ("processor_cores_busy", "nodes")),
    ("cores busy: nodes, camera, subscriber", ("processor_cores_busy", "all")),
    ("processor time an image, all of them, ms", ("processor_ms_per_image",)),
    ("peak memory of the nodes, MB", ("peak_memory_mb",)),
    ("power: processor package, W", ("power", "processor_package_w")),
    ("power: board, W", ("power", "board_w")),
)
_ALONE = (
    ("images", ("images",)),
    ("images a second", ("images_per_s",)),
    ("time an image / bare inference", ("times_bare_inference",)),
    *(_stage(name) for name in STAGES),
    ("processor time an image, ms", ("processor_ms_per_image",)),
)


def _table(
    rows: Sequence[tuple[str, tuple[str, ...]]], runs: Sequence[Figures], part: str
) -> list[str]:
    if not runs:
        return ["(left out)"]
    heads = [f"{run['search']}, {_robots(run['robots'])}" for run in runs]
    lines = [f"| | {' | '.join(heads)} |", "|---" * (len(runs) + 1) + "|"]
    for title, path in rows:
        cells = [_cell(run[part], path) for run in runs]
        lines.append(f"| {title} | {' | '.join(cells)} |")
    return lines


def _robots(number: int | None) -> str:
    if number is None:
        return "recording"
    return counted(number, "robot")


def _cell(figures: Any, path: tuple[str, ...]) -> str:
    for word in path:
        figures = None if figures is None else figures.get(word)
    if isinstance(figures, dict):
        return " / ".join(_number(round(figures[key], 2)) for key in ("mean", "median", "p95"))
    if isinstance(figures, list):
        return ", ".join(map(_number, figures))
    return _number(figures)
