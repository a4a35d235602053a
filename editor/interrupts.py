"""Ctrl+C in the terminal and the system's "please end", while the window sleeps in its library and runs no Python.

signal ──► the interpreter writes a byte (set_wakeup_fd) ──► a thread reads it ──► wake() ──► the next frame sees it
"""

from __future__ import annotations

import contextlib
import signal
import socket
import threading
from collections.abc import Iterator
from types import FrameType

from editor.waking import wake

SIGNALS = tuple(s for s in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, s))


class Interrupts:
    """`signal`: the number of the one that came, or 0. The first asks the window to end; a second one of its kind does
    what it would have done without this, for a window that no longer answers."""

    def __init__(self) -> None:
        self.signal = 0

    @contextlib.contextmanager
    def listening(self) -> Iterator[None]:
        """While the window runs. On another thread than the main one signals stay as they are."""
        if threading.current_thread() is not threading.main_thread():
            yield
            return
        ours, theirs = socket.socketpair()
        for end in (ours, theirs):
            end.setblocking(False)
        before = {number: signal.getsignal(number) for number in map(_number, SIGNALS)}
        # one that is ignored (nohup) stays ignored; None: not set from Python, so nobody could put it back
        mine = [n for n, handler in before.items() if handler is not None and handler != signal.SIG_IGN]

        def come(number: int, _frame: FrameType | None) -> None:
            self.signal = number
            signal.signal(number, before[number])
            wake()

        fd_before = signal.set_wakeup_fd(ours.fileno(), warn_on_full_buffer=False)
        for number in mine:
            signal.signal(number, come)
        theirs.setblocking(True)
        thread = threading.Thread(target=_listen, args=(theirs,), name="signals", daemon=True)
        thread.start()
        try:
            yield
        finally:
            signal.set_wakeup_fd(fd_before)
            for number in mine:
                signal.signal(number, before[number])
            ours.close()  # ends the thread's reading
            thread.join(1.0)
            theirs.close()


def _number(name: str) -> int:
    return int(getattr(signal, name))


def _listen(end: socket.socket) -> None:
    with contextlib.suppress(OSError):
        while end.recv(64):
            wake()
