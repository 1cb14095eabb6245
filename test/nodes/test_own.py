# SPDX-License-Identifier: Apache-2.0
"""Blocks of one's own whose code raises: the node goes through its fault state, and lives on."""

import pytest

from eventreg_ros.nodes.own import OwnBlock


class Failing(OwnBlock):
    """Divides by zero at its third step."""

    def start(self):
        self.left = 3
        return 0.0

    def advance(self, inputs, h):
        self.left -= 1
        return 1.0 / self.left


class Startless(OwnBlock):
    """Has forgotten to return its first output."""

    def start(self):
        return None


@pytest.mark.parametrize(
    ('block', 'words'),
    [
        (Failing, 'Failing.advance failed at step 3: ZeroDivisionError: float division by zero'),
        (Startless, 'Startless.start failed at step 0: TypeError'),
    ],
)
def test_an_exception_becomes_the_fault_of_the_node(bench, block, words):
    node = bench.add(block)
    bench.until(lambda: node.fault is not None)
    assert words in node.fault
    bench.until(lambda: node.stage == 'unconfigured')
