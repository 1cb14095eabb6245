"""rosbag2 directories and files to signals, and back. The only reader and writer of bags."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..errors import BagError
from ..models.roles import SIGNALS

if TYPE_CHECKING:
    from rosbags.highlevel import AnyReader

Array = npt.NDArray[np.float64]

FLOAT64 = 'std_msgs/msg/Float64'
SCENARIO_KEY = 'eventreg_ros.scenario'
NAME_KEY = 'eventreg_ros.scenario_name'
SIDECAR = '.scenario.yaml'
"""NAME.scenario.yaml lies in the bag from the start: a killed recorder writes no metadata."""

STORAGES = {'mcap': '.mcap', 'sqlite3': '.db3'}

_MCAP_MAGIC = b'\x89MCAP0\r\n'
_MCAP_END = b'\x02' + (20).to_bytes(8, 'little') + bytes(20) + _MCAP_MAGIC


@dataclass(frozen=True)
class Recording:
    """The signals of a bag.

    ``signals`` maps each name to (stamps, values), both of shape (n,): stamps in integer
    nanoseconds of ROS time, not decreasing. ``scenario`` is the parameter file's text that the
    recorder stored, or None; ``name`` what it is called.
    """

    signals: dict[str, tuple[npt.NDArray[np.int64], Array]]
    scenario: str | None
    name: str | None

    @property
    def start(self) -> int:
        """The stamp of the run's first sample; where there are ours, others do not count."""
        found = {name: int(stamps[0]) for name, (stamps, _) in self.signals.items() if len(stamps)}
        ours = [stamp for name, stamp in found.items() if name in SIGNALS]
        return min(ours or found.values(), default=0)

    def in_model_time(self, time_scale: float) -> dict[str, tuple[Array, Array]]:
        """Return the signals over model time, t = 0 at the first sample of the run."""
        return {
            name: ((stamps - self.start).astype(np.float64) * (time_scale * 1e-9), values)
            for name, (stamps, values) in self.signals.items()
        }


# Reading ----------------------------------------------------------------------------------------


def read_bag(path: str | Path, namespace: str | None = None) -> Recording:
    """Read every Float64 signal of a rosbag2 directory, .mcap or .db3 file.

    Topics lose their namespace; ``namespace`` says which one to read where several hold a y. Reads
    what a killed recorder left as far as it goes. Raises BagError, one line, for everything else.
    """
    path = Path(path)
    if not path.exists():
        raise BagError(f'bag {path} does not exist; check the path')
    if path.suffix == '.bag':
        raise BagError(f'{path} is a ROS 1 bag; bring it to ROS 2 with rosbags-convert')
    try:
        with _readable(path) as files:
            return _read(path, files, namespace)
    except BagError:
        raise
    except ImportError as error:
        raise BagError(f'bags cannot be read ({error}); pip install rosbags') from None
    except Exception as error:  # rosbags raises whatever its parsers meet in a broken file
        reason = ' '.join(str(error).split()) or type(error).__name__
        raise BagError(
            f'bag {path} cannot be read: {reason}; '
            "repair it with 'ros2 bag reindex' or 'mcap recover', or record it again"
        ) from None


@contextmanager
def _readable(path: Path) -> Iterator[list[Path]]:
    """Yield what to hand to rosbags: the bag itself, or, without metadata, its mended files."""
    from tempfile import TemporaryDirectory

    if path.is_dir() and (path / 'metadata.yaml').exists():
        yield [path]
        return
    files = [path]
    if path.is_dir():
        files = sorted(f for f in path.iterdir() if f.suffix in STORAGES.values())
        if not files:
            raise BagError(
                f'{path} is no bag: it holds neither metadata.yaml nor a .mcap or .db3 file; '
                'give the directory that ros2 bag or the recorder made'
            )
    with TemporaryDirectory(prefix='eventreg_') as scratch:
        yield [_mended(file, Path(scratch)) for file in files]


def _mended(file: Path, scratch: Path) -> Path:
    """Return ``file``, or a copy that can be read where its writer was killed."""
    if file.suffix == '.db3' and (beside := _beside(file)):
        return _settled([file, *beside], scratch)
    if file.suffix != '.mcap':
        return file
    data = file.read_bytes()
    if not data.startswith(_MCAP_MAGIC) or data.endswith(_MCAP_MAGIC):
        return file
    copy = scratch / file.name
    copy.write_bytes(data[: _last_whole_record(data)] + _MCAP_END)
    return copy


def _last_whole_record(data: bytes) -> int:
    """Return where the last complete record of an MCAP file ends.

    A record is an opcode, the length of its body in 8 bytes, and the body.
    """
    at = len(_MCAP_MAGIC)
    while at + 9 <= len(data):
        after = at + 9 + int.from_bytes(data[at + 1 : at + 9], 'little')
        if after > len(data) or data[at] not in range(0x01, 0x10):
            break
        at = after
    return at


def _beside(file: Path) -> list[Path]:
    """Return the journals that hold what a killed writer had not settled in the database."""
    found = (file.with_name(file.name + end) for end in ('-journal', '-wal'))
    return [path for path in found if path.exists()]


def _settled(files: list[Path], scratch: Path) -> Path:
    """Return a copy of the database, the first of ``files``, that sqlite has set right."""
    import shutil
    import sqlite3

    for source in files:
        shutil.copy(source, scratch)
    copy = scratch / files[0].name
    connection = sqlite3.connect(copy)
    try:
        connection.execute('SELECT count(*) FROM messages').fetchone()
    finally:
        connection.close()
    return copy


def _read(path: Path, files: list[Path], namespace: str | None) -> Recording:
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    with AnyReader(files, default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        topics = _topics(path, reader, namespace)
        stamps: dict[str, list[int]] = {name: [] for name in topics.values()}
        raw: dict[str, list[bytes]] = {name: [] for name in topics.values()}
        for connection, stamp, data in _messages(reader, topics):
            name = topics[connection.topic]
            stamps[name].append(stamp)
            raw[name].append(data)
        custom = _custom_data(reader, path)
    signals = {name: _decode(path, name, stamps[name], raw[name]) for name in raw}
    if not any(len(t) for t, _ in signals.values()):
        raise BagError(f'bag {path} is empty: no Float64 sample in it; record while the nodes run')
    return Recording(signals, custom.get(SCENARIO_KEY), custom.get(NAME_KEY))


def _messages(reader: AnyReader, topics: Mapping[str, str]) -> Iterator[tuple[Any, int, bytes]]:
    """Yield the messages of ``topics``, in file order where a killed writer left no index."""
    from rosbags.rosbag2.storage_mcap import McapReader

    for part in reader.readers:
        wanted = [c for c in part.connections if c.topic in topics and c.msgtype == FLOAT64]
        storage = getattr(part, 'storage', None)
        if isinstance(storage, McapReader) and not storage.chunks:
            yield from storage.messages_scan(wanted)
        elif wanted:
            yield from part.messages(wanted)


def _topics(path: Path, reader: AnyReader, namespace: str | None) -> dict[str, str]:
    """Return signal name by topic, for the Float64 topics of one namespace."""
    floats = [c.topic for c in reader.connections if c.msgtype == FLOAT64]
    if not floats:
        others = sorted({f'{c.topic} ({c.msgtype})' for c in reader.connections})
        raise BagError(
            f'bag {path} holds no {FLOAT64} topic (it has {", ".join(others) or "none"}); '
            'record w, v, y, y_r and u'
        )
    if namespace is None:
        homes = sorted({t.rpartition('/')[0] for t in floats if t.rpartition('/')[2] == 'y'})
        if len(homes) > 1:
            raise BagError(
                f'bag {path} holds several namespaces with a y: '
                f'{", ".join(h or "/" for h in homes)}; choose one with --namespace'
            )
        namespace = homes[0] if homes else ''
    prefix = '/' + namespace.strip('/') + '/' if namespace.strip('/') else '/'
    topics = {t: t.removeprefix(prefix) for t in floats if t.startswith(prefix)}
    if not topics:
        raise BagError(
            f'bag {path} holds no {FLOAT64} topic in namespace {prefix.rstrip("/")}; '
            f'it has {", ".join(sorted(set(floats)))}'
        )
    return topics


def _custom_data(reader: AnyReader, path: Path) -> dict[str, str]:
    for part in reader.readers:
        custom = getattr(getattr(part, 'storage', None), 'metadata', None)
        custom = getattr(custom, 'custom', None)
        if custom:
            return dict(custom)
    for sidecar in sorted((path if path.is_dir() else path.parent).glob('*' + SIDECAR)):
        name = sidecar.name.removesuffix(SIDECAR)
        return {SCENARIO_KEY: sidecar.read_text(encoding='utf-8'), NAME_KEY: name}
    return {}


def _decode(
    path: Path, name: str, stamps: list[int], raw: list[bytes]
) -> tuple[npt.NDArray[np.int64], Array]:
    """Turn CDR Float64 messages (a 4-byte header, then the double) into arrays, ordered by time."""
    if any(len(data) != 12 for data in raw):
        raise BagError(f'bag {path}: a message on {name} is not a Float64; record it again')
    block = np.frombuffer(b''.join(raw), np.uint8).reshape(-1, 12)
    little = np.ascontiguousarray(block[:, 4:]).view('<f8')[:, 0]
    big = np.ascontiguousarray(block[:, 4:]).view('>f8')[:, 0]
    values = np.where(block[:, 1] & 1, little, big).astype(np.float64)
    times = np.array(stamps, dtype=np.int64)
    order = np.argsort(times, kind='stable')
    return times[order], values[order]
