# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A camera from the EXIF of a photo: the 35 mm focal length is by the diagonal."""

from __future__ import annotations

import json

import pytest
from PIL import Image

from aerial_gnss_ros import cli


def _photo(path, size=(4000, 3000), equivalent=24):
    image = Image.new("RGB", size)
    exif = Image.Exif()
    exif[0x0110] = "FC1"
    if equivalent is not None:
        exif.get_ifd(0x8769)[0xA405] = equivalent
    image.save(path, exif=exif)
    return path


@pytest.mark.parametrize(
    ("size", "focal_px"),
    [
        (None, 24.0 / 43.2666 * 5000.0),  # 4000 x 3000 has a diagonal of 5000 px
        ("1920x1080", 24.0 / 43.2666 * 5000.0 * 1920.0 / 4000.0),
    ],
)
def test_focal_length_by_the_diagonal(tmp_path, capsys, size, focal_px):
    arguments = ["camera", str(_photo(tmp_path / "a.JPG")), "--json"]
    assert cli.main([*arguments, *(["--image-size", size] if size else [])]) == 0
    out = capsys.readouterr().out
    found = json.loads(out)
    assert "EXIF" in out
    assert _focal(found) == pytest.approx(focal_px, rel=1e-4)


def _focal(found):
    """Return the focal length in px, however the report names it."""
    for name, value in found.items():
        if name.startswith(("focal", "fx")):
            return value[0] if isinstance(value, list) else value
    raise AssertionError(sorted(found))


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda p: _photo(p, equivalent=None), "has no focal length in 35 mm"),
        (lambda p: p.write_text("hello"), "is not a readable photo"),
        (lambda _: None, "does not exist"),
    ],
)
def test_photos_that_do_not_help_are_refused(tmp_path, capsys, make, sentence):
    make(tmp_path / "a.jpg")
    assert cli.main(["camera", str(tmp_path / "a.jpg")]) == 2
    assert sentence in capsys.readouterr().err


def test_a_photo_too_large_for_pillow_or_of_another_format_is_refused(tmp_path, capsys):
    header = bytearray(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR" + (30000).to_bytes(4, "big") * 2)
    huge = tmp_path / "a.jpg"
    huge.write_bytes(bytes(header) + b"\x01\0\0\0\0" + bytes(100))
    assert cli.main(["camera", str(huge)]) == 2
    captured = capsys.readouterr()
    assert "is not a readable photo; give a JPEG" in captured.err
    assert "Traceback" not in captured.err
