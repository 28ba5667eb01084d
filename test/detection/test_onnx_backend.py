# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What ONNX Runtime takes while a network looks at images of several sizes."""

from __future__ import annotations

import os
import platform
import subprocess
import sys

import pytest

_LOOKS = """
import os
import numpy as np
from aerial_gnss_ros.benchmarking.machine import own_memory_mb
from aerial_gnss_ros.detection.config import DetectorConfig
from aerial_gnss_ros.detection.select import load_detector
from aerial_gnss_ros.nodes.memory import keep_freed_memory

keep_freed_memory()
detector = load_detector(DetectorConfig(backend="onnxruntime", threads=1))

def look(width, height):
    detector.detect(np.zeros((height, width, 3), np.uint8))

look(640, 360)
for side in (128, 320):
    look(side, side)
before_mb = own_memory_mb(os.getpid())
for _ in range(2):
    look(640, 360)
print(own_memory_mb(os.getpid()) - before_mb)
"""


@pytest.mark.skipif(platform.system() != "Linux", reason="memory is read from /proc")
def test_the_second_image_of_a_size_takes_no_more_memory_than_the_first():
    done = subprocess.run(
        [sys.executable, "-c", _LOOKS], check=True, capture_output=True, text=True, env=os.environ
    )
    assert float(done.stdout) < 5.0
