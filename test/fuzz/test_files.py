# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Cases of files: good ones are read, planted faults of parsers and writers are found."""

from __future__ import annotations

import pytest

from aerial_gnss_ros.adapters import dji_srt
from aerial_gnss_ros.core.values.errors import InputError
from fuzz import engine, files, outputs, samples

READERS = {one.name: one for one in files.targets() if isinstance(one, files.Parser)}


@pytest.mark.parametrize(
    ("name", "texts"),
    [
        ("yaml", samples.parameters()[1:8]),  # but anafi's; a mast's own place is to be filled in
        ("camera", samples.CAMERA),
        ("csv", samples.CSV),
        ("srt", samples.SRT),
        ("state", [samples.STATE]),
        ("positions", [samples.POSITIONS]),
        ("drones", [samples.DRONES]),
        ("rejected", [samples.REJECTED]),
    ],
)
def test_good_samples_are_read(tmp_path, name, texts):
    """Else every case would end at the same refusal."""
    for text in texts:
        if "latitude_deg: .nan" in text:
            continue
        path = tmp_path / f"good{READERS[name]._suffix}"
        path.write_text(text, encoding="utf-8")
        READERS[name]._use(path)


def test_a_planted_fault_of_a_parser_is_found(monkeypatch):
    true = dji_srt.position_refusal

    def raises(latitude, longitude):
        return 1 / 0 if latitude == 91.0 else true(latitude, longitude)

    monkeypatch.setattr(dji_srt, "position_refusal", raises)
    found = engine.run(READERS["srt"], 1, 0, 2000).findings
    assert any("ZeroDivisionError in adapters/dji_srt.py" in one.where for one in found)


def test_a_refusal_is_no_finding_but_a_long_one_is():
    files.allowed(lambda: _refuse("a sentence"))
    with pytest.raises(engine.Broken):
        files.allowed(lambda: _refuse("x" * 6000))
    with pytest.raises(ValueError, match="no refusal"):
        files.allowed(lambda: int("no refusal"))


def _refuse(words):
    raise InputError(words)


@pytest.mark.parametrize("text", ["<a>\x07</a>", "<a>&</a>", "<a>"])
def test_what_no_parser_reads_is_found(monkeypatch, text):
    monkeypatch.setattr(outputs, "gpx", lambda _tracks: text)
    assert engine.run(outputs.Written(), 1, 0, 5).count(engine.OUTPUT) == 5
