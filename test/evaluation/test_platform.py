# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Errors of the platform: as a table and as a picture."""

from __future__ import annotations

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.evaluation import picture
from aerial_gnss_ros.evaluation.platform import PlatformError, platform_png, read_platform


@pytest.mark.parametrize("row", ["1,2,nan,1", "99999999999999999999,a,1,1", "1,a,1,1e999"])
def test_a_platform_error_that_is_none_is_refused(tmp_path, row):
    path = tmp_path / "platform.csv"
    path.write_text(f"stamp_ns,error,value,sigma\n5,a,1,1\n{row}\n")
    with pytest.raises(InputError, match=r"platform\.csv, line 3"):
        read_platform(path)


def test_errors_are_read_by_name_and_an_absent_table_holds_none(tmp_path):
    assert read_platform(tmp_path / "platform.csv") == {}
    path = tmp_path / "platform.csv"
    path.write_text(
        "stamp_ns,error,value,sigma\n5,heading,0.1,0.2\n5,height,1,2\n6,heading,0.3,0.1\n"
    )
    found = read_platform(path)
    assert list(found) == ["heading", "height"]
    heading = found["heading"]
    assert heading.stamps_ns.tolist() == [5, 6]
    assert (heading.value.tolist(), heading.sigma.tolist()) == ([0.1, 0.3], [0.2, 0.1])


def test_each_estimated_error_has_a_panel_in_its_unit(monkeypatch):
    """Angles are drawn in degrees; what is not estimated is left out."""
    drawn = []
    monkeypatch.setattr(picture, "png", lambda figure: drawn.append(figure) or b"")
    stamps, ramp = np.array([0, 10**9]), np.array([0.0, 0.1])
    errors = {
        "heading": PlatformError(stamps, ramp, ramp + 0.01),
        "gnss_east": PlatformError(stamps, ramp, ramp + 0.01),
        "latency": PlatformError(stamps, ramp, ramp + 0.01),
        "pitch": PlatformError(stamps, ramp, np.zeros(2)),
    }
    platform_png(errors)
    panels = [axes for axes in drawn[0].axes if axes.get_visible()]
    assert [(axes.get_title("left"), axes.get_ylabel()) for axes in panels] == [
        ("Heading", "correction (deg)"),
        ("GNSS offset, East", "correction (m)"),
        ("Latency of the images", "correction (s)"),
    ]
    ends = [axes.lines[0].get_ydata()[-1] for axes in panels]
    assert ends == pytest.approx([np.degrees(0.1), 0.1, 0.1])
    assert panels[0].lines[0].get_xdata().tolist() == [0.0, 1.0]
