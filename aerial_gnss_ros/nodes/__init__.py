# SPDX-License-Identifier: Apache-2.0
"""ROS 2 nodes: a callback converts, calls the core and publishes; no mathematics here."""
