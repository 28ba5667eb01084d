# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Numerics for small arrays: planar Gaussians, row-wise formulas, contiguous columns.

May import values.
"""
