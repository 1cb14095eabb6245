# SPDX-License-Identifier: Apache-2.0
"""Damaged bags: no traceback, and no other samples without a word, where there are checksums."""

import importlib.util
import shutil
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from eventreg_ros.bags.reader import read_bag

BENCH = Path(__file__).resolve().parents[2] / 'bench' / 'damaged.py'
COUNT = 60


@pytest.fixture(scope='module', name='bench')
def _bench():
    """The benchmark, which does the same 500 times."""
    spec = importlib.util.spec_from_file_location('damaged', BENCH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize('storage', ['mcap, checksums', 'mcap, none', 'sqlite3'])
def test_damage_is_reported_or_did_nothing(tmp_path, bench, storage):
    file = bench.make(tmp_path, storage)
    sound, good = read_bag(file.parent), file.read_bytes()
    rng = np.random.default_rng(2026)
    results = Counter()
    for i in range(COUNT // 3):
        bag = tmp_path / 'damaged'
        shutil.copytree(file.parent, bag)
        if i % 2:
            (bag / 'metadata.yaml').unlink()
        (bag / file.name).write_bytes(bench.damage(good, rng))
        results[bench.judge(bag, sound)] += 1
        shutil.rmtree(bag)
    assert results['CRASH'] == 0
    assert results['SILENT'] <= (0 if storage == 'mcap, checksums' else 3)
    assert results['a finding'] >= COUNT // 3 - 8
