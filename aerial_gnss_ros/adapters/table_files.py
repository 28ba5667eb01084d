# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reads rows of CSV tables; a damaged table is reported in one sentence."""

from __future__ import annotations

import csv
from collections.abc import Iterator, Sequence
from pathlib import Path

from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.text.sentences import cut


def table_rows(
    path: Path, columns: Sequence[str], meant: str
) -> Iterator[tuple[int, dict[str, str]]]:
    """Yield line number and fields of each row; fields missing from a short row are empty.

    Args:
        path: the table, with a header, separated by commas.
        columns: the required columns.
        meant: the kind of file expected, for the error, such as `the positions.csv of a replay`.

    Raises:
        InputError: it cannot be read, is not text, or lacks a column.
    """
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.DictReader(file, restval="")
            missing = [name for name in columns if name not in (reader.fieldnames or ())]
            if missing:
                raise InputError(
                    f"{path} lacks the columns {', '.join(missing)}; it is not {meant}."
                )
            for row in reader:
                yield reader.line_num, row
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}.") from error
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path} is damaged ({cut(str(error))}); it is not {meant}.") from error
