# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""From an image to boxes: message decoding, the Detector protocol and its back ends."""
