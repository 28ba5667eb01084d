# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Values that pass between the parts: samples, boxes, estimates, refusals, events and errors.

Imports nothing of this package.
"""
