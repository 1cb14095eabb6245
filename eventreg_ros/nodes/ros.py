# SPDX-License-Identifier: Apache-2.0
"""How a node's process starts, spins and ends."""

from __future__ import annotations

import ctypes
import inspect
import os
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import rclpy
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import get_default_context

from ..errors import EventregError, complain, confess
from ..scenario.names import KINDS
from ..scenario.parameter import Parameter
from ..scenario.parameters import parameters_of
from . import environment
from .ending import Ending
from .executables import answer, own_words
from .given import as_meant, check_values, refusal

RCLError: type[Exception] = rclpy_implementation.RCLError
UnknownROSArgsError: type[Exception] = rclpy_implementation.UnknownROSArgsError

_PR_SET_TIMERSLACK = 29

_PATIENCE = 3600.0
"""Seconds per wait: the EventsExecutor of Jazzy hangs in an endless one."""


def make_executor(context: Any = None) -> Any:
    """Return the EventsExecutor, or the default executor where rclpy does not have it."""
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)


def spin(executor: Any, ending: Ending) -> None:
    """Run the callbacks of ``executor`` until a signal comes, or its context is shut down."""
    end = Future()
    ending.call(lambda: end.set_result(None))
    while get_default_context().ok() and not end.done():
        executor.spin_until_future_complete(end, _PATIENCE)


def with_info(callback: Callable[[Any, dict[str, Any]], None]) -> Callable[..., None]:
    """Return a subscription callback that gets the message and its info from any executor.

    The EventsExecutor of Jazzy hands both over as one tuple, whereas rclpy looks at the signature
    to see whether two are wanted.
    """

    def receive(*arguments: Any) -> None:
        message, info = arguments if len(arguments) == 2 else arguments[0]
        callback(message, info)

    receive.__signature__ = inspect.signature(callback)  # type: ignore[attr-defined]
    return receive


def run_node(make: Callable[[], Any], args: Sequence[str] | None = None) -> int:
    """Run one node until SIGINT or SIGTERM and return the exit code of its process.

    0 after a clean end or --help, 2 and one line after bad arguments or parameters.
    """
    program, *arguments = sys.argv if args is None else args
    if words := own_words(arguments):
        name = Path(program).stem
        what = inspect.getdoc(sys.modules[make.__module__]) or inspect.getdoc(make)
        own: Iterable[Parameter] = getattr(make, 'all_parameters', tuple)()
        return answer(words[0], name, what, parameters_of(name).values() if name in KINDS else own)
    return run_nodes([make], args)


def run_nodes(makes: Sequence[Callable[[], Any]], args: Sequence[str] | None = None) -> int:
    """Run several nodes in one executor; otherwise as :func:`run_node`."""
    ending = Ending()
    _wake_promptly()
    nodes: list[Any] = []
    code = 0
    try:
        _init(list(sys.argv if args is None else args))
        _live(nodes, makes, ending)
    except Exception as error:
        code = 0 if ending.asked or _was_shut_down() else _refuse(error)
    finally:
        code = _close(nodes) or code
        get_default_context().try_shutdown()
        ending.over()
    return code


def _close(nodes: Sequence[Any]) -> int:
    """Close all nodes, whatever one of them raises; return the exit code of that, or 0."""
    code = 0
    # The recorder first: what the others say last is no part of the run.
    for node in sorted(nodes, key=lambda node: getattr(node, 'kind', '') != 'recorder'):
        try:
            node.close()
        except Exception as error:
            code = _refuse(error)
    return code


def _init(arguments: list[str]) -> None:
    """Initialise rclpy. Raises EventregError when it refuses the arguments or the environment."""
    environment.check(os.environ)
    environment.check_security(os.environ)
    check_values(arguments)
    with as_meant(arguments) as meant:
        try:
            rclpy.init(args=meant, signal_handler_options=SignalHandlerOptions.NO)
        except Exception as error:
            what = 'unknown ROS arguments ' if isinstance(error, UnknownROSArgsError) else ''
            why = refusal(arguments) or what + str(error).split(', at ')[0]
            raise EventregError(why) from None


def _was_shut_down() -> bool:
    """Say whether rclpy was up and is no more."""
    context = get_default_context()
    return context.handle is not None and not context.ok()


def _refuse(error: Exception) -> int:
    if isinstance(error, EventregError | InvalidParameterTypeException):
        return complain('eventreg_ros', error)
    if isinstance(error, RCLError):  # the middleware, the environment
        return complain('eventreg_ros', str(error).split(', at ')[0])
    return confess('eventreg_ros', error)


def _live(nodes: list[Any], makes: Sequence[Callable[[], Any]], ending: Ending) -> None:
    """Make the nodes, put them on ``nodes``, start them, and spin until a signal comes."""
    executor = make_executor()
    for make in makes:
        if ending.asked:
            return
        nodes.append(make())
        executor.add_node(nodes[-1])
    try:
        for node in nodes:
            if not ending.asked:
                node.bring_up()
        spin(executor, ending)
    except ExternalShutdownException:
        pass


def _wake_promptly() -> None:
    """Ask Linux not to put off timers of this process by its usual 50 us."""
    if sys.platform.startswith('linux'):
        ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, 1)
