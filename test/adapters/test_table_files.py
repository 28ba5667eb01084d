# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tables that were damaged or are something else: a sentence with the file's name."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.adapters.table_files import table_rows
from aerial_gnss_ros.bags.tables import POSITION_COLUMNS, read_positions, read_rejections
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.evaluation.platform import read_platform
from aerial_gnss_ros.evaluation.truth import read_truth_csv
from aerial_gnss_ros.training.labelled import read_folder

HEAD = ",".join(POSITION_COLUMNS)


def test_rows_come_with_their_lines(tmp_path):
    path = tmp_path / "t.csv"
    path.write_bytes('\ufeffa,b\r\n1,"x\ny"\r\n2\r\n'.encode())
    assert list(table_rows(path, ("a", "b"), "a test's")) == [
        (3, {"a": "1", "b": "x\ny"}),
        (4, {"a": "2", "b": ""}),
    ]


def read_meta(path):
    (path / "images" / "val").mkdir(parents=True)
    (path / "images" / "val" / "a.png").touch()
    return list(read_folder(path, "val"))


READERS = {
    "positions.csv": lambda folder: read_positions(folder / "positions.csv"),
    "rejected.csv": lambda folder: read_rejections(folder / "rejected.csv"),
    "platform.csv": lambda folder: read_platform(folder / "platform.csv"),
    "truth.csv": lambda folder: read_truth_csv(folder / "truth.csv"),
    "meta.csv": read_meta,
}


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xff\xfe\x00",
        b"a,b\n1,2\n",
        b"\0" * 100,
        b"9" * 200_000,
        b'"' + b"x," * 200_000,
        HEAD.encode() + b"\n\xff\n",
    ],
    ids=["empty", "UTF-16", "other", "NUL", "long", "quote", "latin"],
)
def test_what_is_no_table_is_refused(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError) as refused:
        READERS[name](tmp_path)
    assert str(tmp_path / name) in str(refused.value)
    assert "\n" not in str(refused.value)
    assert len(str(refused.value)) < len(str(tmp_path)) + 400
