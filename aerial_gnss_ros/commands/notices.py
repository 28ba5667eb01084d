# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Sentences on standard error; standard output is for results."""

from __future__ import annotations

import sys


def say(sentence: str) -> None:
    """Print what a command does."""
    print(sentence, file=sys.stderr, flush=True)


def note(sentence: str) -> None:
    """Print what its user should know, with the program's name."""
    say(f"aerial-gnss: {sentence}")
