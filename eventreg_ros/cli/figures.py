# SPDX-License-Identifier: Apache-2.0
"""``eventreg figures``: the paper's figures, and those that it argues in words. Needs no ROS."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import EventregError
from ..files import reason_of, writing
from .arguments import write_text
from .progress import Count

if TYPE_CHECKING:
    from ..paper import Drawable

FORMATS = ('pdf', 'svg', 'png')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``eventreg figures``."""
    parser.add_argument('names', metavar='NAME', nargs='*', help='the figures to make (all)')
    parser.add_argument(
        '--out', metavar='DIR', type=Path, default=Path('figures'), help='where to (figures)'
    )
    parser.add_argument(
        '--format', action='append', choices=FORMATS, help='may be repeated (all three)'
    )
    parser.add_argument('--data', action='store_true', help='write the data of each as csv, too')
    parser.add_argument(
        '--page', type=Path, metavar='F.md', help='write a page that shows the svg files'
    )
    parser.add_argument(
        '-p', action='append', default=[], dest='overrides', metavar='NODE.PARAM:=VALUE',
        help='override a parameter in every scenario that the figures run; may be repeated',
    )  # fmt: skip


def main(args: argparse.Namespace) -> int:
    """Make the figures, one line of output for each, and return 0."""
    from ..paper import compute, find, gallery

    chosen, formats = find(args.names), tuple(args.format or FORMATS)
    if args.page is not None and 'svg' not in formats:
        raise EventregError('--page shows the svg files; add --format svg')
    if args.page is not None and args.overrides:
        raise EventregError("--page describes the paper's parameters; leave out --page or -p")
    make_directory(args.out)
    count = Count('figures')
    for done, figure in enumerate(chosen):
        count.show(done, len(chosen), figure.name)
        drawable = compute(figure, args.overrides)
        files = write(drawable, args.out / figure.name, formats, args.data)
        count.clear()
        print(f'{figure.name}: {", ".join(file.name for file in files)}', flush=True)
    if args.page is not None:
        pictures = os.path.relpath(args.out, args.page.parent)
        write_text(args.page, gallery(chosen, Path(pictures).as_posix()))
    return 0


def make_directory(path: Path) -> None:
    """Make the directory ``path`` unless it is there. Raises EventregError when it cannot."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise EventregError(
            f'cannot make the directory {path}: {reason_of(error)}; name another with --out'
        ) from None


def write(drawable: Drawable, stem: Path, formats: tuple[str, ...], data: bool) -> list[Path]:
    """Draw and write one figure as ``stem``.FORMAT, and its data as .csv; return the files.

    Raises EventregError when a file cannot be written.
    """
    from ..analysis.export import write_signals
    from ..plots.figures import draw
    from ..plots.style import save

    d = drawable
    picture = draw(
        d.layout, d.t, d.columns, notes=d.notes, threshold=d.threshold, reset=d.reset
    )  # fmt: skip
    files = [stem.with_suffix(f'.{kind}') for kind in formats]
    for file in files:
        with writing(file) as beside:
            save(picture, beside)
    if data:
        files.append(stem.with_suffix('.csv'))
        write_signals(files[-1], d.t, d.columns)
    return files
