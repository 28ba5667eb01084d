# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The summary of a replay accounts for every box, in words that a user can act on."""

from __future__ import annotations

import csv
import json
from collections import Counter
from pathlib import Path
from types import SimpleNamespace

from aerial_gnss_ros.bags.replay import Summary
from aerial_gnss_ros.commands.replay_summary import as_json, as_text, folded
from aerial_gnss_ros.core.values.estimates import State
from aerial_gnss_ros.core.values.rejection import Cause


def stray_boxes(flight, counts):
    """Let images show boxes that come once each; count all boxes."""
    boxes = flight.boxes

    def made(stamp):
        found = boxes(stamp)
        index = (stamp - 1_000_000_000_000) // 100_000_000
        if index % 5 == 2:
            far = 40.0 * (index % 4) - 60.0
            found["detections"].append(json.loads(json.dumps(found["detections"][0])))
            found["detections"][-1]["bbox"]["center"]["position"] = {"x": 320.0 + far, "y": 460.0}
        counts["boxes"] += len(found["detections"])
        return found

    flight.boxes = made


def test_every_box_is_used_or_in_rejected_csv(tmp_path, flight, capsys, replay):
    counts = Counter()
    flight.images = 60
    stray_boxes(flight, counts)
    assert replay(flight.write(tmp_path / "bag"), tmp_path / "out", "--json") == 0
    summary = json.loads(capsys.readouterr().out)
    with (tmp_path / "out/rejected.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert summary["boxes"] == counts["boxes"]
    assert summary["boxes"] == summary["boxes_used"] + sum(summary["rejections"].values())
    assert Counter(row["reason"] for row in table) == summary["rejections"]
    assert summary["rejections"]["unconfirmed"] == sum(summary["unconfirmed"].values()) == 12
    stamps = [int(row["stamp_ns"]) for row in table]
    assert stamps == sorted(stamps)
    assert {row["v_px"] for row in table} == {"460.000"}


def test_same_input_gives_the_same_rejections(tmp_path, flight, capsys, replay):
    stray_boxes(flight, Counter())
    bag = flight.write(tmp_path / "bag")
    for name in ("one", "other"):
        assert replay(bag, tmp_path / name) == 0
    tables = [(tmp_path / name / "rejected.csv").read_bytes() for name in ("one", "other")]
    assert tables[0] == tables[1]
    assert b"unconfirmed" in tables[0]
    text = capsys.readouterr().out
    assert "updated robots; refused: 4\n  unconfirmed " in text


def test_the_text_names_likely_causes_the_commonest_first():
    summary = Summary(
        frames=60, boxes=534, used=31, interval_s=1.25,
        rejections=Counter({"gated": 5, "unconfirmed": 498}),
        causes=Counter({Cause.IMAGES_TOO_SELDOM: 98, Cause.OUT_OF_GATE: 400}),
    )  # fmt: skip
    lines = as_text(Path("out"), summary).splitlines()
    assert lines[1] == "boxes: 534, of which 31 updated robots; refused: 503"
    words = [line.split()[0] for line in lines[2:] if line[:5].strip()]
    assert words == ["unconfirmed", "out_of_gate", "images_too_seldom", "gated"]
    text = " ".join(" ".join(lines).split())
    assert "camera.latency_s" in text
    assert "(here one each 1.2 s)" in text
    assert max(map(len, lines)) <= 100


def test_positions_that_are_only_predicted_are_told_apart():
    """The robot of two images is seen in the first only."""
    summary = Summary()
    for state in (State.CONFIRMED, State.COASTING):
        summary.add(
            SimpleNamespace(
                estimates=[SimpleNamespace(robot_id="aqua_1", state=state)],
                boxes=1, used=1, rejections=(), late=(),
            )
        )  # fmt: skip
    lines = as_text(Path("out"), summary).splitlines()
    both = "2 positions, of which 1 coasting"
    assert lines[0] == f"out: 2 images, 1 robot, {both} (predicted, not seen)"
    assert lines[1].split(maxsplit=1) == ["aqua_1", both]
    assert as_json(Path("out"), summary)["coasting"] == {"aqua_1": 1}


def test_nothing_refused_is_one_line():
    assert as_text(Path("out"), Summary(frames=2, boxes=3, used=3)).splitlines()[1:] == [
        "boxes: 3, refused: none"
    ]


def test_sentences_that_differ_in_numbers_are_one():
    notes = ["2 of 3 boxes are off.", "The fix is late.", "9 of 12 boxes are off.", "A 1.5 B"]
    assert folded(notes) == ["2 of 3 boxes are off. (1 more such)", "The fix is late.", "A 1.5 B"]
