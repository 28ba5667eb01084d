# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""`aerial-gnss demo --drones`: what it prints is what it wrote."""

from __future__ import annotations

import csv
import json
from types import SimpleNamespace

import numpy as np
import pytest

from aerial_gnss_ros.bags.tables import read_positions
from aerial_gnss_ros.cli import main
from aerial_gnss_ros.commands.demo_drones import comparison


def test_two_drones_are_compared_alone_and_together(tmp_path, capsys):
    arguments = ["--drones", "2", "--duration", "6", "--robots", "2", "-o", str(tmp_path)]
    assert main(["demo", *arguments]) == 0
    out = capsys.readouterr().out
    folder = tmp_path / "demo_001"
    sentence = next(line for line in out.splitlines() if line.startswith("Root mean square error:"))
    assert "a alone" in sentence
    page = (folder / "report.html").read_text()
    assert sentence in page
    assert "Demo: 2 drones over the same robots" in page
    assert "Which drone saw which robot." in page
    assert (folder / "map.png").read_bytes().startswith(b"\x89PNG")
    rows = list(csv.DictReader((folder / "together" / "drones.csv").open()))
    assert {row["drone"] for row in rows} == {"a", "b"}
    assert {*read_positions(folder / "a_alone" / "positions.csv")} == {"aqua_1", "aqua_2"}
    assert out.splitlines()[-1] == f"report: {folder / 'report.html'}"


def test_figures_can_be_had_as_json(tmp_path, capsys):
    arguments = ["--drones", "2", "--duration", "5", "--robots", "1", "-o", str(tmp_path)]
    assert main(["demo", *arguments, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [*found["errors"]] == ["together", "a alone", "b alone"]
    assert found["errors"]["together"]["count"] > 20


def test_the_sentence_compares_with_the_best_one_alone():
    def of(error):
        return [SimpleNamespace(distance=np.full(4, error))]

    def summarise_stub(robots):
        return SimpleNamespace(rmse=float(np.sqrt(np.mean(robots[0].distance ** 2))))

    errors = {"together": of(0.2), "a alone": of(0.5), "b alone": of(0.4)}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("aerial_gnss_ros.commands.demo_drones.summarise", summarise_stub)
        assert comparison(errors) == (
            "Root mean square error: a alone 0.50 m, b alone 0.40 m, together 0.20 m: the best "
            "one alone errs 2.0 times as much."
        )


@pytest.mark.parametrize("count", ["1", "5"])
def test_other_numbers_are_refused(capsys, tmp_path, count):
    assert main(["demo", "--drones", count, "-o", str(tmp_path)]) == 2
    assert f"--drones must lie within 2 to 4, not {count}." in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
