# SPDX-License-Identifier: Apache-2.0
"""Makes a detector: train on labelled images, export to ONNX, score on unseen frames."""
