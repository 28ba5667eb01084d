# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Searching in parts of an image needs a network that takes them."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.config import detector_config
from aerial_gnss_ros.detection.search import searching

_BLOBS = runpy.run_path(str(Path(__file__).with_name("blobs.py")))


BlobDetector, boxes, sea = (_BLOBS[name] for name in ("BlobDetector", "boxes", "sea"))


@pytest.mark.parametrize("mode", ["tiles", "roi"])
def test_a_model_for_one_size_is_refused(mode):
    inner = BlobDetector()
    inner.fixed_size = (1280, 736)
    with pytest.raises(ModelError, match=r"1280x736 only, and search\.mode"):
        searching(inner, detector_config({"search": {"mode": mode}}))
    assert searching(inner, detector_config({})) is inner
