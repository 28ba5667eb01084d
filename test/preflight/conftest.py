# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The simulated sea of the tests of core, for checks before a flight as well."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

_SPEC = importlib.util.spec_from_file_location(
    "sea_of_core", Path(__file__).parents[1] / "core" / "conftest.py"
)
assert _SPEC
assert _SPEC.loader
_module = sys.modules.setdefault(_SPEC.name, importlib.util.module_from_spec(_SPEC))
_SPEC.loader.exec_module(_module)
sea = _module.sea
