# SPDX-License-Identifier: Apache-2.0
"""Runs of our own keep to the loopback: nobody on the network sees their nodes or can set them.

ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST only stops a participant from looking around: Fast DDS
listens on every interface all the same, and who names this host in ROS_STATIC_PEERS gets in. So the
participants of a run get a profile that binds their one transport to 127.0.0.1. With the range
SYSTEM_DEFAULT ROS leaves that as it is; with any other it adds transports of its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from ..errors import EventregError, shown
from ..nodes.environment import PEERS, RANGE, RMW, domain_of
from .domain import room

PROFILES = ('FASTRTPS_DEFAULT_PROFILES_FILE', 'FASTDDS_DEFAULT_PROFILES_FILE')
"""Environment variables that name a file of profiles, of Fast DDS 2 and 3."""

HERE = Path('DEFAULT_FASTRTPS_PROFILES.xml')
"""Fast DDS reads this file, too, where it is started."""

PROFILE = """\
<?xml version="1.0" encoding="UTF-8"?>
<dds>
  <profiles xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">
    <transport_descriptors>
      <transport_descriptor>
        <transport_id>loopback</transport_id>
        <type>UDPv4</type>
        <maxInitialPeersRange>{room}</maxInitialPeersRange>
        <interfaceWhiteList><address>127.0.0.1</address></interfaceWhiteList>
      </transport_descriptor>
      <transport_descriptor>
        <transport_id>memory</transport_id>
        <type>SHM</type>
      </transport_descriptor>
    </transport_descriptors>
    <participant profile_name="loopback" is_default_profile="true">
      <rtps>
        <useBuiltinTransports>false</useBuiltinTransports>
        <userTransports>{transports}</userTransports>
        <builtin>
          <metatrafficUnicastLocatorList>
            <locator><udpv4><address>127.0.0.1</address></udpv4></locator>
          </metatrafficUnicastLocatorList>
          <initialPeersList>
            <locator><udpv4><address>127.0.0.1</address></udpv4></locator>
          </initialPeersList>
        </builtin>
      </rtps>
    </participant>
  </profiles>
</dds>
"""
"""UDP is bound to 127.0.0.1; there is no multicast; peers are looked for at 127.0.0.1 alone, among
the ports of so many participants."""

NODES, CLIENT = ('memory', 'loopback'), ('loopback',)
"""The transports of nodes, and of who only looks on. Nodes send too much for the buffers of UDP,
where a datagram that is lost comes again after seconds; but who is killed leaves files of shared
memory."""


class Reach(NamedTuple):
    """The environment of a run's nodes and of its client, and what a person should know of it."""

    nodes: dict[str, str]
    client: dict[str, str]
    notes: list[str]


def closed(environment: Mapping[str, str], directory: Path) -> Reach:
    """Return the environments in which participants keep to the loopback.

    The profiles are written to ``directory``, which must outlive them. Profiles that the
    environment names already are left as they are, and so is another middleware than Fast DDS; a
    note says so. Raises EventregError for profiles that are not there.
    """
    found, notes = dict(environment), []
    if (theirs := _profiles_of(found)) is not None:
        found.setdefault(RANGE, 'LOCALHOST')
        _need_file(theirs)
        notes.append(f'your Fast DDS profiles ({theirs}) say who can reach the run')
        return Reach(found, found, notes)
    if 'fastrtps' not in (found.get(RMW) or 'rmw_fastrtps_cpp'):
        found.setdefault(RANGE, 'LOCALHOST')
        notes.append(f'{found[RMW]} may listen on the network; eventreg closes only Fast DDS')
        return Reach(found, found, notes)
    if peers := found.pop(PEERS, ''):
        notes.append(f'{PEERS}={peers} is left aside; --network opens the run to others')
    for name in ('FASTDDS_BUILTIN_TRANSPORTS', 'ROS_LOCALHOST_ONLY'):
        found.pop(name, None)
    found |= {RANGE: 'SYSTEM_DEFAULT', 'SKIP_DEFAULT_XML': '1'}
    many = room(domain_of(found))
    nodes, client = (
        found | dict.fromkeys(PROFILES, _written(directory / f'{name}.xml', transports, many))
        for name, transports in (('nodes', NODES), ('client', CLIENT))
    )
    return Reach(nodes, client, notes)


def _need_file(given: str) -> None:
    """Raise EventregError for profiles that are not there: Fast DDS goes without, and is open."""
    variable, equals, path = given.partition('=')
    if equals and not Path(path).is_file():
        raise EventregError(f'{variable} must name a file, got {shown(path)}; unset it')


def _written(file: Path, transports: Sequence[str], many: int) -> str:
    words = ''.join(f'<transport_id>{name}</transport_id>' for name in transports)
    file.write_text(PROFILE.format(transports=words, room=many), encoding='utf-8')
    return str(file)


def opened(environment: Mapping[str, str]) -> Reach:
    """Return the environments in which participants are reached as any ROS node is."""
    found = dict(environment)
    found.setdefault(RANGE, 'SUBNET')
    notes = ['--network: whoever reaches this domain sees the nodes and may set them']
    return Reach(found, found, notes)


def _profiles_of(environment: Mapping[str, str]) -> str | None:
    """Return the file of profiles that a person gave, None if none."""
    for name in PROFILES:
        if environment.get(name):
            return f'{name}={environment[name]}'
    return str(HERE) if HERE.exists() and environment.get('SKIP_DEFAULT_XML') != '1' else None


def address(environment: Mapping[str, str]) -> str:
    """Return what another terminal exports to see the nodes."""
    pinned = environment[RANGE] == 'SYSTEM_DEFAULT'
    seen = 'LOCALHOST' if pinned else environment[RANGE]
    return f'ROS_DOMAIN_ID={environment["ROS_DOMAIN_ID"]} {RANGE}={seen}'
