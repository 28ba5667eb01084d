# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Arrays of a TensorFlow.js model are read as stored, or scaled; half a file is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.training.tfjs_weights import read_tfjs_weights


@pytest.fixture
def model(tmp_path):
    """Three arrays in two files: of float32, in 8 bits, and a single number."""
    first = np.float32([[1.5, -2.0], [0.25, 8.0]]).tobytes() + bytes([0, 255, 10])
    (tmp_path / "a.bin").write_bytes(first[:10])  # an array goes on in the next file
    (tmp_path / "b.bin").write_bytes(first[10:] + np.int32([7]).tobytes())
    coded = {"dtype": "uint8", "scale": 0.5, "min": -3.0}
    weights = [
        {"name": "plain", "shape": [2, 2], "dtype": "float32"},
        {"name": "coded", "shape": [3], "dtype": "float32", "quantization": coded},
        {"name": "one", "shape": [], "dtype": "int32"},
    ]
    path = tmp_path / "model.json"
    path.write_text(
        json.dumps({"weightsManifest": [{"paths": ["a.bin", "b.bin"], "weights": weights}]})
    )
    return path


def test_it_reads_each_array_as_stored(model):
    found = read_tfjs_weights(model)
    np.testing.assert_array_equal(found["plain"], [[1.5, -2.0], [0.25, 8.0]])
    np.testing.assert_allclose(found["coded"], [-3.0, 124.5, 2.0])
    assert found["coded"].dtype == np.float32
    assert found["one"] == 7
    assert found["one"].shape == ()


@pytest.mark.parametrize("length", [0, 5, 12])
def test_a_file_of_another_length_is_refused(model, length):
    (model.parent / "b.bin").write_bytes(bytes(length))
    with pytest.raises(ModelError, match=r"model.json is not a whole TensorFlow.js model"):
        read_tfjs_weights(model)


@pytest.mark.parametrize("content", ["", "[]", "{}", '{"weightsManifest": [{}]}'])
def test_what_is_no_model_is_refused(tmp_path, content):
    path = tmp_path / "other.json"
    path.write_text(content)
    with pytest.raises(ModelError, match=r"give its \.json file"):
        read_tfjs_weights(path)
    with pytest.raises(ModelError, match="missing"):
        read_tfjs_weights(tmp_path / "missing.json")
