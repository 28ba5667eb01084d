# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Generates and compiles Python message modules without ament and CMake."""
