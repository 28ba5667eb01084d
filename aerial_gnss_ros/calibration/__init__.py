# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Constant errors of the platform from a whole recording, by least squares."""
