# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Camera models: from pixel to ray and back, lens distortion, and cameras known by name.

May import values, numerics and geometry.
"""
