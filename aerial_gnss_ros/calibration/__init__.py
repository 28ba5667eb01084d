# SPDX-License-Identifier: Apache-2.0
"""Constant errors of the platform from a whole recording, by least squares."""
