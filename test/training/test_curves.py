# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Curves of a training that was interrupted."""

from __future__ import annotations

import csv
import io

import cv2

from aerial_gnss_ros.training.curves import as_csv, draw_curves, read_epochs


def test_epochs_that_were_repeated_count_once(tmp_path):
    first, second = tmp_path / "first.csv", tmp_path / "second.csv"
    head = "epoch,train/box_loss,metrics/recall(B)\n"
    first.write_text(head + "1,9.0,0.1\n2,8.0,0.2\n2,7.0,0.3\n3,6.0,0.4\n")
    second.write_text("epoch, train/box_loss\n1, 5.0\n")
    rows = read_epochs([first, second, tmp_path / "none.csv"])
    table = list(csv.DictReader(io.StringIO(as_csv(rows))))
    reported = [(row["phase"], row["epoch"], row["train/box_loss"]) for row in table]
    assert reported == [("1", "1", "9.0"), ("1", "2", "7.0"), ("1", "3", "6.0"), ("2", "1", "5.0")]
    draw_curves(rows, tmp_path / "curves.png")
    assert cv2.imread(str(tmp_path / "curves.png")) is not None
