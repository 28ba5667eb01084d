# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The words of refusals are those of the design, and only those."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.core.values.rejection import Input, Reason


def test_the_designs_words_are_there():
    words = {
        "above_horizon", "out_of_range", "outside_calibrated_image", "no_camera_info", "no_fix",
        "no_attitude", "no_gimbal", "no_height", "gated", "low_score", "wrong_class",
        "too_fast", "unconfirmed", "internal", "outside_area", "wrong_size",
    }  # fmt: skip
    families = [f"{kind}_{source}" for kind in ("stale", "gap", "bad") for source in Input]
    rest = {str(reason) for reason in Reason} - words - set(families)
    assert rest == {"bad_camera_info", "bad_detections"}  # bad_<input> for inputs without a series
    assert {str(reason) for reason in Reason} >= words | set(families)


def test_every_reason_is_explained():
    meanings = {reason.meaning for reason in Reason}
    assert len(meanings) == len(Reason)
    assert "before the recording ended" in Reason.STALE_FIX.meaning
    assert Reason.GAP_HEIGHT.meaning == "height has a gap longer than max_gap here"


@pytest.mark.parametrize("source", list(Input))
def test_each_input_has_its_reasons(source):
    assert str(Reason.no(source)) == f"no_{source}"
    assert str(Reason.stale(source)) == f"stale_{source}"
    assert str(Reason.gap(source)) == f"gap_{source}"
    assert str(Reason.bad(source)) == f"bad_{source}"
