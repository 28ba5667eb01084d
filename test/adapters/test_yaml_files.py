# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Whatever a YAML file holds: its content, or one short sentence with the file and the line."""

from __future__ import annotations

import json

import pytest

from aerial_gnss_ros import cli
from aerial_gnss_ros.adapters import yaml_files
from aerial_gnss_ros.adapters.camera_files import read_camera_file
from aerial_gnss_ros.adapters.parameter_files import read
from aerial_gnss_ros.adapters.yaml_files import MOST_BYTES, MOST_DEPTH, MOST_NODES, read_yaml
from aerial_gnss_ros.core.config.estimator import EstimatorConfig
from aerial_gnss_ros.core.values.errors import AerialGnssError, InputError
from aerial_gnss_ros.training.layout import open_dataset


def bomb(levels: int, width: int = 9, first: str = "[x]") -> str:
    """A billion laughs: each line stands for `width` times the one above."""
    lines = [f"a0: &a0 {first}"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * width)}]" for i in range(1, levels + 1)]
    return "\n".join(lines) + "\n"


FEW_NODES = 2000
"""Stands for `MOST_NODES`, of which each reader would take two seconds."""
HOSTILE = {
    "aliases": (bomb(12), "aliases counted at every use"),
    "long text behind aliases": (bomb(4, first="x" * 100_000), "exceeded in line 3"),
    "an alias of itself": ("a: 1\nb: &b [1, *b]\n", "alias *b in line 2 contains itself"),
    "an unknown alias": ("a: *nobody\n", "undefined alias 'nobody' in line 1"),
    "a date that is none": ("a: 1\nb: 2001-13-45\n", "'2001-13-45' in line 2 is not a valid ti"),
    "no integer": ("a: !!int abc\n", "'abc' in line 1 is not a valid int"),
    "an empty integer": ("a: !!int ''\n", "'' in line 1 is not a valid int"),
    "no truth": ("a: !!bool abc\n", "'abc' in line 1 is not a valid bool"),
    "no time": ("a: !!timestamp abc\n", "'abc' in line 1 is not a valid timestamp"),
    "base 64": ("a: !!binary é\n", "in line 1"),
    "5,000 digits": ("a: " + "9" * 5000 + "\n", "in line 1 is not a valid int"),
    "a hexadecimal giant": ("a: 0x" + "f" * 5000 + "\n", "in line 1 is not a valid int"),
    "deep": ("a:\n  " + "[" * 3000, f"line 2 is nested deeper than {MOST_DEPTH} levels"),
    "deep blocks": ("\n".join(" " * i + "a:" for i in range(500)), "nested deeper than"),
    "deep and closed": ("[" * 3000 + "]" * 3000, "nested deeper than"),
    "many": ("a: [" + "1, " * (FEW_NODES + 1) + "]", f"more than {FEW_NODES} values"),
    "large": ("a: " + "x" * MOST_BYTES, "is larger than 1 MB"),
    "a key twice": ("a: 1\nb: 2\na: 3\n", "a is given twice (line 3)"),
    "a list for a key": ("? [1, 2]\n: 3\n", "not [1, 2] in line 1"),
    "a key without end": ("a" * 1000 + ": 1\n", "at most 256 characters"),
    "python": ("a: !!python/object/apply:os.system ['true']\n", "in line 1"),
    "two documents": ("a: 1\n---\nb: 2\n", "in line 2"),
    "NUL": ("a: 1\nb: \0\n", "'\\x00' is not allowed in line 2"),
    "not UTF-8": (b"a: 1\n\nb: \xff\n", "is not text in UTF-8 (line 3)"),
    "UTF-16": ("a: 1".encode("utf-16"), "is not text in UTF-8 (line 1)"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_file_is_one_short_sentence(tmp_path, monkeypatch, name):
    monkeypatch.setattr(yaml_files, "MOST_NODES", FEW_NODES if name == "many" else MOST_NODES)
    content, words = HOSTILE[name]
    path = tmp_path / "p.yaml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError) as caught:
        read_yaml(path)
    sentence = str(caught.value)
    assert words in sentence
    assert sentence.startswith(f"{path}: ")
    assert "\n" not in sentence
    assert len(sentence) < len(str(path)) + 300
    # Wherever YAML is read, the answer is the same: parameters, a camera, a data set.
    for reader in (
        lambda: read([path], {"estimator": EstimatorConfig}),
        lambda: read_camera_file(path),
        lambda: open_dataset(path),
    ):
        with pytest.raises(AerialGnssError) as refused:
            reader()
        assert len(str(refused.value)) < len(str(path)) + 700


def test_what_yaml_says_is_read(tmp_path):
    path = tmp_path / "p.yaml"
    path.write_text("\ufeffa: &a [1, 2.5e-3, 1e3]\nb: *a\n0: {c: true, d: ~}\n", encoding="utf-8")
    listed = [1, 0.0025, 1000.0]
    assert read_yaml(path) == {"a": listed, "b": listed, 0: {"c": True, "d": None}}
    path.write_text("a: 1\n---\nb: [\n")
    assert read_yaml(path, first=True) == {"a": 1}
    path.write_text("")
    assert read_yaml(path) is None
    assert read_yaml(path, first=True) is None


def test_bounds_leave_room_for_what_is_not_hostile(tmp_path):
    path = tmp_path / "p.yaml"
    deepest = MOST_DEPTH - 1  # the number itself is one more
    path.write_text("[" * deepest + "1" + "]" * deepest)
    assert json.dumps(read_yaml(path)) == path.read_text()
    path.write_text("[" + "1, " * (MOST_NODES - 2) + "1]")
    assert len(read_yaml(path)) == MOST_NODES - 1


@pytest.mark.parametrize("value", ["1" + "0" * 400, "{a: &a [1], b: [*a, *a]}", "'" + "x" * 5000])
def test_a_wrong_value_is_shown_in_part(tmp_path, capsys, value):
    path = tmp_path / "p.yaml"
    path.write_text(f"max_wait: {value}\n")
    bag = tmp_path / "none.mcap"
    assert cli.main(["replay", str(bag), "-o", str(tmp_path / "out"), "--params", str(path)]) == 2
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1
    assert len(said) < 600
    assert str(path) in said
