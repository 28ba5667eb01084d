# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Stamps and headers of messages."""

from __future__ import annotations

from types import SimpleNamespace

from hypothesis import given
from hypothesis import strategies as st

from aerial_gnss_ros.adapters.stamps import copied_header, header_fields, nanoseconds, stamp_fields


@given(st.integers(0, 2**63 - 1))
def test_a_stamp_is_exact_to_the_nanosecond_and_its_parts_are_in_range(stamp_ns):
    fields = stamp_fields(stamp_ns)
    assert 0 <= fields["nanosec"] < 1_000_000_000
    assert nanoseconds(SimpleNamespace(**fields)) == stamp_ns


def test_a_header_is_copied_as_it_is():
    stamp = SimpleNamespace(sec=1_700_000_000, nanosec=7)
    copied = copied_header(SimpleNamespace(stamp=stamp, frame_id="camera"))
    assert copied == header_fields(1_700_000_000_000_000_007, "camera")
    assert copied == {"stamp": {"sec": 1_700_000_000, "nanosec": 7}, "frame_id": "camera"}
