# SPDX-License-Identifier: Apache-2.0
"""Simulated flights: motion, sensors, robots; images rendered through the true camera geometry."""
