# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The fuzzer finds what is planted, counts it by its kind, and repeats a case by its number."""

from __future__ import annotations

import subprocess
import sys
import time

import pytest

from fuzz import __main__ as command
from fuzz import engine


class Planted:
    """Fails by chance, as requested; a block's state shows whether cases follow one another."""

    name, weight, block = "planted", 1, 10

    def __init__(self, fault=lambda *_: None):
        self.fault, self.seen, self.count, self.blocks = fault, [], 0, []

    def begin(self, block, rng):
        self.count = 0
        self.blocks.append((block, rng.random()))

    def case(self, rng, report):
        self.count += 1
        value = rng.random()
        self.seen.append((self.count, value))
        report(f"{value}")
        self.fault(value, self.count)


def _raise(value, count):
    if value > 0.9:
        raise ValueError(f"{value} after {count}")


def _numbers(tally):
    return [finding.case for finding in tally.findings]


def test_a_planted_exception_is_found_and_repeated_alone():
    tally = engine.run(Planted(_raise), 1, 0, 200)
    assert tally.cases == 200
    assert 5 < tally.count(engine.EXCEPTION) == len(tally.findings) < 40
    for finding in tally.findings[:3]:
        shown = []
        alone = engine.run(Planted(_raise), 1, finding.case, 1, shown.append)
        assert alone.findings == [finding]
        assert alone.cases == 1
        assert shown[-1] == f"{finding.case}: {finding.words.split(' | ')[0]}"
        assert len(shown) == finding.case % 10 + 1
    assert "ValueError" in tally.findings[0].where
    assert "_raise" in tally.findings[0].trace
    assert len(tally.causes) == 1


def test_pieces_of_a_run_find_what_the_whole_finds():
    whole = _numbers(engine.run(Planted(_raise), 1, 0, 100))
    pieces = [_numbers(engine.run(Planted(_raise), 1, first, 25)) for first in (0, 25, 50, 75)]
    assert whole == [number for piece in pieces for number in piece]
    assert whole != _numbers(engine.run(Planted(_raise), 2, 0, 100))


def test_cases_of_a_block_follow_one_another_until_something_is_found():
    target = Planted(_raise)
    engine.run(target, 1, 0, 30)
    expected, count = [], 0
    for i, (_, value) in enumerate(target.seen):
        count = 1 if i % 10 == 0 else count + 1
        expected.append(count)
        count = 0 if value > 0.9 else count
    assert [count for count, _ in target.seen] == expected
    assert len({start for _, start in target.blocks}) == 3  # the same start again after a finding


def test_a_hang_ends(monkeypatch):
    monkeypatch.setattr(engine, "HANG_S", 0.2)

    def spin(_value, _count):
        while True:
            pass

    tally = engine.run(Planted(spin), 1, 0, 2)
    assert tally.count(engine.HANG) == 2
    monkeypatch.setattr(engine, "HANG_S", 5.0)
    monkeypatch.setattr(engine, "STUCK_S", 0.2)
    assert engine.run(Planted(lambda *_: time.sleep(5.0)), 1, 0, 1).count(engine.HANG) == 1


def test_memory_and_broken_rules_are_distinguished(monkeypatch):
    monkeypatch.setattr(engine, "MEMORY_BYTES", 0)
    held = []
    grow = Planted(lambda *_: held.append(b"x" * 400_000_000))
    assert engine.run(grow, 1, 0, 1).count(engine.MEMORY) == 1
    held.clear()

    def wrong(*_):
        raise engine.Broken(engine.WRONG, "off: by much")

    tally = engine.run(Planted(wrong), 1, 0, 1)
    assert [(f.kind, f.where) for f in tally.findings] == [(engine.WRONG, "off")]


def test_the_command_says_how_to_repeat_and_ends_with_1(monkeypatch, capsys):
    monkeypatch.setattr(command, "all_targets", lambda: [Planted(_raise)])
    monkeypatch.setattr(sys, "argv", ["fuzz", "--cases", "50", "--seed", "3"])
    assert command.main() == 1
    printed = capsys.readouterr().out
    assert "planted | 50 | " in printed
    repeat = next(line for line in printed.splitlines() if "python -m fuzz" in line)
    monkeypatch.setattr(sys, "argv", repeat.split()[2:])
    assert command.main() == 1
    assert "ValueError" in capsys.readouterr().out
    monkeypatch.setattr(command, "all_targets", lambda: [Planted()])
    monkeypatch.setattr(sys, "argv", ["fuzz", "--cases", "50"])
    assert command.main() == 0


@pytest.mark.parametrize("words", [["--only", "nothing"], ["--case", "3"]])
def test_what_cannot_be_run_is_reported(repository, words):
    done = subprocess.run(
        [sys.executable, "-m", "fuzz", *words], cwd=repository, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert "messages" in done.stderr
