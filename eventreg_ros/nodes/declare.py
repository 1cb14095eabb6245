# SPDX-License-Identifier: Apache-2.0
"""The table of parameters, declared to ROS: descriptions, ranges, one check for every change."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.parameter import Parameter as RosParameter

from ..errors import ParameterError, one_line, shown
from ..scenario.hint import hint
from ..scenario.parameter import ACTIVE, START, Parameter
from ..scenario.parameters import all_parameters, is_ros_parameter, need_no_part

TYPES = {
    'bool': RosParameter.Type.BOOL,
    'int': RosParameter.Type.INTEGER,
    'double': RosParameter.Type.DOUBLE,
    'string': RosParameter.Type.STRING,
    'double[]': RosParameter.Type.DOUBLE_ARRAY,
    'string[]': RosParameter.Type.STRING_ARRAY,
}

Table = Mapping[str, Parameter]


def given_to(node: Any) -> dict[str, Any]:
    """Return what the command line and files gave to ``node``, None for an empty list."""
    # rclpy offers no public way to look at what was given before declaring it, and declaring
    # first would refuse the whole number that is meant as a double.
    return {name: override.value for name, override in node._parameter_overrides.items()}


def fitted(node: Any, table: Table, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return what was given of the parameters in ``table``; warn of what no node knows."""
    found = {}
    for name, value in given.items():
        if name in table:
            found[name] = value
            continue
        need_no_part(node.label, name, table)
        if not (is_ros_parameter(name) or name in all_parameters()):
            words = f'{node.label} has no parameter {shown(name)}, ignored{hint(name, table)}'
            node.get_logger().warning(one_line(words))
    return found


def declare(node: Any, table: Table, values: Mapping[str, Any]) -> None:
    """Declare those parameters of ``table`` to ROS that ``node`` has not, with their values."""
    for name, parameter in table.items():
        if not node.has_parameter(name):
            kind = TYPES[parameter.type]
            node.declare_parameter(name, kind, descriptor(parameter), ignore_override=True)
            (result,) = node.set_parameters([RosParameter(name, kind, values[name])])
            if not result.successful:
                raise ParameterError(f'{node.label}.{name}: {result.reason}')


def descriptor(parameter: Parameter) -> ParameterDescriptor:
    """Return what ``ros2 param describe`` shows of ``parameter``."""
    result = ParameterDescriptor(
        description=parameter.doc,
        additional_constraints=parameter.rule + _until(parameter.settable),
    )
    low, high = parameter.low, parameter.high
    if low is None and high is None:
        return result
    if parameter.type == 'double':
        # A range includes its edges, so that "> 0" is said in the constraints and checked by us.
        most = sys.float_info.max
        result.floating_point_range = [
            FloatingPointRange(
                from_value=-most if low is None else float(low),
                to_value=most if high is None else float(high),
            )
        ]
    elif parameter.type == 'int':
        result.integer_range = [
            IntegerRange(from_value=int(low or 0), to_value=int(high or 2**63 - 1))
        ]
    return result


def _until(settable: str) -> str:
    return {ACTIVE: '', START: '; given as the node is started'}.get(
        settable, f'; settable while {settable}'
    )


def widened(table: Table, changes: Iterable[RosParameter]) -> list[RosParameter]:
    """Return ``changes`` with whole numbers made doubles where ``table`` means a double."""
    found = []
    for change in changes:
        wanted = table[change.name].type if change.name in table else None
        if wanted == 'double' and change.type_ == RosParameter.Type.INTEGER:
            change = RosParameter(change.name, TYPES[wanted], float(change.value))
        elif wanted == 'double[]' and change.type_ == RosParameter.Type.INTEGER_ARRAY:
            change = RosParameter(change.name, TYPES[wanted], [float(v) for v in change.value])
        found.append(change)
    return found
