# SPDX-License-Identifier: Apache-2.0
"""A headless Chromium that tests talk to over a pipe (the DevTools protocol); no package needed."""

import contextlib
import json
import os
import select
import shutil
import subprocess
import time

PROGRAMS = ('chromium', 'chromium-browser', 'google-chrome', 'google-chrome-stable', 'chrome')


def program():
    """Return the path of a Chromium, None where there is none."""
    return next(filter(None, map(shutil.which, PROGRAMS)), None)


class Browser:
    """One page in a browser; what it says on its console and what it asks for is kept."""

    def __init__(self, home):
        to_read, self._write = os.pipe()
        self._read, to_write = os.pipe()
        high = [os.dup2(fd, 200 + i) for i, fd in enumerate((to_read, to_write))]

        def arrange():
            os.dup2(high[0], 3)
            os.dup2(high[1], 4)

        self._process = subprocess.Popen(
            [program(), '--headless=new', '--no-sandbox', '--disable-gpu', '--no-first-run',
             '--disable-background-networking', '--disable-dev-shm-usage', '--hide-scrollbars',
             f'--user-data-dir={home}', '--remote-debugging-pipe', 'about:blank'],
            preexec_fn=arrange, pass_fds=(3, 4), start_new_session=True,
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        for fd in (to_read, to_write, *high):
            os.close(fd)
        self._buffer, self._number, self._session = b'', 0, None
        self.events = []
        target = self.call('Target.createTarget', url='about:blank')['targetId']
        attached = self.call('Target.attachToTarget', targetId=target, flatten=True)
        self._session = attached['sessionId']
        for domain in ('Page', 'Runtime', 'Log', 'Network'):
            self.call(f'{domain}.enable')

    def close(self):
        """End the browser."""
        self._session = None
        with contextlib.suppress(OSError, RuntimeError):
            self.call('Browser.close')
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self._write)
        os.close(self._read)

    def call(self, method, **parameters):
        """Call a method of the protocol and return its result."""
        self._number += 1
        message = {'id': self._number, 'method': method, 'params': parameters}
        if self._session:
            message['sessionId'] = self._session
        os.write(self._write, json.dumps(message).encode() + b'\0')
        while True:
            found = self._next()
            if found.get('id') == self._number:
                if 'error' in found:
                    raise RuntimeError(f'{method}: {found["error"]}')
                return found['result']
            self.events.append(found)

    def _next(self, patience=30.0):
        end = time.monotonic() + patience
        while b'\0' not in self._buffer:
            ready, _, _ = select.select([self._read], [], [], max(0.0, end - time.monotonic()))
            data = os.read(self._read, 1 << 20) if ready else b''
            if not data:
                raise RuntimeError('the browser does not answer')
            self._buffer += data
        message, _, self._buffer = self._buffer.partition(b'\0')
        return json.loads(message)

    def open(self, path, width=1200, height=900, media='', scheme='light'):
        """Open a file in a window of this size; wait until it is loaded."""
        self.call(
            'Emulation.setDeviceMetricsOverride',
            width=width, height=height, deviceScaleFactor=1, mobile=False,
        )  # fmt: skip
        features = [{'name': 'prefers-color-scheme', 'value': scheme}]
        self.call('Emulation.setEmulatedMedia', media=media, features=features)
        self.events.clear()
        self.call('Page.navigate', url=path.resolve().as_uri())
        while not any(event['method'] == 'Page.loadEventFired' for event in self.events):
            self.events.append(self._next())

    def eval(self, expression):
        """Return what an expression of JavaScript gives on the page."""
        found = self.call('Runtime.evaluate', expression=expression, returnByValue=True)
        assert 'exceptionDetails' not in found, found['exceptionDetails']
        return found['result'].get('value')

    def press(self, key):
        """Press a key and let it go."""
        text = {'text': key} if len(key) == 1 else {}
        self.call('Input.dispatchKeyEvent', type='keyDown', key=key, **text)
        self.call('Input.dispatchKeyEvent', type='keyUp', key=key)

    def mouse(self, kind, x, y, **more):
        """Move the mouse, press its button or let it go."""
        self.call('Input.dispatchMouseEvent', type=kind, x=x, y=y, **more)

    def said(self):
        """Return what stands on the console: messages, errors, violated policies."""
        kinds = ('Runtime.consoleAPICalled', 'Runtime.exceptionThrown', 'Log.entryAdded')
        return [event for event in self.events if event['method'] in kinds]

    def asked(self):
        """Return the addresses of all requests; what the page itself holds (data:) is none."""
        return [
            event['params']['request']['url']
            for event in self.events
            if event['method'] == 'Network.requestWillBeSent'
            and not event['params']['request']['url'].startswith('data:')
        ]
