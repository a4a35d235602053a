"""`lucarna run SCRIPT [ARGS…]`: a Python script with the editor's operations, without a window."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from engine.core.errors import LucarnaError, UsageError

EPILOG = """
The script has run(id, **arguments), select(…), edit(…), open_file(…), save(…) and more: docs/scripting.md.
Exit codes: 0 done, what the script gives sys.exit(), 1 the script or its input is bad, 2 wrong usage, 3 could not run.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.epilog = EPILOG
    parser.add_argument("script", type=Path, help="a Python file")
    parser.add_argument("--open", type=Path, metavar="PATH", dest="opened", help="open this before")
    parser.add_argument("--gpu", action="store_true", help="with a graphics device, for scripts that take pictures")
    parser.add_argument("--json", action="store_true", help="say what was done as JSON on stdout")
    parser.add_argument("--log", action="store_true", help="say each operation on stderr as it is done")
    parser.add_argument("--no-plugins", action="store_true", help="without plug-ins")
    parser.add_argument(
        "--trust-plugins", action="store_true", help="run the plug-ins of a project that is opened, without being asked"
    )
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help="for the script, as sys.argv[1:]")


def run(args: argparse.Namespace) -> int:
    """Returns what the script exits with. Raises InputError with its file and line, UsageError, DeviceError."""
    if not args.script.is_file():
        hint = "" if args.script.exists() else "the script comes before its arguments: lucarna run SCRIPT ARGS"
        raise UsageError(f"{args.script} is no file", hint=hint)
    from editor.builtin_operations import builtin_operations
    from editor.plugins.manager import PluginManager
    from editor.script_run import ScriptRun, headless_session

    session = headless_session(gpu=args.gpu)
    operations = builtin_operations()
    if args.log:
        operations.listener = lambda line: print(f"> {line}", file=sys.stderr)
    going = ScriptRun(session, operations)
    plugins = PluginManager(session, operations, active=not args.no_plugins)
    plugins.start()
    going.after = lambda: _project_plugins(plugins, trusted=args.trust_plugins)
    stdout, error, code = sys.stdout, None, 0
    if args.json:
        sys.stdout = sys.stderr  # what the script prints is not for the machine
    try:
        if args.opened is not None:
            going.names["open_file"](args.opened)
        code = going.run(args.script, args.arguments)
    except LucarnaError as problem:
        error, code = problem, problem.exit_code
    finally:
        sys.stdout = stdout
    if args.json:
        print(json.dumps(_told(session, operations, error, code), indent=2))
    document = session.document
    if error is None and document is not None and document.dirty:
        print(f"lucarna: {document.name}: unsaved changes are gone; save() keeps them", file=sys.stderr)
    session.close()
    if error is not None:
        raise error
    return code


def _project_plugins(plugins: Any, *, trusted: bool) -> None:
    """Take up those of the project that is open now."""
    plugins.poll()
    if plugins.asking is not None and trusted:
        plugins.trust(always=False)
    elif plugins.asking is not None:
        plugins.decline()
        print("lucarna: this project's plug-ins were not run; --trust-plugins runs them", file=sys.stderr)


def _told(session: Any, operations: Any, error: LucarnaError | None, code: int) -> dict[str, Any]:
    document = session.document
    problem = None
    if error is not None:
        problem = {"message": error.message, "where": str(error.where), "hint": error.hint}
    return {
        "exit_code": code,
        "operations": list(operations.log),
        "document": None if document is None else str(document.source),
        "saved_to": str(document.saved_to) if document is not None and document.saved_to else None,
        "edits": len(document.history.entries) if document is not None else 0,
        "unsaved": bool(document is not None and document.dirty),
        "error": problem,
    }
