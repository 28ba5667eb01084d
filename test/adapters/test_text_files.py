# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Text files that are read whole, and those that are refused."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.adapters.text_files import read_text
from aerial_gnss_ros.core.values.errors import InputError


def test_a_file_of_the_greatest_size_is_read_without_its_byte_order_mark(tmp_path):
    path = tmp_path / "a.txt"
    path.write_bytes(b"\xef\xbb\xbf" + b"x" * 7)
    assert read_text(path, 10) == "x" * 7
    with pytest.raises(InputError, match=r"a\.txt: is larger than 9e-06 MB"):
        read_text(path, 9)


@pytest.mark.parametrize(
    ("content", "line"), [(b"\xff", 1), (b"a\nb\nc\xff", 3), ("a\nä".encode("latin-1"), 2)]
)
def test_the_line_that_is_no_text_is_named(tmp_path, content, line):
    path = tmp_path / "a.txt"
    path.write_bytes(content)
    with pytest.raises(InputError, match=rf"a\.txt: is not text in UTF-8 \(line {line}\)"):
        read_text(path, 100)


@pytest.mark.parametrize("name", ["absent.txt", "a\0b", "."])
def test_what_cannot_be_read_is_named(tmp_path, name):
    with pytest.raises(InputError, match="cannot be read: "):
        read_text(tmp_path / name, 100)
