# SPDX-License-Identifier: Apache-2.0
"""Where F is ``-``: the file goes to standard output, and everything else to standard error."""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path

from ..errors import EventregError

DASH = '-'

FORMATS = {'json': '.json', 'junit': '.xml', 'report': '.html', 'plot': '.svg', 'out': '.csv'}
"""Options that name a file, and what goes to standard output."""

OTHER_OUT = {'identify': '.yaml', 'figures': None, 'sweep': None}
"""Verbs whose --out is another format, or a directory."""


@contextmanager
def divided(args: argparse.Namespace) -> Iterator[None]:
    """Let the verb of ``args`` write a file of ours in place of ``-``, and print it at the end.

    All that is printed meanwhile, by child processes too, goes to standard error. A verb that fails
    prints no part of the file. Raises EventregError where two files would be mixed.
    """
    asked = [
        name for name in FORMATS if str(getattr(args, name, None)) == DASH and _suffix(name, args)
    ]
    if not asked:
        yield
        return
    if len(asked) > 1:
        raise EventregError(
            f'only one file can go to standard output, got --{asked[0]} - and --{asked[1]} -; '
            'give the other one a name'
        )
    scratch = Path(tempfile.mkdtemp(prefix='eventreg_'))
    file = scratch / f'output{_suffix(asked[0], args)}'
    setattr(args, asked[0], file)
    try:
        with redirect_stdout(sys.stderr), _children_redirected():
            yield
        if file.exists():
            sys.stdout.flush()
            with file.open('rb') as source:
                shutil.copyfileobj(source, sys.stdout.buffer)
            sys.stdout.flush()
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _suffix(option: str, args: argparse.Namespace) -> str | None:
    return OTHER_OUT.get(args.verb, FORMATS[option]) if option == 'out' else FORMATS[option]


@contextmanager
def _children_redirected() -> Iterator[None]:
    """Give processes that are started meanwhile our standard error as their output."""
    kept = os.dup(1)
    try:
        os.dup2(2, 1)
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
