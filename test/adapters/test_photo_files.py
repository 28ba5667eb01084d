# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What a photo says of its own camera."""

from __future__ import annotations

import pytest
from PIL import Image

from aerial_gnss_ros.adapters.photo_files import Photo, read_photo
from aerial_gnss_ros.core.values.errors import InputError


def photo(path, equivalent, model="FC1"):
    """Write a photo of 64 x 48 px."""
    exif = Image.Exif()
    exif[0x0110] = model
    if equivalent is not None:
        exif.get_ifd(0x8769)[0xA405] = equivalent
    Image.new("RGB", (64, 48)).save(path, format="JPEG", exif=exif)
    return path


def test_size_focal_length_and_model_are_read(tmp_path):
    found = read_photo(photo(tmp_path / "a.jpg", 24, "FC1\0 "))
    assert found == Photo((64, 48), 24.0, "FC1")


@pytest.mark.parametrize("equivalent", [None, 0])
def test_a_photo_without_a_focal_length_is_refused(tmp_path, equivalent):
    with pytest.raises(InputError, match=r"EXIF of .*a\.jpg has no focal length in 35 mm"):
        read_photo(photo(tmp_path / "a.jpg", equivalent))


def test_what_is_no_photo_is_refused(tmp_path):
    with pytest.raises(InputError, match="does not exist; give a photo"):
        read_photo(tmp_path / "absent.jpg")
    Image.new("RGB", (64, 48)).save(tmp_path / "a.jpg", format="PNG")
    with pytest.raises(InputError, match="is not a readable photo"):
        read_photo(tmp_path / "a.jpg")
    damaged = photo(tmp_path / "b.jpg", 24)
    damaged.write_bytes(damaged.read_bytes()[:20])
    with pytest.raises(InputError, match="is not a readable photo"):
        read_photo(damaged)
