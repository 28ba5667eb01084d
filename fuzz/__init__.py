# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Feeds the program damaged input, case by case and repeatably; see README.md."""

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):  # before numpy: one core
    os.environ.setdefault(_name, "1")
