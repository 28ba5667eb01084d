# SPDX-License-Identifier: Apache-2.0
"""Numbers in sentences."""

import pytest

from aerial_gnss_ros.core.words import counted


@pytest.mark.parametrize(
    ("number", "noun", "words"),
    [
        (1, "robot", "1 robot"),
        (3, "robot", "3 robots"),
        (0, "false box", "0 false boxes"),
        (2, "class", "2 classes"),
        (2, "epoch", "2 epochs"),
        (2, "switch", "2 switches"),
    ],
)
def test_a_number_takes_the_noun_with_it(number, noun, words):
    assert counted(number, noun) == words
