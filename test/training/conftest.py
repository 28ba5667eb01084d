# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Pictures that exports are calibrated with and compared on."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def pictures(tmp_path_factory) -> Path:
    """Three rendered crops: enough to see that ranges are taken, not to score."""
    from aerial_gnss_ros.simulation.dataset import DatasetConfig, generate

    folder = tmp_path_factory.mktemp("pictures") / "crops"
    generate(folder, DatasetConfig({"test": 3}, size=(320, 320), seed=2024))
    return folder / "images"
