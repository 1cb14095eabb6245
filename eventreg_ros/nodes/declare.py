"""The table of parameters, declared to ROS: descriptions, ranges, one check for every change."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.parameter import Parameter as RosParameter

from ..scenario.parameter import ACTIVE, Parameter
from ..scenario.parameters import NODES, hint, is_ros_parameter, resolve

TYPES = {
    'bool': RosParameter.Type.BOOL,
    'int': RosParameter.Type.INTEGER,
    'double': RosParameter.Type.DOUBLE,
    'string': RosParameter.Type.STRING,
    'double[]': RosParameter.Type.DOUBLE_ARRAY,
    'string[]': RosParameter.Type.STRING_ARRAY,
}


def declare(node: Any, kind: str) -> dict[str, Any]:
    """Check what the command line and files gave to ``node``, declare all parameters of ``kind``.

    Returns the checked values. Raises ParameterError.
    """
    table = {parameter.name: parameter for parameter in NODES[kind]}
    given = {}
    # rclpy offers no public way to look at what was given before declaring it, and declaring
    # first would refuse the whole number that is meant as a double.
    for name, override in node._parameter_overrides.items():
        if name in table:
            # An empty list has no type in ROS's parameter files; it reaches us as None.
            empty = override.value is None and table[name].type.endswith('[]')
            given[name] = [] if empty else override.value
        elif not is_ros_parameter(name):
            _tell_unknown(node, kind, name)
    values = resolve(kind, given)
    for name, parameter in table.items():
        node.declare_parameter(
            name, TYPES[parameter.type], descriptor(parameter), ignore_override=True
        )
        node.set_parameters([RosParameter(name, TYPES[parameter.type], values[name])])
    return values


def _tell_unknown(node: Any, kind: str, name: str) -> None:
    """Warn of a parameter that no node knows: a typing error would otherwise go unseen."""
    if not any(name == parameter.name for table in NODES.values() for parameter in table):
        known = {parameter.name: None for parameter in NODES[kind]}
        node.get_logger().warning(f'{kind} has no parameter {name!r}{hint(name, known)}; ignored')


def descriptor(parameter: Parameter) -> ParameterDescriptor:
    """Return what ``ros2 param describe`` shows of ``parameter``."""
    result = ParameterDescriptor(
        description=parameter.doc,
        additional_constraints=parameter.rule
        + ('' if parameter.settable == ACTIVE else f'; settable while {parameter.settable}'),
    )
    low, high = parameter.low, parameter.high
    if low is None and high is None:
        return result
    if parameter.type == 'double':
        # A range includes its edges, so that "> 0" is said in the constraints and checked by us.
        limit = sys.float_info.max
        result.floating_point_range = [
            FloatingPointRange(
                from_value=-limit if low is None else float(low),
                to_value=limit if high is None else float(high),
            )
        ]
    elif parameter.type == 'int':
        result.integer_range = [IntegerRange(from_value=int(low or 0), to_value=int(high or 2**62))]
    return result


def widen(kind: str, changes: Iterable[RosParameter]) -> list[RosParameter]:
    """Return ``changes`` with whole numbers made doubles where ``kind`` means a double."""
    types = {parameter.name: parameter.type for parameter in NODES[kind]}
    widened = []
    for change in changes:
        wanted = types.get(change.name)
        if wanted == 'double' and change.type_ == RosParameter.Type.INTEGER:
            change = RosParameter(change.name, TYPES[wanted], float(change.value))
        elif wanted == 'double[]' and change.type_ == RosParameter.Type.INTEGER_ARRAY:
            change = RosParameter(change.name, TYPES[wanted], [float(v) for v in change.value])
        widened.append(change)
    return widened
