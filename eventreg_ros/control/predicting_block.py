# SPDX-License-Identifier: Apache-2.0
"""A predicting controller as a node runs it: the steps of the sampled loop, on what it heard."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from ..models import Params
from ..simulation.block import BlockSpec, learned, retuned
from ..simulation.numbered import Numbered, Reader
from ..simulation.step import plain
from .predictor import Foresight

SPARE = 64
"""Samples that are kept beyond those that the predictor may ask for."""


class Heard(NamedTuple):
    """A sample of input ``i``, by the step at which it was made."""

    i: int
    number: int
    value: float


class PredictingBlock:
    """The state of a predicting controller; see :class:`..simulation.block.Block`."""

    def __init__(self, spec: BlockSpec) -> None:
        self.spec = spec
        self.start(0)

    def start(self, n: int) -> None:
        """Begin at step ``n`` from x0, with nothing heard and nothing published."""
        self._n, tuning = n, self._tuned()
        self.x, self.y = self._numbered.begin(self.spec, n)
        size = 2 * tuning.lead + tuning.patience + SPARE
        self._past = _Past(len(self.spec.inputs), size, n)
        self.keep(n, self.y)

    @property
    def _numbered(self) -> Numbered:
        assert self.spec.numbered is not None
        return self.spec.numbered

    def _tuned(self) -> Foresight:
        """Take over the spec's numbers and model; return the numbers."""
        readers = [_reader(i) for i in range(len(self.spec.inputs))]
        self._advance = self._numbered.make(self.spec.model, readers, _own, plain)
        tuning: Foresight = self._numbered.tuning(self.spec)
        self._tuning = tuning
        return tuning

    def retune(self, spec: BlockSpec) -> None:
        """Take over other parameters, and go on from the present state.

        Another length of a step, or another lead, makes all that is remembered worthless: it begins
        anew, but with what it has learned.
        """
        before = self._tuning
        self.x, self.spec = retuned(self.x, self.spec, spec), spec
        after = self._tuned()
        if (before.lead, before.coarse) != (after.lead, after.coarse):
            self.restart(self._n)

    def restart(self, n: int) -> None:
        """Begin anew with the sample after ``n``, but with what was learned."""
        given = self.spec
        x0 = (*given.x0[: given.model.own], *self.learned.values())
        self.spec = replace(given, x0=x0)
        self.start(n + 1)
        self.spec = given

    @property
    def params(self) -> Params:
        """The parameters of the copy."""
        return self._tuning.copy

    @params.setter
    def params(self, params: Params) -> None:
        self._tuning = self._tuning._replace(copy=params)

    @property
    def learned(self) -> dict[str, float]:
        """The present values of the parameters that the model learns, by name."""
        return learned(self.spec, self.x)

    @property
    def newest(self) -> list[int]:
        """The number of the last sample of each input, -1 for none."""
        return self._past.newest

    def advance(self, n: int, heard: Sequence[Heard]) -> float:
        """Take the step from ``n`` with what was heard since the last one; return sample n + 1."""
        for sample in heard:
            self._past.hear(sample)
        self._n = n + 1
        self.x, self.y = self._advance(n, self.x, self._tuning, self.spec.h, self._past)
        self.keep(n + 1, self.y)
        return self.y

    def keep(self, n: int, value: float) -> None:
        """Note what receivers make of sample ``n`` of the output, where it is coded."""
        self._past.own[n % self._past.size] = value


class _Past:
    """The last samples of all inputs and of the output, each at its number modulo the size."""

    def __init__(self, inputs: int, size: int, since: int) -> None:
        self.size, self.since = size, since
        self.newest = [-1] * inputs
        self.numbers = [[-1] * size for _ in range(inputs)]
        self.values = [[0.0] * size for _ in range(inputs)]
        self.own = [0.0] * size

    def hear(self, sample: Heard) -> None:
        i, number, value = sample
        if number >= self.since and number > self.newest[i] - self.size:
            self.numbers[i][number % self.size] = number
            self.values[i][number % self.size] = value
            self.newest[i] = max(self.newest[i], number)


def _own(s: int, past: _Past) -> float:
    return past.own[s % past.size]


def _reader(i: int) -> Reader:
    """Return how input ``i`` is read from the past."""

    def newest(n: int, past: _Past) -> int:
        return past.newest[i]

    def last(s: int, past: _Past) -> int:
        numbers, size = past.numbers[i], past.size
        oldest = max(past.since, past.newest[i] - size + 1)
        while s >= oldest:
            if numbers[s % size] == s:
                return s
            s -= 1
        return -1

    def value(s: int, past: _Past) -> float:
        return past.values[i][s % past.size]

    return Reader(newest, last, value)
