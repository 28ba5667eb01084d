# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A taught network: it learns classes, and goes on where it was killed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import OutputError
from aerial_gnss_ros.detection.second_look import SecondLook
from aerial_gnss_ros.detection.select import find_model
from aerial_gnss_ros.detection.taught import TERMS
from aerial_gnss_ros.training.proposals import Proposals
from aerial_gnss_ros.training.share import Share
from aerial_gnss_ros.training.taught_examples import Examples

pytestmark = pytest.mark.ultralytics
torch = pytest.importorskip("torch", reason="needs the extra [training]")
ROBOTS = replace(TERMS, class_names=("red", "blue"))


def _examples(seed: int, count: int = 240) -> Examples:
    """Squares: red and blue ones are robots of two classes, green ones are none."""
    rng = np.random.default_rng(seed)
    kinds = rng.integers(-1, 2, count)
    views = rng.integers(60, 90, (count, 80, 80, 6), dtype=np.uint8)
    for view, kind in zip(views, kinds, strict=True):
        channel = {0: 2, 1: 0, -1: 1}[int(kind)]
        view[24:56, 24:56, [channel, channel + 3]] = 220
    flat = Proposals(
        views, np.zeros((count, 3), np.float32), np.full(count, 0.5), kinds >= 0, np.ones(count)
    )
    return Examples(flat, (kinds[:, None] == np.arange(2)).astype(np.float32))


def _nothing(_step: int) -> None: ...


def test_it_tells_classes_and_others_apart(tmp_path):
    from aerial_gnss_ros.training.second_look_network import write
    from aerial_gnss_ros.training.second_look_network_taught import fit_taught

    network = fit_taught(_examples(1), ROBOTS, 75, 1, tmp_path / "s.pt", _nothing, 1)
    write(network, ROBOTS, Share(), tmp_path / "mine.onnx")
    second = SecondLook(tmp_path / "mine.onnx", 1)
    assert second.terms == ROBOTS
    other = _examples(3, 60)
    scores = second.run(other.proposals.views[:, 8:72, 8:72], other.proposals.traits)
    assert (scores[other.wanted > 0] > 0.5).mean() > 0.95
    assert (scores[other.wanted == 0] < 0.5).mean() > 0.95


@pytest.mark.parametrize("stated", [False, True])
def test_it_starts_from_the_first_layers_of_the_shipped_second_look_or_another(tmp_path, stated):
    from aerial_gnss_ros.training import second_look_network_pretrained as pretrained
    from aerial_gnss_ros.training.second_look_network import write
    from aerial_gnss_ros.training.second_look_network_taught import fit_taught

    start = tmp_path / "other.onnx" if stated else find_model("aqua_yolo11n_second_look.onnx")
    if stated:
        write(pretrained.PretrainedNetwork().eval(), TERMS, Share(), start)
    given = start if stated else None
    begun = fit_taught(_examples(1, 40), ROBOTS, 0, 1, tmp_path / "s.pt", _nothing, 1, given)
    known = pretrained.read(start).backbone.state_dict()
    for name, value in begun.backbone.state_dict().items():
        torch.testing.assert_close(value, known[name], rtol=0.0, atol=0.0)


def test_killed_it_goes_on_to_the_same_network(tmp_path, monkeypatch):
    from aerial_gnss_ros.training import second_look_network_taught as taught

    monkeypatch.setattr(taught, "_STORED_EVERY", 2)

    def killed(step: int) -> None:
        if step == 3:
            raise KeyboardInterrupt

    arguments = (_examples(1, 40), ROBOTS, 5, 5)
    whole = taught.fit_taught(*arguments, tmp_path / "whole.pt", _nothing, 1).state_dict()
    with pytest.raises(KeyboardInterrupt):
        taught.fit_taught(*arguments, tmp_path / "part.pt", killed, 1)
    steps: list[int] = []
    again = taught.fit_taught(*arguments, tmp_path / "part.pt", steps.append, 1).state_dict()
    assert steps == [2, 3, 4, 5]
    for name, value in whole.items():
        torch.testing.assert_close(again[name], value, rtol=0.0, atol=0.0)


def test_a_state_that_cannot_be_written_is_said(tmp_path, monkeypatch):
    from aerial_gnss_ros.training import second_look_network_taught as taught

    monkeypatch.setattr(taught, "_STORED_EVERY", 1)
    with pytest.raises(OutputError, match=r"s.pt cannot be written"):
        taught.fit_taught(
            _examples(1, 40), ROBOTS, 1, 1, tmp_path / "none" / "s.pt", _nothing, 1
        )  # fmt: skip
