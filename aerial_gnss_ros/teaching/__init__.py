# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Labels of a recording from a few clicks, for a detector of one's own robot."""
