# SPDX-License-Identifier: Apache-2.0
"""From an image to boxes: message decoding, the Detector protocol and its back ends."""
