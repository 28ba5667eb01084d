# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A recording by time, and which overviews of a bag are shown."""

from __future__ import annotations

import json
import runpy
from pathlib import Path

import pytest

from aerial_gnss_ros.bags.drone_tables import DRONE_COLUMNS
from aerial_gnss_ros.bags.reader import open_bag
from aerial_gnss_ros.bags.tables import POSITION_COLUMNS
from aerial_gnss_ros.bags.writer import LATCHED, BagWriter
from aerial_gnss_ros.core.values.errors import InputError
from aerial_gnss_ros.view.recording import Recording, recorded_overviews, tabled_overviews

MADE = runpy.run_path(str(Path(__file__).with_name("overviews.py")))
BEGIN, SECOND, overview, robot = (MADE[name] for name in ("BEGIN", "SECOND", "overview", "robot"))


def recording():
    times = {0.0: ["a"], 1.0: ["a", "b"], 2.0: ["b"], 10.0: ["b"]}
    texts = [
        json.dumps(overview(t, *(robot(name, t) for name in names))) for t, names in times.items()
    ]
    return Recording(texts[::-1], "flight")


@pytest.mark.parametrize(
    ("at", "stamp", "states"),
    [
        (0.0, 0.0, {"a": "confirmed"}),
        (0.9, 0.0, {"a": "confirmed"}),
        (1.0, 1.0, {"a": "confirmed", "b": "confirmed"}),
        (9.0, 2.0, {"a": "lost", "b": "confirmed"}),
        (99.0, 10.0, {"a": "lost", "b": "confirmed"}),
        (-5.0, 0.0, {"a": "confirmed"}),
    ],
)
def test_what_was_known_at_a_time_is_shown(at, stamp, states):
    scene = recording().at(at)
    assert scene["stamp_ns"] == BEGIN + round(stamp * SECOND)
    assert {one["id"]: one["state"] for one in scene["robots"]} == states


def test_a_gap_is_told_as_silence():
    scene = recording().at(9.0)
    assert scene["silent_s"] == pytest.approx(7.0)
    assert scene["now_ns"] == BEGIN + 9 * SECOND


def test_the_page_learns_length_and_paths_at_the_beginning():
    hello = recording().hello()
    assert (hello["begin_ns"], hello["end_ns"]) == (BEGIN, BEGIN + 10 * SECOND)
    assert sorted(hello["paths"]) == ["a", "b"]
    assert len(hello["drone_path"]) == 4
    assert hello["live"] is False


def test_it_opens_where_the_first_robot_is():
    texts = [json.dumps(overview(t, *([robot("a", t)] if t > 2.0 else []))) for t in range(6)]
    assert Recording(texts, "flight").opening_s == 3.0
    assert Recording(texts[:2], "flight").opening_s == 0.0


def test_without_any_image_there_is_nothing_to_show():
    with pytest.raises(InputError, match="nothing to show"):
        Recording([], "empty")


def bag_with(folder, *topics, msgtype="std_msgs/msg/String"):
    with BagWriter(folder / "bag") as bag:
        for topic in topics:
            bag.write(topic, msgtype, BEGIN, {"data": topic}, LATCHED)
    return open_bag(folder / "bag")


def test_the_overviews_of_the_only_estimator_are_found(tmp_path):
    with bag_with(tmp_path, "drone1/overview", "other") as bag:
        assert recorded_overviews(bag, "") == ["drone1/overview"]
        assert recorded_overviews(bag, "drone1") == ["drone1/overview"]
        assert recorded_overviews(bag, "drone2") is None


def test_with_two_drones_one_must_be_chosen(tmp_path):
    with bag_with(tmp_path, "drone1/overview", "drone2/overview") as bag:
        with pytest.raises(InputError, match=r"/drone1/overview, /drone2/overview; .*--namespace"):
            recorded_overviews(bag, "")
        assert recorded_overviews(bag, "/drone2") == ["drone2/overview"]


def test_a_bag_without_overviews_has_none(tmp_path):
    with bag_with(tmp_path, "my_overview") as bag:
        assert recorded_overviews(bag, "") is None


def test_a_table_of_a_fleet_shows_each_drone_where_it_was_last(tmp_path):
    half = SECOND // 2
    robots = [
        f"{BEGIN + k * SECOND // 10},a,aqua,13.0,-59.0,0,1,0,1,0,0,confirmed" for k in range(8)
    ]
    (tmp_path / "positions.csv").write_text("\n".join([",".join(POSITION_COLUMNS), *robots]))
    rows = [
        f"{BEGIN + k * half},{name},1,1,0,0,1,1,0,,{13.5 + k},-59.5,{sees}"
        for k, name, sees in ((0, "a", "a"), (1, "a", ""), (1, "b", "a"))
    ]
    (tmp_path / "drones.csv").write_text("\n".join([",".join(DRONE_COLUMNS), *rows]))
    texts = [json.loads(text) for text in tabled_overviews(tmp_path / "positions.csv")]
    (first,), (_, last) = texts[4]["drones"], texts[5]["drones"]
    assert (first["name"], first["place"], first["sees"]) == ("a", [13.5, -59.5], ["a"])
    assert (last["name"], last["place"], last["sees"]) == ("b", [14.5, -59.5], ["a"])
    assert [one["sees"] for one in texts[7]["drones"]] == [[], ["a"]]
    (tmp_path / "drones.csv").unlink()
    assert "drones" not in json.loads(tabled_overviews(tmp_path / "positions.csv")[0])
