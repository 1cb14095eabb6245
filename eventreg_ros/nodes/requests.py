# SPDX-License-Identifier: Apache-2.0
"""Requests to the parameter services of a node: one that rclpy cannot read is refused.

rclpy lets its error, for a value of a type that does not exist say, end the executor, and with it
the node.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters, SetParametersAtomically

from ..errors import described, one_line

Answer = Callable[[Any, Any], Any]


def refuse_unreadable(node: Any) -> None:
    """Let the services that set parameters of ``node`` refuse what they cannot read."""
    for service in node.services:
        if service.srv_type is SetParameters:
            service.callback = _each(service.callback)
        elif service.srv_type is SetParametersAtomically:
            service.callback = _together(service.callback)


def _each(callback: Answer) -> Answer:
    """Return ``callback`` of set_parameters, which answers for every parameter by itself."""

    def answer(request: Any, response: Any) -> Any:
        for parameter in request.parameters:
            one = SetParameters.Request(parameters=[parameter])
            try:
                response.results += callback(one, SetParameters.Response()).results
            except Exception as error:
                response.results.append(_unreadable(error))
        return response

    return answer


def _together(callback: Answer) -> Answer:
    """Return ``callback`` of set_parameters_atomically, which answers whatever is asked."""

    def answer(request: Any, response: Any) -> Any:
        try:
            return callback(request, response)
        except Exception as error:
            response.result = _unreadable(error)
            return response

    return answer


def _unreadable(error: Exception) -> SetParametersResult:
    return refusal(f'the request cannot be read: {described(error)}')


def refusal(reason: object) -> SetParametersResult:
    """Return the answer that refuses parameters, with the reason in one line."""
    return SetParametersResult(successful=False, reason=one_line(reason))
