# SPDX-License-Identifier: Apache-2.0
"""GNSS-grade positions of marine robots, seen from a drone."""

import os

# OpenBLAS's threads, woken for small matrices, wait for one another on a busy machine: 60 ms for
# what takes 1 µs on one thread. Read when numpy is first imported; what is set already stays.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

__version__ = "0.1.0"
