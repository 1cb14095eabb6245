# SPDX-License-Identifier: Apache-2.0
"""An MCAP file, read once from beginning to end: the data count, the summary is a hint."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from . import mcap_records as mcap
from .channel import Account, Select
from .compression import PIECE, sane
from .mcap_contents import Contents
from .mcap_delivery import Delivery
from .mcap_messages import damaged_after, runs
from .mcap_records import HEAD, MAGIC, Chunk, DamagedError, Record, find_record
from .mcap_summary import Summary, read_summary
from .mcap_trouble import Trouble
from .tape import ROOM, Tape

LONGEST_END = 64
"""Bytes of the record that ends the data, at most: a checksum, and what a later version adds."""


def read_mcap(path: Path, select: Select) -> Account:
    """Hand the messages of a file to those who want them, in the order of the file."""
    size = path.stat().st_size
    with path.open('rb') as file:
        summary = read_summary(file, size)
        file.seek(0)
        return _Pass(path.name, Tape(file, size), summary, select).run()


class _Pass:
    """One pass through a file."""

    def __init__(self, name: str, tape: Tape, summary: Summary, select: Select) -> None:
        self.name = name
        self.tape = tape
        self.summary = summary
        self.account = Account()
        self.trouble = Trouble(name, self.account)
        self.to = Delivery(select, summary, self.account, tape.size)
        self.contents = Contents(self.to, self.trouble)
        self.cut = False
        """Whether the last chunk was cut, and left out: nothing can vouch for a part of it."""

    def run(self) -> Account:
        """Read the file; what is wrong with it is in the account."""
        if self.summary.data_crc:
            self.tape.crc = 0
        if self.summary.whole:
            self.tape.size -= len(MAGIC)
        if self.tape.view(len(MAGIC))[: len(MAGIC)] != MAGIC:
            self.trouble.hole(len(MAGIC), None)
        self.tape.drop(len(MAGIC))
        while self._step():
            pass
        self.contents.flush()
        self.to.finish()
        self.trouble.conclude()
        self._judge_end()
        return self.account

    def _step(self) -> bool:
        """Read the next record, or the messages up to the next other record; False at the end."""
        window = self.tape.view(HEAD.size)
        if len(window) < HEAD.size:
            return False
        opcode, length = HEAD.unpack_from(window)
        total = HEAD.size + length
        if opcode == mcap.DATA_END and 4 <= length <= LONGEST_END and total <= self.tape.left:
            self._check_data(self.tape.view(total)[HEAD.size : total])
            return False
        at_end = self.tape.left - total <= len(MAGIC)
        if opcode == mcap.FOOTER and length == mcap.FOOTER_BODY.size and at_end:
            return False
        if opcode == mcap.CHUNK:
            return self._chunk(length)
        if opcode in (0, mcap.FOOTER, mcap.DATA_END) or total > self.tape.left:
            return self._recover()  # an end in the midst of the data is none
        if opcode == mcap.MESSAGE:
            return self._messages(total)
        if total <= ROOM:
            window = self.tape.view(total)
            self.to.declare(Record(opcode, 0, window[HEAD.size : total], total), True)
        self.tape.drop(total)
        return True

    def _messages(self, total: int) -> bool:
        """Read messages outside of chunks."""
        window = self.tape.view(total)
        self.contents.flush()
        self.trouble.unchecked = True
        end = 0
        for run in runs(window, 0):
            end = run.end
            doubtful = damaged_after(window, end, self.tape.left - end) and self.summary.whole
            whole = run.shortened() if doubtful else run
            if whole is not None:
                self.to.deliver(whole)
        if not end and total <= ROOM:
            return self._recover()
        self.tape.drop(end or total)
        return True

    def _chunk(self, length: int) -> bool:
        window = self.tape.view(min(HEAD.size + length, ROOM))
        try:
            head = mcap.chunk(window[HEAD.size :])
        except DamagedError:
            return self._recover()
        begin = HEAD.size + head.at
        total = self._extent(window, begin, head, HEAD.size + length)
        cut = total > self.tape.left
        if cut and self.summary.whole:
            return self._recover()
        if cut and self._has_read():
            self.cut = True
            return False
        data = max(min(head.length, total - begin, self.tape.left - begin), 0)
        if head.compression not in mcap.COMPRESSIONS:
            self.trouble.left_out(
                f'is packed as {head.compression!r}, which is unknown', head.start
            )
        elif not sane(data, head.size):
            self.trouble.left_out(f'claims to unpack {data} to {head.size} bytes', head.start)
        elif begin + data <= len(window) and head.size <= ROOM:
            crc = self.contents.whole(window[begin : begin + data], head, cut)
            self.tape.drop(begin)
            self.tape.drop(data, crc)
            total -= begin + data
        else:
            self.tape.drop(begin)
            at = self.tape.at
            self.contents.stream(self._pieces(data), head, cut)
            total -= begin + self.tape.at - at
        self.tape.drop(max(total, 0))
        return True

    def _has_read(self) -> bool:
        self.contents.flush()
        return self.to.latest is not None

    def _extent(self, window: memoryview, begin: int, head: Chunk, total: int) -> int:
        """Return the size of a chunk's record, by whichever of its two lengths leads to another."""
        for end in (total, begin + head.length):
            if end + HEAD.size <= len(window):
                opcode, length = HEAD.unpack_from(window, end)
                if 1 <= opcode <= mcap.DATA_END and end + HEAD.size + length <= self.tape.left:
                    return end
        return total

    def _pieces(self, length: int) -> Iterator[bytes]:
        while length > 0 and (window := self.tape.view(1)[:length]):
            piece = bytes(window[:PIECE])
            self.tape.drop(len(piece))
            length -= len(piece)
            yield piece

    def _recover(self) -> bool:
        """Look for the next record after a place that makes no sense; False where there is none."""
        self.contents.flush()
        begin = self.tape.at
        while True:
            window = self.tape.view(ROOM)
            found = find_record(window, 1, self.tape.left)
            if found is not None:
                self.tape.drop(found)
                self.trouble.hole(self.tape.at - begin, self.to.latest)
                return True
            if len(window) >= self.tape.left:
                break
            self.tape.drop(len(window) // 2)
        if self.summary.whole:
            self.trouble.hole(self.tape.at + self.tape.left - begin, self.to.latest)
        return False

    def _check_data(self, body: memoryview) -> None:
        stated = int.from_bytes(body[:4], 'little')
        if stated and self.tape.crc not in (None, stated):
            self.trouble.data_checksum_differs()

    def _judge_end(self) -> None:
        if not self.summary.whole:
            rest = 'its last chunk, of which a part is there, is left out'
            self.account.note(
                'no-end', f'{self.name} ends without its end: its writer was killed, or it was '
                f'cut; {rest if self.cut else "what is there was read"}', stamp=self.to.latest,
            )  # fmt: skip
        elif not self.summary.sound:
            text = f'the summary of {self.name} is damaged; the data were read'
            self.account.note('summary-disagrees', text)
