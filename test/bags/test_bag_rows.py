# SPDX-License-Identifier: Apache-2.0
"""Rows written at once are the same file as their messages written one by one."""

import pytest

from eventreg_ros.bags.channel import FLOAT64
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.bags.writer import BagWriter
from eventreg_ros.runtime.cdr import packed

ROWS = 20_000  # more than a chunk
STAMPS = [5_000_000 * n for n in range(ROWS)]
COLUMNS = {
    f'/{name}': [packed(sign * n) for n in range(ROWS)] for name, sign in (('w', 1), ('y', -1))
}


@pytest.mark.parametrize(('storage', 'ending'), [('mcap', '.mcap'), ('sqlite3', '.db3')])
def test_rows_are_the_messages_one_by_one(tmp_path, storage, ending):
    for way in ('single', 'rows'):
        (tmp_path / way).mkdir()
        writer = BagWriter(tmp_path / way / 'bag', storage, None, None)
        for topic in COLUMNS:
            writer.add(topic, FLOAT64)
        if way == 'single':
            for i, stamp in enumerate(STAMPS):
                for topic, column in COLUMNS.items():
                    writer.write(topic, stamp, column[i])
        else:
            writer.write_rows(list(COLUMNS), [], [[], []])
            for i in range(0, ROWS, 16):
                columns = [column[i : i + 16] for column in COLUMNS.values()]
                writer.write_rows(list(COLUMNS), STAMPS[i : i + 16], columns)
        writer.close()
    single, rows = (read_bag(tmp_path / way / 'bag') for way in ('single', 'rows'))
    assert set(single.signals) == set(rows.signals) == {'w', 'y'}
    for name in single.signals:
        for one, other in zip(single.signals[name], rows.signals[name], strict=True):
            assert one.tolist() == other.tolist()
    if ending == '.mcap':
        texts = [
            (tmp_path / way / 'bag' / 'metadata.yaml').read_text() for way in ('single', 'rows')
        ]
        assert texts[0] == texts[1]


def test_rows_that_fit_a_chunk_give_the_same_bytes(tmp_path):
    for way in ('single', 'rows'):
        (tmp_path / way).mkdir()
        writer = BagWriter(tmp_path / way / 'bag', 'mcap', None, None)
        for topic in COLUMNS:
            writer.add(topic, FLOAT64)
        if way == 'rows':
            writer.write_rows(list(COLUMNS), STAMPS[:100], [c[:100] for c in COLUMNS.values()])
        else:
            for i in range(100):
                for topic, column in COLUMNS.items():
                    writer.write(topic, STAMPS[i], column[i])
        writer.close()
    one, other = ((tmp_path / way / 'bag' / 'bag.mcap').read_bytes() for way in ('single', 'rows'))
    assert one == other
