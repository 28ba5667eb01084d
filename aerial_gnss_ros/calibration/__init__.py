# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Estimation of the platform's constant errors from a whole recording."""
