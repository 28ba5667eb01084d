# SPDX-License-Identifier: Apache-2.0
"""GNSS-grade positions of marine robots, seen from a drone."""

__version__ = "0.1.0"
