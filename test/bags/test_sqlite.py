# SPDX-License-Identifier: Apache-2.0
"""The pages of databases against SQL, damaged ones, and what lies about."""

import sqlite3

import numpy as np
import pytest

from eventreg_ros.bags.channel import each
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.bags.sqlite_file import read_sqlite
from eventreg_ros.bags.sqlite_pages import varints
from eventreg_ros.errors import BagError

START = 1_795_304_457_727_915_003


class Keeper:
    """Keeps stamps and bytes of messages."""

    def __init__(self):
        self.found = []

    def expect(self, count):
        pass

    def take(self, messages):
        assert messages.publish is None
        parts = sorted(pair for group in messages.groups for pair in each(group))
        self.found += zip(messages.log.tolist(), [data for _, data in parts], strict=True)


def by_pages(path):
    """The messages of every topic as the reader hands them on, and its account."""
    keepers = {}
    account = read_sqlite(path, lambda channel: keepers.setdefault(channel.topic, Keeper()))
    return {topic: keeper.found for topic, keeper in keepers.items()}, account


def by_sql(path):
    """The same by SQL, in the order of the rows."""
    query = 'SELECT name, timestamp, data FROM messages, topics WHERE topics.id = topic_id'
    found = {}
    connection = sqlite3.connect(path)
    for topic, stamp, data in connection.execute(query + ' ORDER BY messages.id'):
        found.setdefault(topic, []).append((stamp, data))
    connection.close()
    return found


@pytest.mark.parametrize('page_size', [512, 1024, 4096, 32768, 65536])
@pytest.mark.parametrize('seed', [0, 1])
def test_the_pages_say_what_sql_says(tmp_path, database, page_size, seed):
    rng = np.random.default_rng(seed)
    stamps = [
        0,
        1,
        -1,
        127,
        128,
        2**15,
        2**23,
        -(2**31),
        2**40,
        2**47 + 1,
        START,
        -START,
        2**63 - 1,
    ]
    rows = []
    for i in range(3000):
        size = int(
            rng.choice(
                [0, 1, 12, 12, 12, 57, 58, 59, 400, 5000, 70_000],
                p=[0.05, 0.05, 0.3, 0.2, 0.2, 0.05, 0.05, 0.04, 0.04, 0.015, 0.005],
            )
        )
        topic = f'/topic_{int(rng.integers(0, 300)) if i % 2 else 1}'
        rows.append((topic, int(rng.choice(stamps)), rng.bytes(size)))
    path = database(tmp_path / 'bag.db3', rows, page_size=page_size)
    found, account = by_pages(path)
    assert found == by_sql(path)
    assert account.notes == []


def test_rows_that_were_deleted_and_changed_are_gone(tmp_path, database, float64):
    rows = [('/y', START + i, float64(float(i))) for i in range(5000)]
    path = database(
        tmp_path / 'bag.db3', rows,
        extra=(
            'DELETE FROM messages WHERE id % 3 = 0',
            'UPDATE messages SET timestamp = 5 WHERE id = 7',
        ),
    )  # fmt: skip
    found, account = by_pages(path)
    assert found == by_sql(path)
    assert account.notes == []


def test_numbers_of_varying_length():
    data = np.frombuffer(bytes.fromhex('00 7f 8100 8180 00 ffff7f').ljust(16, b'\0'), np.uint8)
    values, after = varints(data, np.array([0, 1, 2, 4, 7]))
    assert values.tolist() == [0, 127, 128, 16384, 2**21 - 1]
    assert after.tolist() == [1, 2, 4, 7, 10]


@pytest.fixture(name='good')
def _good(tmp_path, database, float64):
    rows = [(t, START + 1000 * i, float64(float(i))) for i in range(4000) for t in ('/w', '/y')]
    return database(tmp_path / 'bag.db3', rows)


def pages_of(path, kind):
    """The numbers of all pages whose first byte is ``kind``."""
    data = path.read_bytes()
    return [n for n in range(2, len(data) // 4096 + 1) if data[(n - 1) * 4096] == kind]


def overwrite(path, page, data, at=0):
    with path.open('r+b') as file:
        file.seek((page - 1) * 4096 + at)
        file.write(data)


@pytest.mark.slow
def test_a_page_of_rows_that_is_zeroed_costs_its_rows(good):
    whole = by_sql(good)
    leaves = pages_of(good, 0x0D)
    overwrite(good, leaves[len(leaves) // 2], bytes(4096))
    found, account = by_pages(good)
    for topic in ('/w', '/y'):
        assert set(found[topic]) < set(whole[topic])
        assert len(found[topic]) > len(whole[topic]) - 80
    assert [note.code for note in account.notes] == ['damaged', 'lost-samples']
    lost = account.notes[1]
    read = sum(map(len, found.values()))
    assert f'{read} of 8000 rows' in lost.text
    before = max(
        s
        for s, _ in found['/w']
        if s + 1000 not in {s for s, _ in found['/w']} and s < max(found['/w'])[0]
    )
    assert abs(lost.stamp - before) <= 1000


def test_a_page_that_leads_to_others_costs_nothing(good):
    whole = by_sql(good)
    (root,) = (
        r
        for (r,) in sqlite3.connect(good).execute(
            "SELECT rootpage FROM sqlite_master WHERE name = 'messages'"
        )
    )
    overwrite(good, root, bytes(4096))
    found, account = by_pages(good)
    assert {topic: sorted(rows) for topic, rows in found.items()} == whole
    assert 'damaged' in {note.code for note in account.notes}


def test_a_file_that_was_cut_gives_what_is_left(good):
    whole = by_sql(good)
    data = good.read_bytes()
    good.write_bytes(data[: len(data) // 2])
    found, account = by_pages(good)
    assert len(found['/w']) > 1000
    assert set(found['/w']) < set(whole['/w'])
    assert {note.code for note in account.notes} >= {'damaged'}


def test_an_index_that_disagrees_is_reported_and_the_rows_are_read(good):
    whole = by_sql(good)
    page = pages_of(good, 0x0A)[3]
    data = good.read_bytes()[(page - 1) * 4096 : page * 4096]
    place = data.rindex((START + 1000).to_bytes(8, 'big')[:4])
    overwrite(good, page, b'\x19', place)
    found, account = by_pages(good)
    assert found == whole
    assert [note.code for note in account.notes] == ['index-disagrees']


def test_cell_pointers_that_lead_astray_cost_their_rows(good):
    whole = by_sql(good)
    page = pages_of(good, 0x0D)[4]
    overwrite(good, page, b'\xff\xff\x00\x01\x0f\xff', 8)
    found, account = by_pages(good)
    assert sum(map(len, found.values())) >= 8000 - 3
    assert all(set(found[topic]) <= set(whole[topic]) for topic in whole)
    assert [note.code for note in account.notes] == ['damaged', 'lost-samples']


def test_columns_that_a_row_has_behind_its_page_cost_the_row(tmp_path):
    connection = sqlite3.connect(tmp_path / 'it.db3')
    connection.execute(
        'CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format)'
    )
    connection.execute(
        'CREATE TABLE messages(id INTEGER PRIMARY KEY, data BLOB, topic_id, timestamp)'
    )
    connection.execute("INSERT INTO topics VALUES (7, '/y', 'std_msgs/msg/Float64', 'cdr')")
    sizes = [12, 200_000, 12]
    rows = [(bytes(size), 7, START + i) for i, size in enumerate(sizes)]
    insert = 'INSERT INTO messages (data, topic_id, timestamp) VALUES (?, ?, ?)'
    connection.executemany(insert, rows)
    connection.commit()
    connection.close()
    found, account = by_pages(tmp_path / 'it.db3')
    assert {*found['/y']} <= {(START, bytes(12)), (START + 2, bytes(12))}
    assert 'damaged' in [note.code for note in account.notes]


@pytest.mark.parametrize(
    'statements',
    [
        ['CREATE VIEW messages AS WITH RECURSIVE a(id) AS '
         '(SELECT 1 UNION ALL SELECT id + 1 FROM a) '
         "SELECT id, 1 AS topic_id, id AS timestamp, x'00' AS data FROM a",
         'CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format)'],
        ['CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id, timestamp, data)'],
        ['CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format)'],
        ['CREATE TABLE other(a)'],
    ],
)  # fmt: skip
def test_a_database_that_is_no_bag_is_refused_at_once(tmp_path, statements):
    connection = sqlite3.connect(tmp_path / 'bag.db3')
    for statement in statements:
        connection.execute(statement)
    connection.commit()
    connection.close()
    with pytest.raises(BagError, match='cannot be read'):
        read_bag(tmp_path / 'bag.db3')


def test_a_page_that_leads_to_itself_ends(good):
    (root,) = (
        r
        for (r,) in sqlite3.connect(good).execute(
            "SELECT rootpage FROM sqlite_master WHERE name = 'messages'"
        )
    )
    data = good.read_bytes()[(root - 1) * 4096 : root * 4096]
    count = int.from_bytes(data[3:5], 'big')
    for i in range(count):
        place = int.from_bytes(data[12 + 2 * i : 14 + 2 * i], 'big')
        overwrite(good, root, root.to_bytes(4, 'big'), place)
    found, account = by_pages(good)
    assert account.notes != []
    assert sum(map(len, found.values())) == 8000
