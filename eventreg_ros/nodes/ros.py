"""How a node's process starts, spins and ends."""

from __future__ import annotations

import ctypes
import inspect
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import rclpy
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.task import Future
from rclpy.utilities import get_default_context

from ..errors import EventregError
from ..scenario.names import KINDS
from ..scenario.parameters import parameters_of
from .executables import answer, own_words

RCLError: type[Exception] = rclpy_implementation.RCLError
UnknownROSArgsError: type[Exception] = rclpy_implementation.UnknownROSArgsError

_PR_SET_TIMERSLACK = 29
_ENDING = (signal.SIGINT, signal.SIGTERM)

_PATIENCE = 3600.0
"""Seconds per wait: the EventsExecutor of Jazzy hangs in an endless one."""


def make_executor(context: Any = None) -> Any:
    """Return the EventsExecutor, or the default executor where rclpy does not have it."""
    try:
        from rclpy.experimental.events_executor import EventsExecutor
    except ImportError:
        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)


def spin(executor: Any, context: Any = None) -> None:
    """Run the callbacks of ``executor`` until its context is shut down."""
    never = Future()
    while (context or get_default_context()).ok():
        executor.spin_until_future_complete(never, _PATIENCE)


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
        name, what = Path(program).stem, inspect.getdoc(sys.modules[make.__module__])
        rows = parameters_of(name).values() if name in KINDS else getattr(make, 'parameters', ())
        return answer(words[0], name, what, rows)
    return run_nodes([make], args)


def run_nodes(makes: Sequence[Callable[[], Any]], args: Sequence[str] | None = None) -> int:
    """Run several nodes in one executor; otherwise as :func:`run_node`."""
    stopped = _note_signals()
    _wake_promptly()
    try:
        rclpy.init(args=list(args) if args is not None else None)
    except Exception as error:
        what = 'unknown ROS arguments ' if isinstance(error, UnknownROSArgsError) else ''
        return 0 if stopped else _fail(what + str(error).split(', at ')[0])
    nodes: list[Any] = []
    try:
        _live(nodes, makes, stopped)
    except (EventregError, InvalidParameterTypeException) as error:
        return _fail(str(error))
    except RCLError:
        if not stopped:  # a signal shut the context down under a call that was on its way
            raise
    finally:
        for node in nodes:
            node.close()
        get_default_context().try_shutdown()
        # Python's own handlers go as it ends, ros2 launch signals once more by then: ignore it.
        for each in _ENDING:
            signal.signal(each, signal.SIG_IGN)
    return 0


def _live(nodes: list[Any], makes: Sequence[Callable[[], Any]], stopped: list[int]) -> None:
    """Make the nodes, put them on ``nodes``, start them, and spin until the context ends."""
    executor = make_executor()
    for make in makes:
        nodes.append(make())
        executor.add_node(nodes[-1])
    try:
        for node in nodes:
            node.bring_up()
        if not stopped:
            spin(executor)
    except ExternalShutdownException:
        pass


def _wake_promptly() -> None:
    """Ask Linux not to put off timers of this process by its usual 50 us."""
    if sys.platform.startswith('linux'):
        ctypes.CDLL(None).prctl(_PR_SET_TIMERSLACK, 1)


def _note_signals() -> list[int]:
    """Return a list that SIGINT and SIGTERM are noted in, instead of ending the process.

    rclpy sets its own handlers on top and shuts its context down; ours remain below, since a
    second signal, as ros2 launch sends one, must not break into the closing of a bag.
    """
    noted: list[int] = []
    for each in _ENDING:
        signal.signal(each, lambda number, _: noted.append(number))
    return noted


def _fail(message: str) -> int:
    print(f'eventreg_ros: {" ".join(message.split())}', file=sys.stderr)
    return 2
