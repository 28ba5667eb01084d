# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The estimator's parameters: dataclasses with default, unit, range, meaning and consequence.

May import text and the rooms of core up to camera.
"""
