# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Fault detection: inconsistency, a rotating camera, GNSS jumps, frozen inputs, manoeuvres.

May import the rooms of core up to models.
"""
