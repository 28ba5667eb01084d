# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Identity: which label a confirmed track gets, re-identification, and labels in doubt.

May import text and the rooms of core up to association.
"""
