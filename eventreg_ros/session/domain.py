# SPDX-License-Identifier: Apache-2.0
"""A ROS domain of its own on the loopback, unless the environment names one."""

from __future__ import annotations

import errno
import os
import random
import socket
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

from ..errors import EventregError
from ..nodes.environment import RANGE

DOMAINS = range(1, 100)
"""Domain ids whose ports lie below Linux's ephemeral ones."""


REACH = ('ROS_', 'RMW_', 'FASTDDS_', 'FASTRTPS_', 'CYCLONEDDS_', 'SKIP_DEFAULT_XML')
"""Environment variables that decide whom a process can reach begin with one of these."""

FIRST_PORT, PORTS = 7400, 250


@contextmanager
def own_domain(environment: Mapping[str, str]) -> Iterator[dict[str, str]]:
    """Yield ``environment`` with a domain id that nobody uses, unless it names one.

    The domain is held until the block ends, against other runs on this machine too. Raises
    EventregError when none is free.
    """
    result = dict(environment)
    if result.get('ROS_DOMAIN_ID'):
        yield result
        return
    for domain in random.sample(DOMAINS, len(DOMAINS)):
        guard = _hold(domain)
        if guard is not None:
            with guard:
                result['ROS_DOMAIN_ID'] = str(domain)
                yield result
            return
    raise EventregError(
        'no free ROS domain id on this machine; set ROS_DOMAIN_ID'
        if _has_loopback()
        else 'the loopback has no address 127.0.0.1, over which nodes talk; ip link set lo up'
    )


@contextmanager
def loopback_domain(environment: Mapping[str, str]) -> Iterator[dict[str, str]]:
    """Yield ``environment`` with discovery on the loopback and a domain of its own.

    What the environment already says stays. See :mod:`.loopback` for what this does not keep out.
    """
    with own_domain(environment) as result:
        result.setdefault(RANGE, 'LOCALHOST')
        # Fast DDS leaves files in /dev/shm when a node is killed; UDP is as fast for our messages.
        result.setdefault('FASTDDS_BUILTIN_TRANSPORTS', 'UDPv4')
        yield result


@contextmanager
def turn(domain: int, look: Callable[[], None]) -> Iterator[None]:
    """Let one run of this machine at a time begin in ``domain``; others wait for the block's end.

    Two that begin at once would not see each other's nodes yet. ``look`` is called while waiting;
    it may raise.
    """
    # A name that Linux forgets with its process. The domain has no port left for it.
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as name:
        while _is_taken(name, f'\0eventreg_ros/{domain}'):
            look()
            time.sleep(0.05)
        yield


def _is_taken(name: socket.socket, text: str) -> bool:
    try:
        name.bind(text)
    except OSError as error:
        return error.errno == errno.EADDRINUSE
    return False


def is_inhabited(domain: int) -> bool:
    """Say whether processes of this machine are in ``domain``: their ports are taken."""
    first = FIRST_PORT + PORTS * domain + 10
    return any(not _is_free(first + 2 * each) for each in range(room(domain)))


def room(domain: int) -> int:
    """Return how many participants are looked for in ``domain``: the highest has ports for 62."""
    return min(100, (65535 - FIRST_PORT - PORTS * domain - 10) // 2)


def _is_free(port: int) -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(('0.0.0.0', port))
        except OSError:
            return False
    return True


def _has_loopback() -> bool:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(('127.0.0.1', 0))
        except OSError:
            return False
    return True


@contextmanager
def reaching(environment: Mapping[str, str]) -> Iterator[None]:
    """Let this process reach whom ``environment`` does, and put back what was there in the end."""
    before = dict(os.environ)
    for name in [name for name in before if name.startswith(REACH)]:
        del os.environ[name]
    os.environ.update({n: value for n, value in environment.items() if n.startswith(REACH)})
    try:
        yield
    finally:
        for name in [name for name in os.environ if name.startswith(REACH)]:
            del os.environ[name]
        os.environ.update({n: value for n, value in before.items() if n.startswith(REACH)})


def _hold(domain: int) -> socket.socket | None:
    """Hold a port of ``domain`` that only its 120th participant would use; None when in use.

    The ports are those of the DDS wire protocol: 7400 + 250 domain + 10 + 2 participant.
    """
    guard = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        guard.bind(('127.0.0.1', FIRST_PORT + PORTS * domain + 10 + 2 * 119))
    except OSError:
        guard.close()
        return None
    if is_inhabited(domain):
        guard.close()
        return None
    return guard
