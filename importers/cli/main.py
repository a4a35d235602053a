"""Entry point of `lucarna`: finds the subcommand, imports its module alone, and turns errors into exit codes."""

from __future__ import annotations

import argparse
import difflib
import importlib
import io
import sys
from collections.abc import Sequence
from typing import NoReturn

from engine.core.errors import LucarnaError, UsageError
from importers.cli.interrupted import put_back

#: name -> (module, summary). Order = order in the help.
COMMANDS: dict[str, tuple[str, str]] = {
    "edit": ("importers.cli.edit", "open the editor on a project, a scene or a loose file"),
    "new": ("importers.cli.new", "make a project from the template"),
    "mv": ("importers.cli.mv", "rename or move a file of a project; what refers to it follows"),
    "convert": ("importers.cli.convert", "convert sources to engine files"),
    "inspect": ("importers.cli.inspect", "describe a source or engine file"),
    "check": ("importers.cli.check", "report what is wrong with sources, write nothing"),
    "cache": ("importers.cli.cache", "show or prune the cache of converted sources"),
    "export": ("importers.cli.export", "write scenes as GLB, or posed geometry as OBJ"),
    "lights": ("importers.cli.lights", "scatter many lights over a scene"),
    "run": ("importers.cli.run", "run a Python script with the editor's operations, without a window"),
    "render": ("importers.cli.render", "render a scene or source file to a picture, without a window"),
    "compare": ("importers.cli.compare", "how two pictures, or two ways to render a scene, differ"),
    "play": ("importers.cli.play", "show a scene in a plain window with a free camera"),
    "report": ("importers.cli.report", "measure error against time"),
    "doctor": ("importers.cli.doctor", "show the graphics device, libraries, and what to do about them"),
}

#: commands that only tell something
TELLING = ("inspect", "doctor", "cache")


class _Parser(argparse.ArgumentParser):
    """argparse, with our form of errors."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(message, hint=f"see `{self.prog} --help`")


def _general_help() -> str:
    width = max(map(len, COMMANDS))
    lines = ["usage: lucarna COMMAND [options]", "", "Turns 3D sources into engine files, renders and edits them.", ""]
    lines += ["commands:"] + [f"  {name:<{width}}  {summary}" for name, (_, summary) in COMMANDS.items()]
    lines += ["", "`lucarna COMMAND --help` explains one; `lucarna --version` prints the version."]
    lines += ["exit codes: 0 done, 1 some input is bad, 2 wrong usage, 3 could not run"]
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run `lucarna` with `arguments` (the process's own by default); returns the exit code."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    for stream in (sys.stdout, sys.stderr):
        # File names need not be valid text; a message about one must not fail for it
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        code = _run(words)
        print(end="", flush=True)  # what cannot be written must be said here, not at the interpreter's end
        return code
    except LucarnaError as error:
        print(f"lucarna: error: {error}", file=sys.stderr)
        return error.exit_code
    except BrokenPipeError:
        # The reader of our output is gone (`lucarna … | head`): nothing more to say, and nobody to say it to.
        # Where there was more to do than to say it, it stays undone, and that is no success
        sys.stderr.close()
        return 0 if not words or words[0] not in COMMANDS or words[0] in TELLING else 3
    except OSError as error:
        # a name that no file can have, a folder that may not be searched, a full disk behind our output
        where = f"{error.filename}: " if error.filename is not None else ""
        print(f"lucarna: error: {where}{error.strerror or error}", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        print("lucarna: interrupted", file=sys.stderr)
        return 130


def _run(words: list[str]) -> int:
    if not words or words[0] in ("-h", "--help", "help"):
        print(_general_help())
        return 0
    if words[0] in ("-V", "--version"):
        from importlib.metadata import PackageNotFoundError, version

        try:
            print(f"lucarna {version('lucarna')}")
        except PackageNotFoundError:
            print("lucarna, from a checkout")
        return 0
    name = words[0]
    if name not in COMMANDS:
        near = difflib.get_close_matches(name, COMMANDS, 1)
        raise UsageError(
            f"unknown command {name!r}", hint=f"did you mean `lucarna {near[0]}`?" if near else "see `lucarna --help`"
        )
    module_name, summary = COMMANDS[name]
    try:
        module = importlib.import_module(module_name)
    except ModuleNotFoundError as error:
        missing = error.name or module_name
        hint = "install Lucarna with its dependencies" if missing != module_name else "this build comes without it"
        raise LucarnaError(f"`lucarna {name}` cannot start: the module {missing} is missing", hint=hint) from error
    put_back(words[1:])
    parser = _Parser(prog=f"lucarna {name}", description=summary[0].upper() + summary[1:] + ".")
    module.add_arguments(parser)
    try:
        code: int = module.run(parser.parse_args(words[1:]))
    except SystemExit as stop:  # argparse ends `--help` this way
        return int(stop.code or 0)
    return code


if __name__ == "__main__":
    sys.exit(main())
