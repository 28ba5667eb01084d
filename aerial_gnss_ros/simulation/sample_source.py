# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The renderer of labelled images that a configuration names."""

from __future__ import annotations

from aerial_gnss_ros.core.values.errors import ConfigError
from aerial_gnss_ros.simulation.fast_samples import FastSource
from aerial_gnss_ros.simulation.samples import DatasetConfig, SampleSource

RENDERERS = ("fast", "blender")


def sample_source(config: DatasetConfig) -> SampleSource:
    """Return the renderer that `config` names.

    Raises:
        ConfigError: no renderer of that name, or its extra is not installed.
    """
    if config.renderer == "fast":
        return FastSource(config)
    if config.renderer == "blender":
        from aerial_gnss_ros.simulation.blender.samples import BlenderSource

        return BlenderSource(config)
    raise ConfigError(
        f"there is no renderer {config.renderer!r}; choose one of {', '.join(RENDERERS)}."
    )
