# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A lifecycle node that starts by itself; its resources can be released in flight."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.lifecycle import LifecycleNodeMixin, TransitionCallbackReturn

from aerial_gnss_ros.core.values.errors import AerialGnssError

ACTIVE = "active"
_RCL_ERROR: type[Exception] = rclpy._rclpy_pybind11.RCLError  # noqa: SLF001 (no public name)


class Managed(LifecycleNodeMixin):  # type: ignore[misc]  # rclpy has no complete types
    """Adds the lifecycle to a node; a subclass implements each step.

    configure: `load`; activate: `start`; deactivate: `stop`; cleanup: `release`. If a step raises
    `AerialGnssError`, the failure is logged and the node stays in its state.
    """

    @abstractmethod
    def load(self) -> None:
        """Acquire the expensive resources."""

    @abstractmethod
    def start(self) -> None:
        """Start processing."""

    @abstractmethod
    def stop(self) -> None:
        """Stop processing; no effect if it has not started."""

    @abstractmethod
    def release(self) -> None:
        """Release what `load` acquired; no effect without it."""

    def manage(self, autostart: bool) -> None:
        """Offer the transitions; call it at the end of the constructor.

        Args:
            autostart: activate at once.

        Raises:
            Exception: whatever a step of the autostart raised.
        """
        self._problem: Exception | None = None
        LifecycleNodeMixin.__init__(self)
        self._refuse_impossible_transitions()
        if autostart:
            for step in (self.trigger_configure, self.trigger_activate):
                step()
                if self._problem is not None:
                    raise self._problem

    @property
    def phase(self) -> str:
        """The state's name: unconfigured, inactive, active or finalized."""
        return str(self._state_machine.current_state[1])

    def on_configure(self, _state: Any) -> Any:
        """Load."""
        return self._step(self.load)

    def on_activate(self, _state: Any) -> Any:
        """Start."""
        return self._step(self.start)

    def on_deactivate(self, _state: Any) -> Any:
        """Stop."""
        return self._step(self.stop)

    def on_cleanup(self, _state: Any) -> Any:
        """Release."""
        return self._step(self.release)

    def on_shutdown(self, _state: Any) -> Any:
        """Stop and release, from any state."""
        return self._step(self._end)

    def on_error(self, _state: Any) -> Any:
        """Return to the unconfigured state."""
        return self._step(self._end)

    def _end(self) -> None:
        self.stop()
        self.release()

    def _step(self, task: Callable[[], None]) -> Any:
        try:
            task()
        except AerialGnssError as error:
            self._problem = error
            self.get_logger().error(str(error))
            return TransitionCallbackReturn.FAILURE
        except Exception as error:  # noqa: BLE001 - rclpy would swallow it
            self._problem = error
            self.get_logger().error(f"{type(error).__name__}: {error}")
            return TransitionCallbackReturn.ERROR
        return TransitionCallbackReturn.SUCCESS

    def _refuse_impossible_transitions(self) -> None:
        """Refuse a transition that does not start from the current state; rclpy would raise."""
        change = self._service_change_state.callback

        def guarded(request: Any, response: Any) -> Any:
            try:
                return change(request, response)
            except _RCL_ERROR:
                self.get_logger().warning(
                    f"transition {request.transition.label or request.transition.id} does not "
                    f"start from {self.phase}; ask get_available_transitions"
                )
                response.success = False
                return response

        self._service_change_state.callback = guarded
