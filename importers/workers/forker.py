"""The host's side of the fork server: where it is enabled (warm workers on Linux), run_in_worker is served by it.

Only a saving: the child is the same code under the same limits, and every other system starts a new process instead.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading
from pathlib import Path

from importers.workers.process import environment


class Forker:
    """Starts one fork server per module, when first asked. Used by one thread at a time."""

    def __init__(self) -> None:
        self._servers: dict[str, subprocess.Popen[bytes]] = {}

    def run(self, module: str, folder: Path, seconds: float) -> int | None:
        """The exit code of a child that did the work in `folder`; None when it had to be stopped.

        Raises OSError where there is no such server; then a new process must do."""
        server = self._server(module)
        assert server.stdin is not None
        assert server.stdout is not None
        try:
            server.stdin.write(os.fsencode(folder) + b"\n")
            server.stdin.flush()
        except OSError:
            self._servers.pop(module, None)
            _end(server)
            raise
        stopped = threading.Event()

        def stop() -> None:
            stopped.set()
            os.kill(child, 9)

        child = int(self._answer(server, module, b"pid "))
        clock = threading.Timer(seconds, stop)
        clock.start()
        try:
            code = int(self._answer(server, module, b"code "))
        finally:
            clock.cancel()
        return None if stopped.is_set() else code

    def close(self) -> None:
        """End the servers; a later `run` starts new ones."""
        for server in self._servers.values():
            _end(server)
        self._servers.clear()

    def _answer(self, server: subprocess.Popen[bytes], module: str, word: bytes) -> bytes:
        assert server.stdout is not None
        line = server.stdout.readline()
        if not line.startswith(word):
            self._servers.pop(module, None)
            _end(server)
            raise OSError("the fork server is gone")
        return line[len(word) :]

    def _server(self, module: str) -> subprocess.Popen[bytes]:
        server = self._servers.get(module)
        if server is None:
            server = subprocess.Popen(
                [sys.executable, "-P", "-m", "importers.workers.forkserver", module],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment(), start_new_session=True,
            )  # fmt: skip
            self._servers[module] = server
        return server


def _end(server: subprocess.Popen[bytes]) -> None:
    server.kill()
    for pipe in (server.stdin, server.stdout):
        if pipe is not None:
            with contextlib.suppress(OSError):
                pipe.close()
    server.wait()


_enabled: list[Forker] = []


def enable() -> None:
    """From now on this process forks; for workers, which have no thread that holds a lock while they wait."""
    if sys.platform == "linux" and not _enabled and not os.environ.get("LUCARNA_NO_FORK"):
        _enabled.append(Forker())


def forker() -> Forker | None:
    return _enabled[0] if _enabled else None
