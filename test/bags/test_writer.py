# SPDX-License-Identifier: Apache-2.0
"""Bags that are written at once: whole or not at all."""

import errno
import os

import numpy as np
import pytest

from eventreg_ros.bags.mcap_writer import McapStorage
from eventreg_ros.bags.writer import write_bag
from eventreg_ros.errors import BagError

SIGNALS = {'y': ([1, 2], np.array([0.5, 1.5]))}


@pytest.mark.parametrize(
    ('error', 'raised', 'words'),
    [
        (OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)), BagError, 'written: no space left on'),
        (KeyboardInterrupt(), KeyboardInterrupt, '^$'),
    ],
    ids=['full', 'interrupted'],
)
@pytest.mark.parametrize('at', ['write_float64', 'close'])
def test_nothing_is_left_of_a_bag_that_cannot_be_finished(
    tmp_path, monkeypatch, at, error, raised, words
):
    def fail(*_):
        raise error

    monkeypatch.setattr(McapStorage, at, fail)
    with pytest.raises(raised, match=words):
        write_bag(tmp_path / 'bag', SIGNALS, 'made', '')
    assert list(tmp_path.iterdir()) == []


def test_a_bag_of_somebody_else_stays(tmp_path):
    write_bag(tmp_path / 'bag', SIGNALS, 'made', '')
    before = sorted(tmp_path.rglob('*'))
    with pytest.raises(BagError, match='exists already'):
        write_bag(tmp_path / 'bag', SIGNALS, 'made', '')
    assert sorted(tmp_path.rglob('*')) == before


def test_a_place_that_is_not_there_is_named_without_a_number(tmp_path):
    (tmp_path / 'file').touch()
    with pytest.raises(BagError, match=r'file/bag cannot be made: not a directory; name'):
        write_bag(tmp_path / 'file' / 'bag', SIGNALS, 'made', '')
