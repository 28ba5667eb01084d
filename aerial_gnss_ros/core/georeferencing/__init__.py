# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From boxes in pixels to points on the water with their covariance, or a typed refusal.

May import the rooms of core up to telemetry.
"""
