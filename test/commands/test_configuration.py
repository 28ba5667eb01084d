# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Errors in parameters name the files that give them."""

from __future__ import annotations

import argparse

import pytest

from aerial_gnss_ros.commands.configuration import add_arguments, configuration
from aerial_gnss_ros.core.values.errors import ConfigError


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("classes: {aqua: {max_sped: 2}}", "classes.aqua.max_sped is not a parameter; did you"),
        ("robots: {a: {class: x, start: [100, 2]}}", "robots.a.start [100, 2] is not on Earth."),
        ("references: {pier: {colour: red}}", "references.pier.colour is not a parameter; ref"),
        ("camera: {source: parameters}", "camera.source is parameters, so camera.focal_length"),
    ],
)
def test_the_file_that_gives_the_group_of_a_wrong_value_is_named(tmp_path, text, sentence):
    other, wrong = tmp_path / "other.yaml", tmp_path / "wrong.yaml"
    other.write_text("fix: {max_gap: 2.0}")
    wrong.write_text(text)
    parser = argparse.ArgumentParser()
    add_arguments(parser)
    args = parser.parse_args(["--params", str(wrong), "--params", str(other)])
    with pytest.raises(ConfigError) as refused:
        configuration(args)
    assert str(refused.value).startswith(f"{wrong}: {sentence}")
