# SPDX-License-Identifier: Apache-2.0
"""Vehicles' messages and logs in, results out, by attribute only; no ROS import."""
