"""Running a script on a session without a window: every call is done when it returns, and what goes wrong is said with
the script's file and line. No imgui; no GPU where none is asked for."""

from __future__ import annotations

import sys
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from editor.operations import Operations
from editor.requests import UiRequests
from editor.script_names import script_names
from editor.session import Session
from engine.core.errors import InputError, LucarnaError, Place, UsageError
from engine.core.findings import Severity

#: requests that only a window can carry out -> what a script does instead
NEEDS_WINDOW = {
    "open_dialog": 'run("file.open-path", path=…)', "save_dialog": 'run("file.save-to", path=…)',
    "choose": "the operation with a path", "rename": 'run("edit.rename-to", name=…)', "palette": "run(id)",
    "help": "docs/operations.md", "about": "`lucarna --version`", "welcome": "nothing",
    "paste": "an operation with arguments",
}  # fmt: skip


class ScriptError(InputError):
    """A script went wrong; `where` is its file and line."""


class ScriptRun:
    """One script on one session. `names` are what it finds besides Python's own."""

    def __init__(self, session: Session, operations: Operations) -> None:
        self.session, self.operations = session, operations
        self.errors = _errors(session)
        #: called when an operation is done, before what went wrong is told
        self.after: Callable[[], None] = lambda: None
        self.names = script_names(session, operations, self.finish)

    def finish(self) -> None:
        """Wait for what the last operation began. Raises what went wrong with it, and UsageError where it asks
        something that only a window can."""
        session = self.session
        while True:
            session.poll()
            if session.job is None and session.work is None:
                break
            if session.job is not None:
                session.job.wait(0.02)
            time.sleep(0.0)
        session.end_gesture()
        self.after()
        session.playback.playing = False
        self._refuse_dialogs()
        failure, session.failure = session.failure, None
        session.ui.error_bar = ""
        if failure is not None:
            raise failure
        errors, self.errors = self.errors, _errors(session)
        if self.errors > errors:
            message = next(m for m in reversed(session.messages.snapshot()) if m.severity is Severity.ERROR)
            raise InputError(message.text, where=message.where, hint=message.hint)

    def _refuse_dialogs(self) -> None:
        requests = self.session.ui
        if requests.after_discard is not None:
            requests.after_discard = None
            raise UsageError("there are unsaved changes", hint="save() them, or undo them, before")
        fresh = UiRequests()
        for field in fields(UiRequests):
            if field.name in NEEDS_WINDOW and getattr(requests, field.name) != getattr(fresh, field.name):
                setattr(requests, field.name, getattr(fresh, field.name))
                raise UsageError("this asks in a window, and there is none", hint=f"use {NEEDS_WINDOW[field.name]}")

    def run(self, path: Path, arguments: Sequence[str] = ()) -> int:
        """Run the file with `sys.argv` as Python would; returns what it exits with. Raises ScriptError."""
        try:
            source = path.read_text(encoding="utf-8")
        except OSError as error:
            raise InputError(f"the script cannot be read: {error.strerror}", where=path) from error
        except UnicodeDecodeError as error:
            raise InputError("the script is no text in UTF-8", where=path) from error
        try:
            code = compile(source, str(path), "exec")
        except SyntaxError as error:
            place = Place(str(path), line=error.lineno or 0, column=error.offset or 0)
            raise ScriptError(f"this is no Python: {error.msg}", where=place) from None
        names: dict[str, Any] = {"__name__": "__main__", "__file__": str(path), **self.names}
        argv, folders = sys.argv, sys.path[:]
        sys.argv = [str(path), *arguments]
        sys.path.insert(0, str(path.resolve().parent))
        try:
            exec(code, names)
        except SystemExit as stop:
            return _exit_code(stop)
        except LucarnaError as error:
            raise _placed(error, path) from error
        except Exception as error:  # a script raises what it likes: told with its own line
            raise _placed(error, path) from error
        finally:
            sys.argv, sys.path[:] = argv, folders
        return 0


def _placed(error: Exception, path: Path) -> LucarnaError:
    """The error with the line of the script that led to it."""
    lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
    place = Place(str(path), line=(lines[-1] or 0) if lines else 0)
    if isinstance(error, LucarnaError):
        about = f"{error.where}: " if str(error.where) else ""
        return ScriptError(f"{about}{error.message}", where=place, hint=error.hint)
    words = traceback.format_exception_only(error)[-1].strip()
    return ScriptError(words, where=place)


def _exit_code(stop: SystemExit) -> int:
    """As Python would: nothing is 0, a number itself, text goes to stderr with 1."""
    if stop.code is None or isinstance(stop.code, int):
        return int(stop.code or 0)
    print(stop.code, file=sys.stderr)
    return 1


def _errors(session: Session) -> int:
    return session.messages.counts()[Severity.ERROR]


def headless_session(*, gpu: bool) -> Session:
    """A session that never writes preferences; without `gpu` on a device that draws nothing."""
    from editor.host import EngineHost
    from editor.preferences import Preferences
    from engine.gpu import open_device

    session = Session(EngineHost(), Preferences(welcome_seen=True))
    session.save_preferences = False
    session.device = open_device("gl" if gpu else "null")
    return session
