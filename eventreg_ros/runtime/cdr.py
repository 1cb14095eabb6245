# SPDX-License-Identifier: Apache-2.0
"""Signals as they travel and are recorded: std_msgs/Float64 messages in CDR.

A relay's messages have time stamps of their own. How old the sample was that it relays it writes
into the two option bytes of the CDR header, which say nothing in CDR and which receivers ignore
(RTPS 2.5, 10.5).
"""

from __future__ import annotations

import struct

_LITTLE, _BIG = struct.Struct('<4xd'), struct.Struct('>4xd')
_CDR = struct.Struct('<4sd')
_HEADER = bytes((0, 1, 0, 0))


_FINE, _COARSE, _MOST = 100_000, 2_000_000, 0x7FFF
"""Nanoseconds of a unit of an age up to 3.2 s, and beyond, up to 65 s; units counted in 15 bits."""


def packed(value: float) -> bytes:
    """Return a Float64 message as CDR: half as dear as letting rclpy convert an object."""
    return _CDR.pack(_HEADER, value)


def unpacked(data: bytes) -> float:
    """Return the value of a Float64 message in CDR, from a host of either byte order."""
    value: float = (_LITTLE if data[1] else _BIG).unpack(data)[0]
    return value


def with_age(data: bytes, age: int) -> bytes:
    """Return the message with ``age`` (ns) noted in it, to 0.05 ms, beyond 3.2 s to 1 ms."""
    units = round(age / _FINE)
    if units > _MOST:
        units = min(round(age / _COARSE), _MOST) | 0x8000
    return data[:2] + max(units, 0).to_bytes(2, 'little') + data[4:]


def age_of(data: bytes) -> int:
    """Return the age of a sample when it was last sent, in ns; 0 unless a relay noted one."""
    units = data[2] | data[3] << 8
    return (units & _MOST) * (_COARSE if units & 0x8000 else _FINE)
