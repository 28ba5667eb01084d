# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A model compiled separately for frequent image sizes, and once for all others."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any

from aerial_gnss_ros.core.values.errors import ModelError
from aerial_gnss_ros.detection.background import begun

Shape = tuple[int, ...]
Compile = Callable[[Any, bool], Any]
_MOST = 3
"""Greatest number of compiled sizes besides the first image's; each takes some 20 MB."""
_OFTEN = 10  # runs with a size, among the last _RECENT, from which it is compiled
_RECENT = 1000
_NAME = "compiling"
_COMPILED_WITHIN = 50  # runs; half a second of `search.mode` roi, twice the time of compiling


@dataclass
class _Job:
    """A size being compiled."""

    shape: Shape
    made: Future[Any]
    due: int


class CompiledSizes:
    """Chooses the compiled model for an image: that for its exact size, or for any size.

    A model compiled for one size is a quarter faster, and at the size of a whole image takes a
    third of the memory; but compiling takes a quarter of a second. So it is done at once only for
    the most likely size. The windows of `search.mode` roi, of many sizes, use the model for any
    size until the frequent ones have been compiled in a separate thread.

    When a size switches is decided by counting runs, never by the clock, so equal images give equal
    boxes. Not thread-safe.

    Args:
        compiled: compiles a model; its argument states whether the size is an additional one, such
            as of windows.
        model: for any size, with `clone` and `reshape` as in OpenVINO.
        first: most likely input shape, with which the model is tested.
        others: whether smaller images than the first are expected: prepare for them after the first
            run.

    Raises:
        ModelError: the model cannot be compiled.
    """

    def __init__(
        self,
        compiled: Compile,
        model: Any,
        first: Shape,
        *,
        others: bool = False,
    ) -> None:
        self._compiled, self._model = compiled, model
        self._runs = 0
        self._whole = first
        self._own: dict[Shape, Any] = {first: self._fitted(first, beside=False)}
        self._last: dict[Shape, int] = {}
        self._uses: Counter[Shape] = Counter()
        self._hopeless: set[Shape] = set()
        self._job: _Job | None = None
        self._any: Future[Any] | None = None
        self._others = others

    def __getitem__(self, shape: Shape) -> Any:
        """Return the compiled model for the next image, of this shape.

        Raises:
            ModelError: it cannot be compiled, for example out of memory.
        """
        self._runs += 1
        if self._runs % _RECENT == 0:
            self._uses.clear()
        self._change_over()
        if (
            self._runs == 2 and shape != self._whole
        ):  # the first run was the trial: the guess was wrong
            self._own.clear()
            self._whole = shape
            self._own[shape] = self._fitted(shape, beside=False)
        if self._runs == 3 and self._others:  # not earlier: it would delay the first boxes
            self._any = begun(lambda: self._compiled(self._model, False), _NAME)
        if shape in self._own:
            self._last[shape] = self._runs
            return self._own[shape]
        self._consider(shape)
        return self._for_any()

    def has_own(self, shape: Shape) -> bool:
        """Return whether images of this shape have their own model, for which no others wait."""
        return shape in self._own

    def close(self) -> None:
        """Release all compiled models after pending compilations."""
        for made in (self._any, self._job.made if self._job else None):
            if made is not None:
                made.exception()  # waits
        self._any = self._job = None
        self._own.clear()

    def _for_any(self) -> Any:
        made, self._any = self._any, None
        if made is None:
            made = Future()
            made.set_result(self._compiled(self._model, False))
        result = made.result()  # a failed one is forgotten: the next image tries again
        self._any = made
        return result

    def _change_over(self) -> None:
        job = self._job
        if job is None or self._runs < job.due:
            return
        self._job = None
        try:
            self._own[job.shape] = job.made.result()
            self._last[job.shape] = self._runs
        except ModelError:  # most likely out of memory; the model for any size still works
            self._hopeless.add(job.shape)

    def _consider(self, shape: Shape) -> None:
        """Start compiling for a size if it is frequent and there is room."""
        self._uses[shape] += 1
        if self._uses[shape] < _OFTEN or self._job is not None or shape in self._hopeless:
            return
        if self._room():
            made = begun(lambda: self._fitted(shape, beside=True), _NAME)
            self._job = _Job(shape, made, self._runs + _COMPILED_WITHIN)

    def _room(self) -> bool:
        """Return whether another size may be kept, after dropping an unused one."""
        kept = {shape: self._last[shape] for shape in self._own if shape != self._whole}
        if len(kept) < _MOST:
            return True
        stalest = min(kept, key=kept.__getitem__)
        if self._runs - kept[stalest] < _RECENT:
            return False
        del self._own[stalest]
        return True

    def _fitted(self, shape: Shape, *, beside: bool) -> Any:
        fitted = self._model.clone()
        fitted.reshape(list(shape))
        return self._compiled(fitted, beside)
