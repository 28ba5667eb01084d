# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""One model compiled for the sizes of images that come often, and once for all others."""

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
"""Sizes beside the first image's; each takes some 20 MB."""
_OFTEN = 10  # runs with a size, of the last _RECENT, that make it worth compiling for
_RECENT = 1000
_NAME = "compiling"
_COMPILED_WITHIN = 50  # runs; half a second of `search.mode` roi, twice what compiling takes


@dataclass
class _Job:
    """A size that is being compiled for."""

    shape: Shape
    made: Future[Any]
    due: int


class CompiledSizes:
    """Chooses what runs an image: the model compiled for just its size, or for any size.

    For just one size it is a quarter faster, and as large as a whole image it takes a third of the
    memory; but compiling takes a quarter of a second. So it is done at once only for the size that
    images most likely have. The windows of `search.mode` roi, of many sizes, are run by what takes
    any size, until those that come often have been compiled for in a thread of their own.

    When a size changes over is decided by counting runs, never by the clock: equal images give
    equal boxes. Not for several threads.

    Args:
        compiled: makes what runs a model, and is given whether that is for a size that comes beside
            the first one, such as of windows.
        model: takes any size; has `clone` and `reshape` as OpenVINO's.
        first: shape of the input that is likely, with which the model is tried.
        others: whether smaller images than the first will come: prepare for them once the first
            has been run.

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
        """Return what runs an image of this shape, the next one that is run.

        Raises:
            ModelError: it cannot be compiled, such as for want of memory.
        """
        self._runs += 1
        if self._runs % _RECENT == 0:
            self._uses.clear()
        self._change_over()
        if self._runs == 2 and shape != self._whole:  # the first run was the trial: a wrong guess
            self._own.clear()
            self._whole = shape
            self._own[shape] = self._fitted(shape, beside=False)
        if self._runs == 3 and self._others:  # not before: the first boxes would come later
            self._any = begun(lambda: self._compiled(self._model, False), _NAME)
        if shape in self._own:
            self._last[shape] = self._runs
            return self._own[shape]
        self._consider(shape)
        return self._for_any()

    def has_own(self, shape: Shape) -> bool:
        """Return whether a model of its own runs images of this shape: no others wait for it."""
        return shape in self._own

    def close(self) -> None:
        """Forget all that is compiled, once nothing is being compiled any more."""
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
        result = made.result()  # one that failed is forgotten: the next image tries again
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
        except ModelError:  # most likely for want of memory; what takes any size still works
            self._hopeless.add(job.shape)

    def _consider(self, shape: Shape) -> None:
        """Begin to compile for a size if it comes often and there is room."""
        self._uses[shape] += 1
        if self._uses[shape] < _OFTEN or self._job is not None or shape in self._hopeless:
            return
        if self._room():
            made = begun(lambda: self._fitted(shape, beside=True), _NAME)
            self._job = _Job(shape, made, self._runs + _COMPILED_WITHIN)

    def _room(self) -> bool:
        """Return whether one more size may be kept; forget one that does not come any more."""
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
