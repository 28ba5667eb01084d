# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What runs an image while models for sizes that come often are compiled beside."""

from __future__ import annotations

import threading

import pytest

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.compiled_sizes import CompiledSizes

WHOLE, WINDOW, PART, OTHER, RARE = (
    (1, height, width, 3)
    for height, width in ((736, 1280), (128, 128), (288, 320), (160, 160), (448, 448))
)
OFTEN, COMPILED_WITHIN, RECENT = 10, 50, 1000


class Model:
    """Takes any size until it is reshaped."""

    shape: object = "any"

    def clone(self):
        return Model()

    def reshape(self, shape):
        self.shape = tuple(shape)


class Compiler:
    """Remembers what it made and in which thread; can be held up, or fail."""

    def __init__(self):
        self.made, self.threads = [], []
        self.free = threading.Event()
        self.free.set()
        self.failing = set()
        self.beside = set()

    def __call__(self, model, beside):
        if beside:
            self.beside.add(model.shape)
        self.free.wait(90.0)
        self.threads.append(threading.current_thread())
        if model.shape in self.failing:
            raise ModelError("no memory.")
        self.made.append(model.shape)
        return model.shape


@pytest.fixture
def compiler():
    return Compiler()


def made_sizes(compiler, **options):
    """Return sizes with the trial and the first image behind them."""
    sizes = CompiledSizes(compiler, Model(), WHOLE, **options)
    assert [sizes[WHOLE], sizes[WHOLE]] == [WHOLE, WHOLE]
    return sizes


def used(sizes, shape, times):
    return [sizes[shape] for _ in range(times)]


def test_images_of_the_usual_size_need_one_compilation_only(compiler):
    sizes = made_sizes(compiler)
    used(sizes, WHOLE, 200)
    assert compiler.made == [WHOLE]


def test_a_wrong_guess_is_forgotten_and_the_images_size_compiled_for_at_once(compiler):
    sizes = CompiledSizes(compiler, Model(), WHOLE)
    assert sizes[WHOLE] == WHOLE  # the trial
    assert used(sizes, PART, 3) == [PART] * 3
    assert compiler.made == [WHOLE, PART]
    assert sizes[WHOLE] == "any"


def test_a_size_that_comes_often_changes_over_at_the_same_image_however_long_compiling_takes():
    taken = []
    for held_up in (False, True):
        compiler = Compiler()
        sizes = made_sizes(compiler)
        assert sizes[WINDOW] == "any"
        if held_up:
            compiler.free.clear()
            threading.Timer(0.2, compiler.free.set).start()
        taken.append(used(sizes, WINDOW, 100))
        assert threading.main_thread() not in compiler.threads[2:]
        assert compiler.beside == {WINDOW}
        assert sizes.has_own(WINDOW)
        assert not sizes.has_own(PART)
    assert taken[0] == taken[1] == ["any"] * (OFTEN + COMPILED_WITHIN - 2) + [WINDOW] * 42


def test_windows_are_prepared_for_before_the_first_comes(compiler):
    sizes = made_sizes(compiler, others=True)
    assert sizes[WINDOW] == "any"
    assert compiler.made.count("any") == 1
    assert threading.main_thread() not in [
        thread
        for thread, made in zip(compiler.threads, compiler.made, strict=True)
        if made == "any"
    ]


def test_a_rare_size_is_never_compiled_for(compiler):
    sizes = made_sizes(compiler)
    for _ in range(20):
        used(sizes, WHOLE, RECENT // 5)
        assert sizes[RARE] == "any"
    assert RARE not in compiler.made


def test_few_sizes_are_kept_and_those_that_come_no_more_make_room(compiler):
    sizes = made_sizes(compiler)
    for shape in (WINDOW, PART, OTHER, RARE):
        used(sizes, shape, 100)
    assert [sizes[shape] for shape in (WHOLE, WINDOW, PART, OTHER, RARE)] == [
        WHOLE, WINDOW, PART, OTHER, "any",
    ]  # fmt: skip
    for _ in range(RECENT):
        sizes[PART], sizes[OTHER], sizes[RARE]
    assert [sizes[shape] for shape in (WHOLE, PART, OTHER, RARE)] == [WHOLE, PART, OTHER, RARE]
    assert sizes[WINDOW] == "any"


def test_what_cannot_be_compiled_for_one_size_is_left_to_that_for_any(compiler):
    compiler.failing = {WINDOW}
    sizes = made_sizes(compiler)
    assert used(sizes, WINDOW, 300) == ["any"] * 300
    assert len(compiler.threads) == 3  # the whole, any, and once in vain


def test_want_of_memory_fails_one_image_and_the_next_tries_again(compiler):
    for others in (False, True):
        compiler.failing = {"any"}
        sizes = made_sizes(compiler, others=others)
        with pytest.raises(ModelError, match="no memory"):
            sizes[WINDOW]
        compiler.failing = set()
        assert sizes[WINDOW] == "any"


def test_closing_waits_for_the_compiler_and_forgets_all(compiler):
    sizes = made_sizes(compiler)
    used(sizes, WINDOW, 2)
    compiler.free.clear()
    used(sizes, WINDOW, OFTEN)
    threading.Timer(0.1, compiler.free.set).start()
    sizes.close()
    assert compiler.made == [WHOLE, "any", WINDOW]
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("compiling")]
