# SPDX-License-Identifier: Apache-2.0
"""A .db3 file of rosbag2: what tables it has, which topics, and a writer's leavings beside it."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import ExitStack, closing
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np

from ..files import scratch_directory
from .channel import Account, Bytes, Channel, Index, Select, UnreadableError, absolute, full_type
from .metadata import custom_data
from .sqlite_pages import Layout
from .sqlite_rows import Rows
from .sqlite_table import Value, columns, rows

MAGIC = b'SQLite format 3\x00'
_JOURNAL_MAGIC = bytes.fromhex('d9d505f920a163d7')
_HEADER = 100
_USUAL = 4096
_NEEDED = {'topics': {'id', 'name', 'type'}, 'messages': {'topic_id', 'timestamp', 'data'}}


def read_sqlite(path: Path, select: Select) -> Account:
    """Hand the messages of a file to those who want them, in the order of their row ids.

    Raises UnreadableError where it is no rosbag2, or its list of topics cannot be read.
    """
    with ExitStack() as stack:
        account = Account()
        file = stack.enter_context(_settled(path, account, stack).open('rb'))
        pages = FilePages(file)
        tables = _tables(pages)
        there = {name: set(table.columns) for name, table in tables.items()}
        if not all(needed <= there.get(name, set()) for name, needed in _NEEDED.items()):
            raise UnreadableError(
                f'{path} cannot be read: it is no rosbag2, or its list of tables is damaged; '
                f"'sqlite3 {path.name} .recover' may save some of it"
            )
        channels = _channels(pages, tables)
        account.channels = list(channels.values())
        for _, row in _rows(pages, tables.get('metadata')):
            account.custom.update(custom_data(str(row.get('metadata'))))
        reading = Rows(path.name, pages.read, pages.layout, tables['messages'].columns, account)
        reading.run(tables['messages'].root, _index(tables), channels, select)
        return account


class FilePages:
    """The pages of a file, by number."""

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        head = file.read(_HEADER).ljust(_HEADER, b'\0')
        size = int.from_bytes(head[16:18], 'big')
        size = 65536 if size == 1 else size
        if size < 512 or size & (size - 1):  # damaged: rosbag2 has it at that
            size = _USUAL
        self.layout = Layout(size, head[20] if head[20] < 64 else 0, file.seek(0, 2) // size)

    def read(self, numbers: Index) -> Bytes:
        """Return pages, shape (n, page size), zeros where there is none."""
        if not len(numbers):
            return np.empty((0, self.layout.size), np.uint8)
        low, high = int(numbers.min()), int(numbers.max())
        if high - low < 3 * len(numbers) + 16:
            return self._span(low, high - low + 1)[numbers - low]
        return np.concatenate([self._span(number, 1) for number in numbers.tolist()])

    def _span(self, first: int, count: int) -> Bytes:
        size = self.layout.size
        self._file.seek((first - 1) * size)
        data = self._file.read(count * size)
        data = data[: len(data) // size * size]  # a page that was cut is none
        return np.frombuffer(data.ljust(count * size, b'\0'), np.uint8).reshape(count, size)


class _Table(NamedTuple):
    """A table or an index: the table it belongs to, its first page, its columns."""

    of: str
    root: int
    columns: list[str]


def _tables(pages: FilePages) -> dict[str, _Table]:
    """Return tables and indices by name; views and the like have no first page."""
    found = {}
    for _, row in rows(pages.read, pages.layout, 1):
        if len(row) == 5 and isinstance(row[3], int) and 0 < row[3] <= pages.layout.pages:
            name, statement = str(row[1]), str(row[4])
            plain = row[0] == 'index' or statement.upper().startswith('CREATE TABLE')
            found[name] = _Table(str(row[2]), row[3], columns(statement) if plain else [])
    return found


def _index(tables: dict[str, _Table]) -> int:
    """Return the first page of the index of the messages' stamps, 0 where there is none."""
    for name, table in tables.items():
        if name != 'messages' and table.of == 'messages' and table.columns == ['timestamp']:
            return table.root
    return 0


def _rows(pages: FilePages, table: _Table | None) -> Iterator[tuple[int, dict[str, Value]]]:
    """Yield the rows of a small table, with their ids."""
    if table is not None:
        for number, row in rows(pages.read, pages.layout, table.root):
            yield number, dict(zip(table.columns, row, strict=False))


def _channels(pages: FilePages, tables: dict[str, _Table]) -> dict[int, Channel]:
    """Return the topics by their ids."""
    definitions = {
        row.get('topic_type'): (
            str(row.get('encoded_message_definition')), str(row.get('encoding')),
        )
        for _, row in _rows(pages, tables.get('message_definitions'))
    }  # fmt: skip
    found = {}
    for number, row in _rows(pages, tables['topics']):
        topic, kind = absolute(str(row.get('name'))), str(row.get('type'))
        encoding = str(row.get('serialization_format') or 'cdr')
        definition = definitions.get(kind, ('', ''))
        found[number] = Channel(topic, full_type(kind), encoding, *definition)
    return found


# What a killed writer leaves --------------------------------------------------------------------


def _settled(path: Path, account: Account, stack: ExitStack) -> Path:
    """Return the file, or a copy that sqlite has set right where a killed writer left a journal."""
    journal, wal = (path.with_name(path.name + end) for end in ('-journal', '-wal'))
    beside = [journal] if _begins_with(journal, _JOURNAL_MAGIC) else []
    beside += [wal] if wal.is_file() and wal.stat().st_size else []
    if not beside:
        return path
    import shutil

    scratch = stack.enter_context(scratch_directory())
    for source in (path, *beside):
        shutil.copyfile(source, scratch / source.name)
    try:
        with closing(sqlite3.connect(scratch / path.name)) as connection:
            connection.execute('SELECT count(*) FROM sqlite_master').fetchone()
    except (sqlite3.Error, ValueError):
        return path
    account.note(
        'no-end', f'{path.name} was not closed: its writer was killed, or goes on; what was '
        'committed was read',
    )  # fmt: skip
    return scratch / path.name


def _begins_with(path: Path, magic: bytes) -> bool:
    if not path.is_file():
        return False
    with path.open('rb') as file:
        return file.read(len(magic)) == magic
