"""A .db3 file of rosbag2: its small tables by SQL, its messages from their pages."""

from __future__ import annotations

import sqlite3
from contextlib import ExitStack, closing, suppress
from pathlib import Path

from .channel import Account, Channel, Select, UnreadableError, absolute, full_type
from .metadata import custom_data
from .sqlite_rows import Rows, Tables

MAGIC = b'SQLite format 3\x00'
_JOURNAL_MAGIC = bytes.fromhex('d9d505f920a163d7')


def read_sqlite(path: Path, select: Select) -> Account:
    """Hand the messages of a file to those who want them, in the order of their row ids.

    Raises UnreadableError where it is no rosbag2, or its list of topics cannot be read.
    """
    with ExitStack() as stack:
        account = Account()
        file = _settled(path, account, stack)
        uri = f'{file.resolve().as_uri()}?mode=ro&immutable=1'
        try:
            connection = stack.enter_context(closing(sqlite3.connect(uri, uri=True)))
            connection.text_factory = lambda data: data.decode('utf-8', 'replace')
            tables = _tables(connection)
            channels = _channels(connection)
        except (sqlite3.Error, ValueError) as error:  # ValueError: names that are no text
            raise UnreadableError(
                f'{path} cannot be read: {error}; where sqlite3 is installed, '
                f"'sqlite3 {path.name} .recover' may save some of it"
            ) from None
        account.channels = list(channels.values())
        account.custom.update(_custom(connection))
        opened = stack.enter_context(file.open('rb'))
        Rows(path.name, opened, connection, tables, channels, account).run(select)
        return account


def _settled(path: Path, account: Account, stack: ExitStack) -> Path:
    """Return the file, or a copy that sqlite has set right where a killed writer left a journal."""
    journal, wal = (path.with_name(path.name + end) for end in ('-journal', '-wal'))
    beside = [journal] if _begins_with(journal, _JOURNAL_MAGIC) else []
    beside += [wal] if wal.is_file() and wal.stat().st_size else []
    if not beside:
        return path
    import shutil
    from tempfile import TemporaryDirectory

    scratch = Path(stack.enter_context(TemporaryDirectory(prefix='eventreg_')))
    for source in (path, *beside):
        shutil.copyfile(source, scratch / source.name)
    try:
        with closing(sqlite3.connect(scratch / path.name)) as connection:
            connection.execute('SELECT count(*) FROM sqlite_master').fetchone()
    except sqlite3.Error:
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


# Small tables -------------------------------------------------------------------------------------


def _tables(connection: sqlite3.Connection) -> Tables:
    roots = {
        (kind, table): root
        for kind, table, root in connection.execute(
            'SELECT type, tbl_name, rootpage FROM sqlite_master WHERE rootpage > 0'
        )
    }
    columns = _columns(connection, 'messages')
    wanted = {'topic_id', 'timestamp', 'data'} <= set(columns)
    if not wanted or not roots.get(('table', 'messages')) or not roots.get(('table', 'topics')):
        raise sqlite3.DatabaseError(
            'it is a database, but no rosbag2: no tables of messages and topics'
        )
    return Tables(roots['table', 'messages'], roots.get(('index', 'messages'), 0), columns)


def _columns(connection: sqlite3.Connection, table: str) -> list[str]:
    return [row[1] for row in connection.execute(f'PRAGMA table_info({table})')]


def _channels(connection: sqlite3.Connection) -> dict[int, Channel]:
    definitions = {}
    if 'encoded_message_definition' in _columns(connection, 'message_definitions'):
        with suppress(sqlite3.Error):  # ROS's own definitions serve
            definitions = {
                kind: (str(text), str(language))
                for kind, text, language in connection.execute(
                    'SELECT topic_type, encoded_message_definition, encoding '
                    'FROM message_definitions'
                )
            }
    rows = connection.execute('SELECT id, name, type, serialization_format FROM topics ORDER BY id')
    return {
        number: Channel(
            absolute(str(name)),
            full_type(str(kind)),
            str(encoding),
            *definitions.get(kind, ('', '')),
        )
        for number, name, kind, encoding in rows
    }


def _custom(connection: sqlite3.Connection) -> dict[str, str]:
    try:
        texts = connection.execute('SELECT metadata FROM metadata ORDER BY id').fetchall()
    except (sqlite3.Error, ValueError):
        return {}
    return {key: value for (text,) in texts for key, value in custom_data(str(text)).items()}
