# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Makes a detector: train on labelled images, export to ONNX, score on unseen frames."""
