# SPDX-License-Identifier: Apache-2.0
"""A node that publishes one signal, sample by sample, and hears any number of others."""

from __future__ import annotations

import math
from collections.abc import Callable

from ..runtime.cdr import packed
from ..scenario.inputs import delays_of, signs_of
from ..scenario.parameter import ACTIVE, UNCONFIGURED
from ..simulation.block import leads_of
from ..simulation.hold import horizon_in_steps
from ..simulation.model_time import steps_of
from .lead import Lead
from .lockstep import Lockstep, Participant
from .managed import OK, WARN, FaultError, ManagedNode, Status
from .pace import Inputs, Lines, Pace, Tick
from .realtime import RealTime, Timing
from .sequenced import Schedule, SequencedInputs
from .stamped import DelayMargin, StampedInputs
from .topics import signal_topic


class SignalNode(ManagedNode):
    """Publishes sample n of ``output`` when its pace says so: the clock's, or lockstep's.

    A subclass gives ``initial() -> value`` and ``step(n, lines) -> value``, from sample n to the
    next.
    """

    pace: Pace | None = None
    inputs: Inputs
    off = False
    """In lockstep: whether the node is switched off, so that it publishes 0."""
    cut_off = 0
    """Samples of the output that output_limit cut off."""
    _reported_cut_off = 0
    starting = False
    """In lockstep: whether it was just switched on again, so that it starts anew."""

    def initial(self) -> float:
        """Return sample 0."""
        raise NotImplementedError

    def step(self, n: int, lines: Lines) -> float:
        """Take the step from sample ``n``, with the inputs over it, and return the next sample."""
        raise NotImplementedError

    @property
    def signs(self) -> tuple[tuple[str, float], ...]:
        """The inputs with their signs, in the order in which they are summed."""
        return signs_of(self.values)

    @property
    def h(self) -> float:
        """The length of a step in model time."""
        return float(self.values['time_scale'] / self.values['rate'])

    @property
    def n(self) -> int:
        """The number of the newest sample; -1 before the first."""
        return self.pace.n if self.pace is not None else -1

    def open(self) -> None:
        """Create the publisher of the output and the subscriptions of the inputs."""
        self.pace = None
        lockstep = self.values['lockstep']
        topic = signal_topic(lockstep)
        self.publisher = self.advertise(topic, self.values['output'], always=lockstep)
        self.inputs = self._make_inputs()
        # Nobody need be woken by a sample: in real time it is used at the next tick. In simulation
        # time it counts from its arrival, and in lockstep a step may wait for it.
        polled = not (lockstep or self.in_simulation_time)
        for i, signal in enumerate(self.inputs.signals):
            self.subscribe(topic, signal, self.inputs.receiver(i, self._go), polled=polled)

    @property
    def lead(self) -> Lead:
        """By how much u is ahead of its stamps; 0 for a node that it does not concern."""
        given, h = self.values.get('lead', 0.0), self.h
        return Lead(steps_of(given, h), h, self.values['time_scale'])

    def _schedules(self) -> dict[str, Schedule]:
        """Return when the samples of each input come (in lockstep) and when they are played."""
        delays = delays_of(self.values)
        leads = leads_of(self.kind, self.signs, self.lead.steps)
        return {
            signal: Schedule(steps_of(delays.get(signal, 0.0), self.h), lead)
            for (signal, _), lead in zip(self.signs, leads, strict=True)
        }

    def _make_inputs(self) -> Inputs:
        schedules = self._schedules()
        if self.values['lockstep']:
            return SequencedInputs(schedules)
        waiting = [signal for signal, schedule in schedules.items() if schedule.lead]
        return StampedInputs(tuple(schedules), self, waiting)

    def _tune_inputs(self) -> None:
        """Hand on the parameters that the inputs need."""
        values, inputs = self.values, self.inputs
        if 'hold' not in values:
            return  # a node without inputs
        inputs.horizon = horizon_in_steps(values['hold'], self.h)
        if isinstance(inputs, StampedInputs):
            inputs.timeout = values['input_timeout']
            inputs.limit(values['input_limit'])
            inputs.play_after(self.lead)
            own = 'delay_margin' if values['hold'] == 'linear' else 'delay_margin_zero'
            margin, warn = values[own], values['delay_warn']
            inputs.margin = DelayMargin(margin, warn, values['time_scale'], self.h)

    def begin(self) -> None:
        """Start at sample 0; on leaving, the output goes to 0.

        In lockstep, where the others wait for every sample, a node that is switched off goes on
        publishing 0, and its samples go on to be numbered when it is switched on again.
        """
        self._tune_inputs()
        if self.values['lockstep']:
            self._begin_lockstep()
            return
        self.stack.callback(self.send, self.publisher, packed(0.0))
        timing = Timing(*(self.values[name] for name in Timing._fields))
        self.pace = RealTime(self, timing, self)
        self.pace.begin()

    def _begin_lockstep(self) -> None:
        self.off, self.starting = False, self.pace is not None
        self.stack.callback(self._switch_off)
        if self.pace is None:
            with self.until_cleanup():
                self.pace = Lockstep(self, self.inputs, self._join)
                self.pace.begin()

    def _switch_off(self) -> None:
        self.off = True

    def _join(self, go: Callable[[], None]) -> Participant:
        assert isinstance(self.pace, Lockstep)
        return Participant(self, go, self.pace.missing)

    def _go(self) -> None:
        if self.stage != UNCONFIGURED and self.pace is not None:
            self.pace.go()

    def changed(self) -> None:
        """Take over the parameters of the inputs."""
        if self.stage == ACTIVE:
            self._tune_inputs()

    # What the pace asks for

    def first(self) -> float:
        """Return sample 0. Raises FaultError when it is not finite."""
        return self._sound(self.initial())

    def following(self, tick: Tick) -> float:
        """Take one step with the inputs as they are known at its beginning."""
        if self.off or self.starting:
            self.inputs.over(tick)  # the samples are used up all the same
            value = 0.0 if self.off else self._sound(self.initial())
            self.starting = False
            return value
        value = self._sound(self._next(tick))
        limit = self.values.get('output_limit')
        if limit and not -limit < value < limit:
            self.cut_off += 1
            return float(min(max(value, -limit), limit))
        return value

    def _next(self, tick: Tick) -> float:
        return self.step(tick.n, self.inputs.over(tick))

    def put(self, value: float) -> None:
        """Publish ``value``."""
        self.send(self.publisher, packed(value))

    def _sound(self, value: float) -> float:
        if not math.isfinite(value):
            raise FaultError(
                f'the state of {self.label} stopped being finite at step {self.n + 1}; '
                'lower time_scale or raise rate, and look at the inputs'
            )
        return value

    def _report_cut_off(self) -> list[Status]:
        more, self._reported_cut_off = self.cut_off - self._reported_cut_off, self.cut_off
        if not more:
            return []
        words = f'the output was cut off at {self.values["output_limit"]:g} in {more} samples'
        return [Status(WARN, words, {})]

    def report(self) -> Status:
        """Return the figures of pace and inputs; the worst of their findings is the level."""
        assert self.pace is not None
        pace = self.pace.report()
        found = [pace, *self.inputs.report(), *self._report_cut_off()]
        values = {key: value for each in found for key, value in each.values.items()}
        findings = [each.message for each in found if each.level != OK]
        level = max(each.level for each in found)
        return Status(level, '; '.join(findings) or pace.message, values)
