# SPDX-License-Identifier: Apache-2.0
"""How a node's process is asked to end: by SIGINT, SIGTERM or SIGHUP, whatever it is doing."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable

from .. import interrupts


class Ending:
    """Notes a signal, and wakes who waits; nothing else happens, however often one comes.

    rclpy's own handlers shut its context down at once, so that no node could say a last word. Here
    the nodes are closed first. A second signal, as ros2 launch sends one, must not break into that.
    """

    def __init__(self) -> None:
        """Take the signals of this process from now on."""
        self.asked = False
        self._wake: Callable[[], None] = lambda: None
        # Python's handlers run in the main thread, which waits in C: a thread reads what Python
        # writes to a pipe as the signal comes. Blocked signals would go on to child processes.
        reader, writer = os.pipe()
        os.set_blocking(writer, False)
        for each in interrupts.SIGNALS:
            if each != signal.SIGHUP or signal.getsignal(each) is not signal.SIG_IGN:
                signal.signal(each, lambda *_: None)
        signal.set_wakeup_fd(writer, warn_on_full_buffer=False)
        threading.Thread(target=self._listen, args=[reader], daemon=True).start()
        interrupts.unblock()

    def _listen(self, reader: int) -> None:
        while number := os.read(reader, 1):
            if number[0] in interrupts.SIGNALS:  # a block of somebody's own may handle others
                self.asked = True
                self._wake()

    def call(self, wake: Callable[[], None]) -> None:
        """Call ``wake``, in any thread, when a signal comes; now if one has come already."""
        self._wake = wake
        if self.asked:
            wake()

    @staticmethod
    def over() -> None:
        """Ignore signals: Python's own handlers go as the process ends."""
        signal.set_wakeup_fd(-1)
        for each in interrupts.SIGNALS:
            signal.signal(each, signal.SIG_IGN)
