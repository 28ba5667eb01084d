# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""GNSS-grade positions of marine robots, seen from a drone."""

import os

# OpenBLAS wakes its threads even for small matrices, and on a busy machine they wait for one
# another far longer than the work takes. Read when numpy is first imported; what is set stays.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

__version__ = "0.1.0"
