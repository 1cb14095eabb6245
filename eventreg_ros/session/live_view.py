# SPDX-License-Identifier: Apache-2.0
"""The running loop as a source for Lichtblick and Foxglove: what ``eventreg live`` does.

A server on the loopback speaks Foxglove's WebSocket protocol. Messages pass through as they are.
Signals are taken best effort, so that a slow viewer holds nobody up.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from ..bags.definitions import text_of_type
from ..errors import EventregError, ros_is_missing
from .running import of_domain, reaching_environment, the_run

if TYPE_CHECKING:
    from .client import Client

HOST, PORT = '127.0.0.1', 8765
"""Where the server listens; the port is the one that Lichtblick and Foxglove suggest."""

PATIENCE, LOOK = 5.0, 0.5
"""Seconds within which a signal must be found, and after which new topics are looked for."""

Log = Callable[[bytes, int], None]
"""Takes a serialised message and the nanoseconds at which it was sent."""

Channels = Callable[[str, str, str], Log]
"""Opens a channel for a topic, its type and the type's definition."""


def serve(port: int = PORT, began: Callable[[str], None] = lambda line: None) -> None:
    """Serve the signals of the run of this machine, or of ROS_DOMAIN_ID, until the run ends.

    ``began`` takes a line that says where. Raises EventregError when there is no ROS, no run, no
    foxglove-sdk, or when the port is taken.
    """
    run = the_run()
    whom = reaching_environment(run)
    try:
        from .client import Client
    except ImportError as error:
        raise EventregError(ros_is_missing('this command', error)) from None
    where = of_domain(whom.get('ROS_DOMAIN_ID', '0'))
    with Client(lambda: None, environment=whom) as client, server(port) as (address, channels):
        shown = wait_for_signals(client, channels, where)
        began(f'{where}: open connection {address} in Lichtblick or Foxglove; Ctrl-C ends it')
        while run is None or _is_alive(run.pid):
            client.wait(LOOK)
            show_new(client, channels, shown)


@contextmanager
def server(port: int) -> Iterator[tuple[str, Channels]]:
    """Yield the address of a server on the loopback, and what opens channels in it."""
    try:
        import foxglove
    except ImportError:
        raise EventregError(
            "live needs foxglove-sdk, which is not installed; pip install '.[live]' in the sources"
        ) from None
    try:
        found = foxglove.start_server(name='eventreg', host=HOST, port=port)
    except Exception as error:  # what the SDK raises is its own
        raise EventregError(f'port {port} of {HOST}: {error}; choose another --port') from None

    def channel(topic: str, kind: str, definition: str) -> Log:
        schema = foxglove.Schema(name=kind, encoding='ros2msg', data=definition.encode())
        opened = foxglove.Channel(topic, message_encoding='cdr', schema=schema)
        return lambda data, stamp: opened.log(data, log_time=stamp)

    try:
        yield f'ws://{HOST}:{found.port}', channel
    finally:
        found.stop()


def wait_for_signals(client: Client, channels: Channels, where: str) -> set[str]:
    """Return the topics that are shown, as soon as there are some. Raises EventregError."""
    end, shown = time.monotonic() + PATIENCE, set[str]()
    while not shown:
        if time.monotonic() > end:
            raise EventregError(
                f'no signals on {where}; start a loop with eventreg run, or export the '
                'ROS_DOMAIN_ID of yours'
            )
        client.wait(0.1)
        show_new(client, channels, shown)
    return shown


def show_new(client: Client, channels: Channels, shown: set[str]) -> None:
    """Forward the topics of our kinds that are not among ``shown`` yet."""
    for topic, kind in client.topics().items():
        if topic not in shown and client.knows(kind) and '/lockstep/' not in topic:
            shown.add(topic)
            log = channels(topic, kind, text_of_type(kind))
            client.take(topic, kind, _forward(log))


def _forward(log: Log) -> Callable[[Any, dict[str, Any]], None]:
    return lambda data, info: log(bytes(data), info['source_timestamp'])


def _is_alive(pid: int) -> bool:
    with suppress(ProcessLookupError):
        os.kill(pid, 0)
        return True
    return False
