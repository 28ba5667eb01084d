# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""A bag played no faster than its messages are answered: tests that do not depend on the clock."""

from __future__ import annotations

IN_STEP = """
import sys, time
from pathlib import Path
from aerial_gnss_ros.nodes import player

seen, topic = Path(sys.argv.pop(1)), sys.argv.pop(1)
held_s = 0.0

class Watch:
    sleep = staticmethod(time.sleep)
    def monotonic(self):
        return time.monotonic() - held_s

class Gate:
    def __init__(self, publisher):
        self.publisher, self.count, self.patience_s = publisher, 0, 10.0
        self.get_subscription_count = publisher.get_subscription_count
    def publish(self, message):
        global held_s
        began = time.monotonic()
        while int(seen.read_text() or -1) < self.count:
            if time.monotonic() - began > self.patience_s:
                self.patience_s /= 2.0
                break
            time.sleep(0.005)
        held_s += time.monotonic() - began
        self.count += 1
        self.publisher.publish(message)

class InStep(player.Player):
    def __init__(self, *args):
        super().__init__(*args)
        self._publishers[topic] = Gate(self._publishers[topic])

player.time, player.Player = Watch(), InStep
sys.exit(player.main())
"""


class InStep:
    """The player as a process that publishes a message of one topic when the last was answered.

    However slow the machine is: what would be lost for want of time cannot hide what is lost for
    another reason. After 10 s without an answer it goes on, the next time after 5 s, and so on.
    """

    def __init__(self, start, folder, topic, *arguments):
        """Start the player.

        Args:
            start: the fixture.
            folder: for the number of answers.
            topic: whose messages wait.
            arguments: of the player.
        """
        self._seen, self._last = folder / "seen", None
        self._seen.write_text("-1")
        self.program = start("-c", IN_STEP, self._seen, topic, *arguments)

    def play(self, ros, answers):
        """Spin until the player ends; `answers()` returns how many messages were answered."""

        def ended():
            if (count := answers()) != self._last:
                self._last = count
                self._seen.write_text(str(count))
            return self.program.process.poll() is not None

        ros.spin_until(ended, 300.0)
        ros.spin(0.5)
        assert self.program.end() == 0, self.program.text
