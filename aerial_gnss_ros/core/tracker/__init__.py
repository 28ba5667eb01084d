# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Track management: the life of tracks from the first box over confirmation to the end.

May import the rooms of core up to references.
"""
