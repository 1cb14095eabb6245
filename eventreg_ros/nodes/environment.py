# SPDX-License-Identifier: Apache-2.0
"""What the environment says to ROS, checked: some of it ends a process without a word of ours."""

from __future__ import annotations

import os
import re
import socket
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from ..errors import EventregError, shown
from ..files import reason_of

DOMAIN, PEERS, RMW = 'ROS_DOMAIN_ID', 'ROS_STATIC_PEERS', 'RMW_IMPLEMENTATION'
RANGE, SECURITY = 'ROS_AUTOMATIC_DISCOVERY_RANGE', 'ROS_SECURITY_ENABLE'

HIGHEST = 232
"""The highest domain whose ports exist."""

_WITHOUT = b"doesn't have the security libraries"
"""What stands in a Fast DDS layer that was built without security."""


def check(environment: Mapping[str, str]) -> None:
    """Raise EventregError for what ROS would fail on, with the remedy.

    To be called before rclpy is imported, which ends the process where it misses its middleware.
    """
    domain_of(environment)
    _check_middleware(environment)
    _check_peers(environment)
    _check_logs(environment)


def check_security(environment: Mapping[str, str]) -> None:
    """Raise EventregError for security that is asked for and not there; rclpy is imported."""
    if environment.get(SECURITY) == 'true' and without_security():
        raise EventregError(
            f'{SECURITY}=true, but this Fast DDS was built without security, as the wheels of PyPI '
            "are, so that nothing would be secured; unset it, or use ROS's own packages"
        )


def domain_of(environment: Mapping[str, str]) -> int:
    """Return the domain that ROS takes, as it reads it. Raises EventregError for what is none."""
    text = environment.get(DOMAIN, '')
    found = re.match(r'\s*([+-]?)(0[xX][0-9a-fA-F]+|[0-9]{1,9})', text)
    if (found is not None and found[1] == '-') or not text:
        return 0
    number = int(found[2], 16 if 'x' in found[2].lower() else 10) if found else HIGHEST + 1
    if number > HIGHEST:
        raise EventregError(
            f'{DOMAIN} must be a whole number from 0 to {HIGHEST}, got {shown(text)}; set another'
        )
    return number


def _check_middleware(environment: Mapping[str, str]) -> None:
    wanted = environment.get(RMW, '')
    installed = {path.name for prefix in prefixes(environment) for path in _packages(prefix)}
    known = sorted(name for name in installed if name.startswith('rmw_') and name.endswith('_cpp'))
    known = [name for name in known if 'shared' not in name]
    if wanted and known and wanted not in installed:
        raise EventregError(
            f'{RMW}={shown(wanted)} is not installed (there is {", ".join(known)}); '
            'unset it, or install the package'
        )


def prefixes(environment: Mapping[str, str]) -> list[Path]:
    """Return the directories that ROS packages are installed in, by ament and with this Python."""
    given = environment.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
    return [Path(prefix) for prefix in [*given, sys.prefix] if prefix]


def _packages(prefix: Path) -> list[Path]:
    index = prefix / 'share' / 'ament_index' / 'resource_index' / 'packages'
    return list(index.glob('rmw_*'))


def _check_peers(environment: Mapping[str, str]) -> None:
    if environment.get(RANGE) in ('OFF', 'SYSTEM_DEFAULT'):
        return  # nobody looks at them
    for peer in filter(None, environment.get(PEERS, '').split(';')):
        try:
            socket.getaddrinfo(peer, None, socket.AF_INET)
        except (OSError, UnicodeError):
            raise EventregError(
                f'{PEERS} names {shown(peer)}, which has no address; write hosts or addresses with '
                '; between them, or unset it'
            ) from None


def _check_logs(environment: Mapping[str, str]) -> None:
    if not any(environment.get(name) for name in ('ROS_LOG_DIR', 'ROS_HOME', 'HOME')):
        raise EventregError('ROS has no place for its logs: HOME is not set; set it or ROS_LOG_DIR')
    home = environment.get('ROS_HOME') or str(Path(environment.get('HOME', '')) / '.ros')
    place = environment.get('ROS_LOG_DIR') or str(Path(home) / 'log')
    try:
        directory = Path(os.path.expanduser(place))
        directory.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=directory):
            pass
    except (OSError, ValueError) as error:
        why = reason_of(error) if isinstance(error, OSError) else str(error)
        raise EventregError(
            f'ROS cannot write its logs to {shown(place)}: {why}; set ROS_LOG_DIR to another place'
        ) from None


def without_security() -> bool:
    """Say whether the Fast DDS layer that this process has loaded cannot secure anything."""
    try:
        maps = Path('/proc/self/maps').read_text(encoding='utf-8', errors='replace')
        files = set(re.findall(r'(/\S*librmw_fastrtps_shared_cpp\S*)', maps))
        return any(_WITHOUT in Path(file).read_bytes() for file in files)
    except OSError:
        return False
