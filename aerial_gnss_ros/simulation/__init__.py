# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Simulated flights: motion, sensors, robots; images rendered through the true camera geometry."""
