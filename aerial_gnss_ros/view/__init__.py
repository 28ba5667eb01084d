# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Web pages without an internet: a small server, and what `aerial-gnss view` shows with it."""
