# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Identity: labels of confirmed tracks, re-identification, ambiguous labels.

May import text and the rooms of core up to association.
"""
