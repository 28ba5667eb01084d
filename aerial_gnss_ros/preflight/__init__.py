# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Checks before a flight: inputs monitored, signs and references tested.

May import core and what lies below it.
"""
