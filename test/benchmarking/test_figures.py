# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Figures and their table, and the description of the machine."""

from __future__ import annotations

import math
import os
import time
from multiprocessing import shared_memory

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="ROS 2 is not installed")

from aerial_gnss_ros.benchmarking.figures import (
    cost_of_a_robot,
    live_figures,
    markdown,
    one_process_figures,
    spread,
)
from aerial_gnss_ros.benchmarking.live import Live
from aerial_gnss_ros.benchmarking.machine import (
    Power,
    describe,
    own_memory_mb,
    peak_memory_mb,
    processor_s,
    segments_mb,
    shared_memory_mb,
)
from aerial_gnss_ros.benchmarking.one_process import Run


def test_spread():
    assert spread([1.0, 2.0, 3.0, 10.0, math.nan]) == {"mean": 4.0, "median": 2.5, "p95": 8.95}
    assert spread([]) is None


def alone(estimate, publish):
    samples = {"decode": [1.0] * 4, "infer": [20.0] * 4, "estimate": estimate, "publish": publish}
    return one_process_figures(Run(samples, wall_s=0.1, processor_s=0.15, images=4, positions=8))


def test_figures_of_one_process():
    figures = alone([1.0] * 4, [0.5] * 4)
    assert figures["images_per_s"] == 40.0
    assert figures["times_bare_inference"] == 1.25  # 25 ms an image, 20 of them in the network
    assert figures["processor_ms_per_image"] == 37.5
    assert figures["stages_ms"]["infer"]["median"] == 20.0
    more = alone([1.1] * 4, [1.1] * 4)
    assert cost_of_a_robot(figures, more, 2) == {"estimate": 0.05, "publish": 0.3}


def through_nodes(processed):
    live = Live(offered=100, processed=processed, seconds=10.0, memory_mb=300.0)
    live.starts_s = [1.5, 3.25, 1.0]
    live.samples_ms = {"detector": {"infer": [80.0]}, "estimator": {"wait": [10.0]}}
    live.to_position_ms = [100.0, 120.0]
    live.processor_s = {"nodes": 12.0, "camera": 2.0, "subscriber": 1.0}
    return live_figures(live)


def test_figures_through_nodes():
    figures = through_nodes(processed=50)
    assert figures["images_per_s"] == 5.0
    assert figures["times_bare_inference"] == 2.5  # 200 ms an image, 80 of them in the network
    assert figures["stamp_to_position_ms"]["median"] == 110.0
    assert figures["processor_cores_busy"]["all"] == 1.5
    assert figures["processor_ms_per_image"] == 300.0
    assert through_nodes(processed=100)["times_bare_inference"] is None  # the camera decides


def test_the_table_names_the_machine_and_each_run():
    run = {"robots": 1, "search": "roi", "detector": "m.onnx on X"}
    run |= {"nodes": through_nodes(50) | {"power": {}}, "one_process": alone([1.0], [0.5])}
    text = markdown(
        {
            "when": "2026-01-02", "command": "aerial-gnss benchmark", "version": "1",
            "machine": {"device": "Some Board", "cores": 2}, "load_average_before": 0.1,
            "images": "simulated", "ultralytics": {"skipped": "not requested"},
            "runs": [run, run | {"robots": 3}],
            "cost_of_a_robot": [{"search": "roi", "ms": {"estimate": 0.05}}],
        }
    )  # fmt: skip
    assert "Some Board" in text
    assert "| | roi, 1 robot | roi, 3 robots |" in text
    assert "| images a second | 5 | 5 |" in text
    assert "| stamp to position, ms (mean / median / p95) | 110 / 110 / 119 |" in text
    assert "| start to first detection, s (median) | 1.5 | 1.5 |" in text
    assert "| each start, s | 1, 1.5, 3.25 | 1, 1.5, 3.25 |" in text
    assert "estimate 0.05 ms" in text


def test_a_process_tells_what_it_takes():
    assert processor_s(os.getpid()) > 0.0
    assert peak_memory_mb(os.getpid()) > 10.0
    assert math.isnan(processor_s(2**22 + 1))
    assert describe()["cores"] >= 1


def test_shared_memory_is_distinguished_from_a_process_s_own():
    content = b"1" * 80_000_000
    between = 15.0  # MB by which what other tests left behind may change meanwhile

    def measured():
        pid = os.getpid()
        return np.array([own_memory_mb(pid), shared_memory_mb(pid), segments_mb(pid)])

    before = measured()
    segment = shared_memory.SharedMemory(create=True, size=160_000_000)
    try:
        assert measured() - before == pytest.approx([0.0, 0.0, 160.0], abs=between)
        segment.buf[:80_000_000] = content
        assert measured() - before == pytest.approx([0.0, 80.0, 160.0], abs=between)
    finally:
        segment.close()
        segment.unlink()
    held = np.ones(80_000_000, np.uint8)
    assert measured() - before == pytest.approx([80.0, 0.0, 0.0], abs=between)
    assert held.all()
    assert math.isnan(own_memory_mb(2**22 + 1))


def test_power_of_a_jetson_and_of_a_processor(tmp_path, monkeypatch):
    rails = tmp_path / "bus/i2c/drivers/ina3221/1-0040/hwmon/hwmon3"
    rails.mkdir(parents=True)
    for number, (label, volts, amperes) in enumerate(
        [("VDD_IN", 5000, 2000), ("VDD_CPU", 5000, 500)], start=1
    ):
        (rails / f"in{number}_label").write_text(label + "\n")
        (rails / f"in{number}_input").write_text(f"{volts}\n")
        (rails / f"curr{number}_input").write_text(f"{amperes}\n")
    monkeypatch.setattr("aerial_gnss_ros.benchmarking.machine._SAMPLE_S", 0.01)
    power = Power(tmp_path)
    power.begin()
    end = time.monotonic() + 60.0
    while not power._samples and time.monotonic() < end:
        power._thread.join(0.01)
    assert power.end() == {"board_w": 10.0}  # the input feeds the others
    assert Power(tmp_path / "absent")._rails == []
    counter = tmp_path / "class/powercap/intel-rapl:0/energy_uj"
    counter.parent.mkdir(parents=True)
    counter.write_text("1000000\n")
    power = Power(tmp_path)
    power.begin()
    counter.write_text("3000000\n")
    assert power.end()["processor_package_w"] > 0.0
