# SPDX-License-Identifier: Apache-2.0
"""What is wrong with a recording, as one sentence each."""

from __future__ import annotations

from typing import NamedTuple

CODES = {
    'checksum': 'a chunk or a file fails its checksum',
    'damaged': 'a place in a file cannot be read, and is left out',
    'lost-samples': 'fewer samples read than metadata, statistics or an index promise',
    'missing-file': 'a file that metadata.yaml names is not there, or is no bag file',
    'not-decoded': 'messages that are not what their type says, left out',
    'second-run': 'a second run under stamps that were recorded already, left out',
    'second-writer': 'two sources wrote to one topic',
    'stamps-disagree': 'log and publish time of single samples differ, though those of no other do',
    'stamps-jump': 'stamps jump by more than an hour; the larger part is kept',
    'stamps-stand-still': 'several samples of one signal have the same stamp',
    'stamps-off-grid': 'single stamps off the grid of all others',
    'topic-disagrees': 'data and summary name a channel differently',
    'assumed-type': 'a channel without a type was taken for Float64',
    'index-disagrees': 'the index of a database and its rows differ; the rows were read',
    'log-stamps': 'log times that make no sense; the publish times were used',
    'lone-sample': 'a single value far off its neighbours',
    'metadata-disagrees': 'metadata.yaml is stale or cannot be read; the data were read',
    'nonsense-stamps': 'stamps far from all others, left out',
    'no-end': 'a file ends without its end: the writer was killed, or the file was cut',
    'other-type': 'a signal was recorded with a type that must be asked for by name',
    'wild-samples': 'values larger than all others by orders of magnitude',
    'summary-disagrees': 'the summary of a file is stale or broken; the data were read',
}
"""Every code that a reader gives, and what it means."""

IMPAIRING = frozenset(
    ('checksum', 'damaged', 'lost-samples', 'missing-file', 'not-decoded', 'second-run',
     'second-writer', 'stamps-disagree', 'stamps-jump', 'stamps-stand-still', 'stamps-off-grid',
     'topic-disagrees')
)  # fmt: skip
"""Codes after which samples are known to be lost or wrong: what was not seen cannot be judged."""


class Finding(NamedTuple):
    """One thing that is wrong with a recording.

    ``code`` is one of :data:`CODES`; ``signal`` what it concerns, None: the file; ``at`` seconds
    since the first sample of the run, None where unknown; ``text`` one plain sentence.
    """

    code: str
    signal: str | None
    at: float | None
    text: str


class Note(NamedTuple):
    """A finding as a file's reader knows it: by topic, and by stamp in nanoseconds of ROS time."""

    code: str
    topic: str | None
    stamp: int | None
    text: str


def many(count: int, of: int) -> str:
    """Return how many samples of how many."""
    return f'{count} of {of} samples'
