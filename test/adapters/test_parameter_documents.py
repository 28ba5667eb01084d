# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Parameter files as they are written: what is in them, and that every reader agrees."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest

from aerial_gnss_ros.adapters.parameter_documents import document, scalar
from aerial_gnss_ros.core.config.schema import key


@pytest.mark.parametrize(
    ("value", "text"),
    [
        ("true", '"true"'),
        ("", '""'),
        ("camera/info", "camera/info"),
        ("a b", '"a b"'),
        (True, "true"),
        (3, "3"),
        (float("nan"), ".nan"),
        ((0.0, 90.0), "[0.0, 90.0]"),
        ((), "[]"),
    ],
)
def test_values_are_written_so_that_every_reader_agrees(value, text):
    assert scalar(value) == text


@dataclass(frozen=True)
class Lens:
    """A lens."""

    zoom: float = key(1.5, "Zoom.", low=1.0, high=9.0, dynamic=True)


@dataclass(frozen=True)
class Seeing:
    """Parameters with a group."""

    model: str = key("yes", "Model.")
    rate: float = key(2.0, "Rate.", unit="Hz", low=0.5)
    lens: Lens = field(default_factory=Lens)


def test_a_document_says_what_each_parameter_means():
    text = document("seeing", Seeing, "a command", "robots:\n\n  a: 1")
    lines = text.splitlines()
    assert lines[0].startswith("# Every parameter of the seeing node with its default.")
    assert lines[lines.index("/**/seeing:") :] == [
        "/**/seeing:",
        "  ros__parameters:",
        '    # Model. [default "yes"]',
        '    model: "yes"',
        "    # Rate. [unit Hz; 0.5 to any; default 2.0]",
        "    rate: 2.0",
        "    # A lens.",
        "    lens:",
        "      # Zoom. [1 to 9; default 1.5; can be changed while running]",
        "      zoom: 1.5",
        "    # robots:",
        "    #",
        "    #   a: 1",
    ]
