# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Text for people and for other programs: numbers in sentences, safe characters, JSON.

Imports nothing of this package.
"""
