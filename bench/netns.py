# SPDX-License-Identifier: Apache-2.0
"""Hosts that are network namespaces of this machine, with delay, jitter and loss between them.

Each host has a veth pair to a switch: this process, which sits in a namespace of its own without
any other interface, so that nothing can leave. Where the kernel has ``sch_netem`` the switch is a
bridge and ``tc netem`` on its ports impairs what goes to each host; elsewhere a thread passes the
frames on and impairs them by :class:`eventreg_ros.runtime.relay.Relay`. The namespaces have no
names and end with the processes that hold them: nothing is left behind, however this ends.

Run ``PYTHONPATH=. python bench/netns.py`` to see what the links really add (docs/hosts.md).
Needs Linux, iproute2, util-linux, and root or user namespaces.
"""

from __future__ import annotations

import contextlib
import os
import select
import shutil
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Sequence

from eventreg_ros.runtime.relay import Impairment, Relay

INSIDE = 'EVENTREG_NETNS'
"""Environment variable that tells a process that it is the switch already."""

MORTAL = ['setpriv', '--pdeathsig', 'KILL', '--']
"""The beginning of a command that is to end with its parent, however that ends."""

SUBNET = '10.77.0'
VNET_HEADER = 10
"""Bytes before each frame that carry the checksum's state, which veth leaves to the hardware."""
FRAME = 1 << 17

SOL_PACKET, PACKET_VNET_HDR, PACKET_IGNORE_OUTGOING, ETH_P_ALL = 263, 15, 23, 3


def enter() -> None:
    """Start this script again in namespaces of its own; where that cannot be, say why and end."""
    if os.environ.get(INSIDE):
        return
    reason = unavailable()
    if reason:
        print(f'skipped: {reason}')
        sys.exit(0)
    os.environ[INSIDE] = '1'
    os.execvp('unshare', [*unshare(), sys.executable, *sys.argv])


def unshare() -> list[str]:
    """Return the command that starts another in namespaces of its own, as root of them."""
    user = [] if os.geteuid() == 0 else ['--user', '--map-root-user']
    return ['unshare', *user, '--net', '--mount', '--propagation', 'private', '--']


def unavailable() -> str | None:
    """Say why this machine cannot have such hosts, or return None."""
    tools = ('ip', 'tc', 'unshare', 'nsenter', 'setpriv')
    missing = [tool for tool in tools if shutil.which(tool) is None]
    if missing:
        return f'needs {", ".join(missing)}: apt-get install iproute2 util-linux'
    probe = 'ip link add one type veth peer name two && mount -t tmpfs none /dev/shm'
    tried = subprocess.run([*unshare(), 'sh', '-c', probe], capture_output=True, text=True)
    if tried.returncode:
        return f'needs network namespaces and veth, run it as root: {tried.stderr.strip()}'
    return None


class Hosts:
    """The switch and its hosts, to be used with ``with`` inside :func:`enter`."""

    def __init__(self, names: Sequence[str], seed: int = 0) -> None:
        self.addresses = {name: f'{SUBNET}.{i + 1}' for i, name in enumerate(names)}
        self._macs = {name: f'02:00:00:00:00:{i + 1:02x}' for i, name in enumerate(names)}
        self._seed = seed
        self._holders: dict[str, subprocess.Popen[bytes]] = {}
        self.switch: Switch | None = None

    def __enter__(self) -> Hosts:
        try:
            for name in self.addresses:
                self._add(name)
            if has_netem():
                self._bridge()
            else:
                self.switch = Switch({n: (f'to_{n}', m) for n, m in self._macs.items()}, self._seed)
                self.switch.start()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        if self.switch is not None:
            self.switch.stop()
        for holder in self._holders.values():
            holder.kill()
            holder.wait()

    @property
    def means(self) -> str:
        """What impairs the links."""
        return 'tc netem' if self.switch is None else 'a switch in user space (no sch_netem here)'

    def _add(self, name: str) -> None:
        """Create a namespace that holds its own interface and its own shared memory."""
        hold = 'mount -t tmpfs none /dev/shm && echo && exec sleep infinity'
        holder = subprocess.Popen(
            [*MORTAL, 'unshare', '--net', '--mount', '--propagation', 'private', 'sh', '-c', hold],
            stdout=subprocess.PIPE, stdin=subprocess.DEVNULL,
        )  # fmt: skip
        self._holders[name] = holder
        assert holder.stdout is not None
        if not holder.stdout.readline():
            raise OSError(f'no namespace for {name}')
        ip(
            f'link add to_{name} type veth peer name eth0 netns {holder.pid}',
            f'link set to_{name} addrgenmode none up',
        )
        others = [n for n in self.addresses if n != name]
        ip(
            'link set lo up',
            f'link set eth0 address {self._macs[name]} addrgenmode none up',
            f'address add {self.addresses[name]}/24 dev eth0',
            *(f'neighbour add {self.addresses[n]} lladdr {self._macs[n]} dev eth0' for n in others),
            inside=self.within(name),
        )

    def _bridge(self) -> None:
        ip('link add bridge type bridge', 'link set bridge up')
        ip(*(f'link set to_{name} master bridge' for name in self.addresses))

    def within(self, name: str) -> list[str]:
        """Return the beginning of a command that is to run on host ``name`` and end with us."""
        holder = str(self._holders[name].pid)
        return [
            *MORTAL,
            'nsenter',
            '--target',
            holder,
            '--net',
            '--mount',
            f'--wd={os.getcwd()}',
            '--',
        ]

    def impair(self, impairment: Impairment) -> None:
        """Impair what every host gets from the others, from now on."""
        if self.switch is not None:
            self.switch.impair(impairment)
            return
        for name in self.addresses:
            command = ['tc', 'qdisc', 'replace', 'dev', f'to_{name}', 'root', *netem(impairment)]
            subprocess.run(command, check=True)


def netem(impairment: Impairment) -> list[str]:
    """Return the words of ``tc qdisc`` for an impairment; netem's jitter is plus or minus half."""
    delay = impairment.delay + 0.5 * impairment.jitter
    words = ['netem', 'limit', '100000', 'delay', f'{delay * 1e6:.0f}us']
    words += [f'{0.5 * impairment.jitter * 1e6:.0f}us'] if impairment.jitter else []
    words += ['loss', f'{100.0 * impairment.loss:g}%'] if impairment.loss else []
    words += ['duplicate', f'{100.0 * impairment.duplicate:g}%'] if impairment.duplicate else []
    return words


def has_netem() -> bool:
    """Say whether the kernel has ``sch_netem``, tried on the loopback of this namespace."""
    words = ['tc', 'qdisc', 'add', 'dev', 'lo', 'root', *netem(Impairment(delay=0.001))]
    if subprocess.run(words, capture_output=True).returncode:
        return False
    subprocess.run(['tc', 'qdisc', 'del', 'dev', 'lo', 'root'], check=True)
    return True


def ip(*lines: str, inside: Sequence[str] = ()) -> None:
    """Run ``ip`` with each of ``lines``; raises OSError with what it says."""
    command = [*inside, 'ip', '-batch', '-']
    done = subprocess.run(command, input='\n'.join(lines), capture_output=True, text=True)
    if done.returncode:
        raise OSError(f'ip: {done.stderr.strip()}')


class Switch(threading.Thread):
    """Passes frames on between veth ports, each port's through a wire of its own."""

    def __init__(self, ports: dict[str, tuple[str, str]], seed: int) -> None:
        """Open ``ports``: interface and the MAC address behind it, by host."""
        super().__init__(daemon=True)
        self._ports = {name: port(interface) for name, (interface, _) in ports.items()}
        self._behind = {bytes.fromhex(m.replace(':', '')): n for n, (_, m) in ports.items()}
        self.wires: dict[str, Relay[bytes]] = {
            name: Relay(Impairment(order='any'), f'{seed} {name}') for name in ports
        }
        self.multicast = 0
        """Frames to groups; they are not passed on."""
        self._ending = False

    def impair(self, impairment: Impairment) -> None:
        """Take over an impairment for the frames to come."""
        for wire in self.wires.values():
            wire.impairment = impairment

    def stop(self) -> None:
        """End the thread and close the ports."""
        self._ending = True
        self.join()
        for each in self._ports.values():
            each.close()

    def run(self) -> None:
        """Pass frames on until :meth:`stop`."""
        with contextlib.suppress(PermissionError):  # a wire does not wait for others on the machine
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
        sockets = list(self._ports.values())
        while not self._ending:
            dues = [wire.next_due for wire in self.wires.values()]
            soon = min((due for due in dues if due is not None), default=None)
            left = 0.1 if soon is None else (soon - time.monotonic_ns()) * 1e-9
            for ready in select.select(sockets, [], [], min(0.1, max(0.0, left)))[0]:
                self._take(ready)
            for name, wire in self.wires.items():
                for departure in wire.pop(time.monotonic_ns()):
                    with contextlib.suppress(OSError):  # a full queue drops, as everywhere
                        self._ports[name].send(departure.item)

    def _take(self, ready: socket.socket) -> None:
        for _ in range(64):
            try:
                frame = ready.recv(FRAME)
            except BlockingIOError:
                return
            target = self._behind.get(frame[VNET_HEADER : VNET_HEADER + 6])
            if target is not None:
                self.wires[target].push(time.monotonic_ns(), frame)
            else:
                self.multicast += 1


def port(interface: str) -> socket.socket:
    """Return a socket that takes the frames that come in on ``interface`` and sends on it."""
    found = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, 0)
    found.setsockopt(SOL_PACKET, PACKET_VNET_HDR, 1)
    found.setsockopt(SOL_PACKET, PACKET_IGNORE_OUTGOING, 1)
    found.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
    found.setblocking(False)
    found.bind((interface, ETH_P_ALL))
    return found


ECHO = """
import socket
s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
s.bind(('0.0.0.0', 7))
print(flush=True)
while True:
    data, peer = s.recvfrom(2000)
    s.sendto(data, peer)
"""

ASK = """
import json, select, socket, sys, time
s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
s.connect((sys.argv[1], 7))
count, got = int(sys.argv[2]), {}
def take(until):
    while (left := until - time.monotonic()) > 0:
        if select.select([s], [], [], left)[0]:
            n = int(s.recv(2000).split()[0])
            got.setdefault(n, []).append(time.monotonic() - sent[n])
sent = []
for n in range(count):
    sent.append(time.monotonic())
    s.send(b'%d ' % n + bytes(100))
    take(sent[0] + (n + 1) * 0.002)
take(time.monotonic() + 0.5)
print(json.dumps(list(got.values())))
"""


def round_trips(hosts: Hosts, one: str, other: str, count: int) -> list[list[float]]:
    """Return, for each of ``count`` datagrams that came back, the seconds each copy took."""
    import json

    python = [sys.executable, '-S', '-c']
    echo = subprocess.Popen([*hosts.within(other), *python, ECHO], stdout=subprocess.PIPE)
    try:
        assert echo.stdout is not None
        echo.stdout.readline()
        command = [*hosts.within(one), *python, ASK, hosts.addresses[other], str(count)]
        asked = subprocess.run(command, check=True, capture_output=True, text=True)
    finally:
        echo.kill()
        echo.wait()
    return [list(map(float, times)) for times in json.loads(asked.stdout)]


CASES = (
    Impairment(),
    Impairment(delay=0.005),
    Impairment(delay=0.02),
    Impairment(delay=0.04),
    Impairment(delay=0.02, jitter=0.01, order='any'),
    Impairment(loss=0.05),
    Impairment(delay=0.02, loss=0.2),
)


def main() -> int:
    """Print what the links add to a datagram's round trip."""
    import numpy as np

    enter()
    with Hosts(['one', 'other']) as hosts:
        load = os.getloadavg()[0]
        print(f'Links by {hosts.means}; load average {load:.1f} on {os.cpu_count()} cores.\n')
        print('| one way: delay ms | jitter ms | loss | round trip ms p50 | p99 | max | lost |')
        print('|---:|---:|---:|---:|---:|---:|---:|')
        for case in CASES:
            hosts.impair(case)
            trips = round_trips(hosts, 'one', 'other', 1000)
            ms = 1e3 * np.array([trip for copies in trips for trip in copies])
            lost = 1.0 - len(trips) / 1000
            p50, p99 = np.percentile(ms, [50, 99])
            print(
                f'| {case.delay * 1e3:g} | {case.jitter * 1e3:g} | {case.loss:.0%} '
                f'| {p50:.2f} | {p99:.2f} | {ms.max():.2f} | {lost:.1%} |'
            )
    return 0


if __name__ == '__main__':
    sys.exit(main())
