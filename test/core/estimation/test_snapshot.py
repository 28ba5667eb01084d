# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A snapshot puts back whatever changed, and leaves alone what is excluded."""

from __future__ import annotations

from collections import Counter, deque
from dataclasses import dataclass, field

import numpy as np
import pytest

from aerial_gnss_ros.core.estimation.snapshot import Plans, Snapshot


@dataclass
class Leaf:
    name: str = "leaf"
    values: deque[int] = field(default_factory=lambda: deque([1, 2], maxlen=3))


@dataclass(frozen=True)
class Fixed:
    number: int = 1


class Constant:
    def __init__(self):
        self.number = 1


class Tree:
    def __init__(self):
        self.number, self.maybe, self.fixed = 1, None, Fixed()
        self.array = np.arange(4.0)
        self.view = self.array.reshape(2, 2)
        self.leaf = Leaf()
        self.again = self.leaf
        self.leaves = [Leaf(), Leaf("second")]
        self.by_name = {"a": [np.zeros(2)], "b": [np.ones(2)]}
        self.counts = Counter({"x": 2})
        self.names = {"one"}
        self.constant = Constant()
        self.itself = self


def number(tree):
    tree.number = 7


def no_longer_none(tree):
    tree.maybe = [1]


def array_in_place(tree):
    tree.array[1] = 7.0


def array_replaced(tree):
    old, tree.array = tree.array, tree.array + 1.0
    old[:] = 0.0


def inner(tree):
    tree.leaf.name = "other"
    tree.leaf.values.append(3)
    tree.leaf.values.append(4)


def listed(tree):
    tree.leaves[0].values.clear()
    tree.leaves.append(Leaf("third"))
    tree.leaves.pop(0)


def nested(tree):
    tree.by_name["a"][0] += 1.0
    tree.by_name["a"].append(np.zeros(1))
    del tree.by_name["b"]


def counted(tree):
    tree.counts["x"] += 1
    tree.counts["y"] += 1


def named(tree):
    tree.names |= {"two"}
    tree.names.discard("one")


@pytest.mark.parametrize(
    "change",
    [number, no_longer_none, array_in_place, array_replaced, inner, listed, nested, counted, named],
)
def test_what_changed_is_put_back(change):
    tree, as_it_was = Tree(), Tree()
    held = dict(tree.__dict__)
    before = Snapshot((tree,), Plans())
    change(tree)
    before.restore()
    assert tree.__dict__.keys() == as_it_was.__dict__.keys()
    assert all(tree.__dict__[name] is value for name, value in held.items())  # in place
    assert (tree.number, tree.maybe) == (1, None)
    assert tree.array.tolist() == [0.0, 1.0, 2.0, 3.0]
    assert tree.view.base is tree.array
    assert tree.leaf == as_it_was.leaf
    assert tree.leaf.values.maxlen == 3
    assert tree.leaves == as_it_was.leaves
    assert {name: [one.tolist() for one in of] for name, of in tree.by_name.items()} == {
        "a": [[0.0, 0.0]], "b": [[1.0, 1.0]],
    }  # fmt: skip
    assert tree.counts == Counter({"x": 2})
    assert tree.names == {"one"}


def test_it_can_be_restored_twice():
    tree = Tree()
    before = Snapshot((tree,), Plans())
    for _ in range(2):
        inner(tree)
        nested(tree)
        before.restore()
    assert tree.leaf == Leaf()
    assert [one.tolist() for one in tree.by_name["a"]] == [[0.0, 0.0]]


def test_constant_classes_are_left_alone():
    tree = Tree()
    before = Snapshot((tree,), Plans((Constant,)))
    tree.constant.number, tree.number = 7, 7
    before.restore()
    assert (tree.constant.number, tree.number) == (7, 1)


def test_objects_of_one_class_may_have_other_attributes():
    one, other = Constant(), Constant()
    del other.number
    other.further = [1]
    before = Snapshot((one, other, Constant()), Plans())
    one.number, other.further[0] = 7, 7
    before.restore()
    assert (one.number, other.further) == (1, [1])


def test_what_replaced_attributes_hold_is_shared_and_put_back():
    tree = Tree()
    one, _ = tree.leaves
    held = one.values
    before = Snapshot((tree,), Plans((), (Leaf,)))
    one.name, one.values = "other", deque([7])
    tree.leaves.append(Leaf("third"))
    before.restore()
    assert (one.name, len(tree.leaves)) == ("leaf", 2)
    assert one.values is held


def test_objects_may_be_replaced_between_snapshots():
    tree, plans = Tree(), Plans()
    for leaf in (tree.leaf, Leaf("second"), None, Leaf("third")):
        tree.leaf = tree.again = leaf
        before = Snapshot((tree,), plans)
        if leaf is not None:
            leaf.name = "other"
            leaf.values.append(7)
        tree.leaf, tree.array[0] = Leaf("late"), 9.0
        before.restore()
        assert tree.leaf is leaf
        assert leaf is None or (leaf.name != "other" and 7 not in leaf.values)
        assert tree.array[0] == 0.0


def test_objects_of_a_list_may_be_replaced_between_snapshots():
    tree, plans = Tree(), Plans()
    late = Leaf("late")
    for leaves in ([late], [late], [tree.leaf, Leaf("other")], [], [Leaf("last")]):
        tree.leaves[:] = leaves
        before = Snapshot((tree,), plans)
        for one in leaves:
            one.name = "changed"
            one.values.append(7)
        tree.leaves[:] = [Leaf("more")]
        before.restore()
        assert all(one is own for one, own in zip(tree.leaves, leaves, strict=True))
        assert all(one.name != "changed" and 7 not in one.values for one in leaves)
