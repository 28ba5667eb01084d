# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The result of a sign test."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Verdict(str, Enum):
    """Result of a test. LOOK: two explanations fit, and the operator knows which is true."""

    PASS = "pass"  # noqa: S105 - no password
    FAIL = "FAIL"
    LOOK = "look"
    NOT_TESTED = "not tested"

    def __str__(self) -> str:
        return self.value


@dataclass(frozen=True)
class SignTest:
    """One test: its name, what must hold, the verdict and the observation, in words."""

    name: str
    rule: str
    verdict: Verdict
    seen: str
