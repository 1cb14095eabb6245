# SPDX-License-Identifier: Apache-2.0
"""Files: read only where they are files, and written whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import itertools
import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import EventregError

TEXT_LIMIT = 1 << 20
"""Bytes of a scenario or another parameter file; the largest that is shipped has 2,000."""

SCRATCH = 'eventreg_run_'
"""Directories of ours for temporary files begin with this."""

DRAFT = '.eventreg_'
"""What is being written has a name that begins with this, until it is whole."""

_KINDS = {
    stat.S_IFDIR: 'a directory',
    stat.S_IFCHR: 'a device',
    stat.S_IFBLK: 'a device',
    stat.S_IFIFO: 'a pipe',
    stat.S_IFSOCK: 'a socket',
}

_READ = os.O_RDONLY | getattr(os, 'O_NONBLOCK', 0) | getattr(os, 'O_BINARY', 0)

_numbers = itertools.count()


class UnreadableError(Exception):
    """A file cannot be read; the message is the reason, to stand behind the file's name."""


def read_text(path: str | Path, limit: int = TEXT_LIMIT) -> str:
    """Return the text of a regular file of at most ``limit`` bytes of UTF-8, without a BOM.

    Never waits, and reads nothing else. Raises UnreadableError with the reason.
    """
    try:
        _need_regular(os.stat(path).st_mode)
        # It may have become something else since: opening must not wait for a writer.
        with open(os.open(path, _READ), 'rb') as file:
            _need_regular(os.fstat(file.fileno()).st_mode)
            data = file.read(limit + 1)
    except OSError as error:
        raise UnreadableError(reason_of(error)) from None
    except ValueError as error:  # a name with a null character
        raise UnreadableError(str(error)) from None
    if len(data) > limit:
        raise UnreadableError(f'it has more than {limit} bytes; give a smaller file')
    try:
        return data.decode('utf-8-sig')
    except UnicodeDecodeError as error:
        raise UnreadableError(f'it is not UTF-8 text ({error.reason} at {error.start})') from None


def _need_regular(mode: int) -> None:
    if not stat.S_ISREG(mode):
        kind = _KINDS.get(stat.S_IFMT(mode), 'no file')
        raise UnreadableError(f'it is {kind}; give a regular file')


def reason_of(error: OSError) -> str:
    """Return what the operating system says, in lower case; without the path."""
    words = error.strerror or str(error) or type(error).__name__
    return words[0].lower() + words[1:]


@contextmanager
def scratch_directory() -> Iterator[Path]:
    """Yield a new directory that goes with the block; and remove what dead processes left of such.

    Its name has the id of this process.
    """
    for dead in dead_scratch():
        shutil.rmtree(dead, ignore_errors=True)
    path = Path(tempfile.mkdtemp(prefix=scratch_prefix()))
    try:
        yield path
    finally:
        shutil.rmtree(path, ignore_errors=True)


def scratch_prefix() -> str:
    """Return what the name of a temporary directory of this process begins with."""
    return f'{SCRATCH}{os.getpid()}_'


def dead_scratch() -> Iterator[Path]:
    """Yield this user's scratch directories whose process is gone."""
    for path in Path(tempfile.gettempdir()).glob(f'{SCRATCH}*_*'):
        with contextlib.suppress(OSError, ValueError):
            pid = int(path.name.removeprefix(SCRATCH).partition('_')[0])
            status = path.lstat()
            ours = stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid()
            if ours and not _is_alive(pid):
                yield path


def _is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return True


@contextmanager
def writing(path: Path) -> Iterator[Path]:
    """Yield a new name beside ``path``, with its suffix; what is written there replaces ``path``.

    It does so when the block ends well; else nothing is left of it, and ``path`` is as it was. What
    is no regular file, /dev/stdout say, is written directly. Raises EventregError for an OSError.
    """
    try:
        if path.exists() and not path.is_file():
            yield path
            return
        target = Path(os.path.realpath(path))
        if target.exists() and not os.access(target, os.W_OK):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
        beside = target.with_name(f'{DRAFT}{os.getpid()}_{next(_numbers)}{path.suffix}')
        try:
            yield beside
            with contextlib.suppress(FileNotFoundError):
                beside.chmod(stat.S_IMODE(target.stat().st_mode))
            beside.replace(target)
        finally:
            beside.unlink(missing_ok=True)
    except OSError as error:
        raise EventregError(f'cannot write {path}: {reason_of(error)}; name another file') from None


def remove_dead_drafts(directory: Path) -> None:
    """Remove what processes that were killed while they wrote left in a directory."""
    for path in directory.glob(f'{DRAFT}*_*'):
        with contextlib.suppress(OSError, ValueError):
            if not _is_alive(int(path.name.removeprefix(DRAFT).partition('_')[0])):
                path.unlink()


def need_new(path: Path | None) -> None:
    """Raise EventregError when ``path`` is there already, or cannot be written.

    Scenarios and bags are what somebody wrote or recorded, and are never replaced; results are.
    """
    if path is not None and os.path.lexists(path):
        raise EventregError(f'{path} exists already; remove it or name another file')
    need_writable(path)


def need_writable(path: Path | None) -> None:
    """Raise EventregError when ``path`` cannot be written, before the work is done.

    A file is written beside its place and then put there, so that its directory is what counts.
    """
    if path is None:
        return
    try:
        target = Path(os.path.realpath(path))
        file = target.is_file() or not target.exists()
        needed = [target.parent] if file else []
        needed += [target] if target.exists() else []
        bad = target.is_dir() or not target.parent.is_dir()
        bad = bad or not all(os.access(each, os.W_OK) for each in needed)
    except (OSError, ValueError):
        bad = True
    if bad:
        raise EventregError(f'cannot write {path}; name another file, in a directory that is there')
