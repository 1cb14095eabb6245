"""Signals as they travel and are recorded: std_msgs/Float64 messages in CDR."""

from __future__ import annotations

import struct

_LITTLE, _BIG = struct.Struct('<4xd'), struct.Struct('>4xd')
_CDR = struct.Struct('<4sd')
_HEADER = bytes((0, 1, 0, 0))


def packed(value: float) -> bytes:
    """Return a Float64 message as CDR: half as dear as letting rclpy convert an object."""
    return _CDR.pack(_HEADER, value)


def unpacked(data: bytes) -> float:
    """Return the value of a Float64 message in CDR, from a host of either byte order."""
    value: float = (_LITTLE if data[1] else _BIG).unpack(data)[0]
    return value
