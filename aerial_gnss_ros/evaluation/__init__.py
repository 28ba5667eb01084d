# SPDX-License-Identifier: Apache-2.0
"""Results against truth: errors, map, report."""
