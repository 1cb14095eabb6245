# SPDX-License-Identifier: Apache-2.0
"""What a scalar of a parameter file is to rcl: bool, integer, double or string.

After get_value in rcl_yaml_param_parser/src/parse.c, which asks C's strtoll and strtod. YAML 1.1
and 1.2 say otherwise in many places: 017 is 15, 08 is 8.0, 1_000 and 12:30 are strings, y is true.
"""

from __future__ import annotations

import re
import sys
from decimal import Decimal

TRUE = ('Y', 'y', 'yes', 'Yes', 'YES', 'true', 'True', 'TRUE', 'on', 'On', 'ON')
FALSE = ('N', 'n', 'no', 'No', 'NO', 'false', 'False', 'FALSE', 'off', 'Off', 'OFF')

_SPACE = ' \t\n\v\f\r'
_INTEGER = re.compile(r'[+-]?(0[xX][0-9a-fA-F]+|[0-9]+)')
_OCTAL = re.compile(r'[+-]?0[0-7]+')
_SPECIAL = re.compile(r'[+-]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)')
_DECIMAL = re.compile(r'[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?')
_HEXADECIMAL = re.compile(
    r'[+-]?0[xX]([0-9a-fA-F]+\.?[0-9a-fA-F]*|\.[0-9a-fA-F]+)([pP][+-]?[0-9]+)?'
)
_NAMED = re.compile(r'[+-]?(inf(inity)?|nan(\([0-9a-zA-Z_]*\))?)', re.IGNORECASE)

Scalar = bool | int | float | str


def scalar(text: str) -> Scalar:
    """Return what ``text``, which is not quoted and has no tag, is to rcl."""
    if text in TRUE or text in FALSE:
        return text in TRUE
    for read in (_integer, _double):
        value = read(text)
        if value is not None:
            return value
    return text


def _integer(text: str) -> int | None:
    """Return what strtoll(text, 0) makes of the whole text; None where it stops or overflows."""
    text = text.lstrip(_SPACE)
    if not _INTEGER.fullmatch(text) or len(text) > 70:
        return None
    if text.lstrip('+-').startswith('0') and text.lstrip('+-0') and 'x' not in text.lower():
        if not _OCTAL.fullmatch(text):
            return None
        value = int(text, 8)
    else:
        value = int(text, 16 if 'x' in text.lower() else 10)
    return value if -(2**63) <= value < 2**63 else None


def _double(text: str) -> float | None:
    """Return what strtod makes of the whole text; None where it stops or leaves the range."""
    if _SPECIAL.fullmatch(text):
        return float(text.replace('.', ''))
    text = text.lstrip(_SPACE)
    if _NAMED.fullmatch(text):
        return float(text.partition('(')[0])
    if _HEXADECIMAL.fullmatch(text):
        return _hexadecimal(text)
    if not _DECIMAL.fullmatch(text):
        return None
    value = float(text)
    if abs(value) == float('inf'):
        return None
    if abs(value) < sys.float_info.min and not _is_exactly(text, value):
        return None
    return value


def _is_exactly(text: str, value: float) -> bool:
    """Say whether ``value``, too small for full precision, is ``text`` all the same."""
    if value == 0.0:
        return not text.lower().partition('e')[0].strip('+-0.')
    return Decimal(text) == Decimal(value)


def _hexadecimal(text: str) -> float | None:
    try:
        value = float.fromhex(text)
    except (OverflowError, ValueError):
        return None
    digits, _, exponent = text.lower().partition('p')
    whole, _, part = digits.lstrip('+-').removeprefix('0x').partition('.')
    significand = int(whole + part, 16) if len(whole + part) < 1000 else 1
    if abs(value) >= sys.float_info.min or significand == 0:
        return value
    scale = int(exponent or 0) - 4 * len(part)
    exact = value != 0.0 and significand % (1 << max(0, -1074 - scale)) == 0
    return value if exact else None
