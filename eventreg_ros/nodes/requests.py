# SPDX-License-Identifier: Apache-2.0
"""Requests to the parameter services of a node: what is wrong is refused in our words.

rclpy lets its error, for a value of a type that does not exist say, end the executor, and with it
the node. What it refuses it refuses in words that do not help.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.parameter import Parameter as RosParameter

from ..errors import described, one_line

Answer = Callable[[Any, Any], Any]
Check = Callable[[Sequence[RosParameter]], SetParametersResult]


def check_requests(node: Any, check: Check) -> None:
    """Let the services that set parameters of ``node`` refuse what ``check`` does, or rclpy."""
    for service in node.services:
        if service.srv_type is SetParameters:
            service.callback = _each(service.callback, check)
        elif service.srv_type is SetParametersAtomically:
            service.callback = _together(service.callback, check)


def _checked(request: Any, check: Check) -> SetParametersResult:
    return check([RosParameter.from_parameter_msg(each) for each in request.parameters])


def _each(callback: Answer, check: Check) -> Answer:
    """Return ``callback`` of set_parameters, which answers for every parameter by itself."""

    def answer(request: Any, response: Any) -> Any:
        for parameter in request.parameters:
            one = SetParameters.Request(parameters=[parameter])
            try:
                result = _checked(one, check)
                if result.successful:
                    (result,) = callback(one, SetParameters.Response()).results
                response.results.append(result)
            except Exception as error:
                response.results.append(_unreadable(error))
        return response

    return answer


def _together(callback: Answer, check: Check) -> Answer:
    """Return ``callback`` of set_parameters_atomically, which answers whatever is asked."""

    def answer(request: Any, response: Any) -> Any:
        try:
            response.result = _checked(request, check)
            return callback(request, response) if response.result.successful else response
        except Exception as error:
            response.result = _unreadable(error)
            return response

    return answer


def _unreadable(error: Exception) -> SetParametersResult:
    return refusal(f'the request cannot be read: {described(error)}')


def refusal(reason: object) -> SetParametersResult:
    """Return the answer that refuses parameters, with the reason in one line."""
    return SetParametersResult(successful=False, reason=one_line(reason))
