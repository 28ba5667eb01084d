# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Telemetry: admission of samples, their buffers, and the camera's pose at a scene's time.

May import text and the rooms of core up to config.
"""
