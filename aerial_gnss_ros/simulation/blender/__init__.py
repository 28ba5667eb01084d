# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A second renderer, with Blender (extra [blender]): slow, physical light, other robots and seas.

Only functions import bpy; every module loads without it.
"""
