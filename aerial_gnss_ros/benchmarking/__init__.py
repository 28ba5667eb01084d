# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The paper's hardware test: speed of the whole pipeline on this machine."""
