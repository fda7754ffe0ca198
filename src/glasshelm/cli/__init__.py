"""The command line: imports only the command it runs, and reports bad input in one line."""

import functools
import importlib
import os
import sys
from collections.abc import Callable
from typing import Any

from glasshelm import __version__

#: Name and help of each command: a module of this package with a function ``run``, whose typed
#: parameters tyro turns into options.
COMMANDS = {
    "bridge": "Show simulated, recorded or live traffic on a web page, with explained advice",
    "certify": "Say what is certain of a logged decision while the sensors err within bounds",
    "evaluate": "Evaluate pilots on suites of encounters: safety, COLREGs, efficiency",
    "explain": "Simulate an encounter and explain it: figures, frames, report.html",
    "faithfulness": "Test whether the explanations of a pilot are true",
    "paper": "Make every table and figure of the paper on one page",
    "run": "Simulate an encounter and write its frames",
    "train": "Train a pilot",
    "why": "Compare the pilot's manoeuvre at a frame of a log with another course, ship by ship",
    "whatif": "Branch a log: what would have happened if something had been different?",
}


def main(argv: list[str] | None = None) -> int:
    """Run a command and report errors in one line; ``GLASSHELM_DEBUG`` adds the traceback.

    Returns:
        The exit status. 2: bad input, or a file or device that fails; 70: an internal error; 130:
        interrupted; 141: nobody reads the output any more.
    """
    args = sys.argv[1:] if argv is None else argv
    if not args or args[0] in ("-h", "--help"):
        print(_help())
        return 0
    if args[0] == "--version":
        print(f"glasshelm {__version__}")
        return 0
    from glasshelm.core import terminal
    from glasshelm.core.errors import InputError

    if argv is None:
        terminal.as_program()
    if args[0] not in COMMANDS:
        known = ", ".join(COMMANDS)
        terminal.print_error(f"unknown command {args[0]!r}: choose one of {known}")
        return 2
    try:
        module = importlib.import_module(f"glasshelm.cli.{args[0]}")
        import tyro

        try:
            tyro.cli(_with_compile_cache(module.run), prog=f"glasshelm {args[0]}", args=args[1:])
        finally:
            sys.stdout.flush()
    except InputError as error:
        terminal.print_error(str(error))
        return 2
    except KeyboardInterrupt:
        terminal.print_error("interrupted")
        return 130
    except BrokenPipeError:  # the reader of our output has gone: `glasshelm run … | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except Exception as error:
        if terminal.debugging():
            raise
        if isinstance(error, OSError):
            where = "" if error.filename is None else f"{error.filename}: "
            terminal.print_error(f"{where}{error.strerror or error}")
            return 2
        terminal.print_error(
            f"internal error: {type(error).__name__}: {str(error)[:500]}; "
            "run with GLASSHELM_DEBUG=1 for the traceback, and report it"
        )
        return 70
    return 0


def _with_compile_cache(run: Callable[..., None]) -> Callable[..., None]:
    """The same command; compiled programs are kept once its options have been read."""

    @functools.wraps(run)
    def run_cached(*args: Any, **options: Any) -> None:
        from glasshelm.core.compile_cache import enable_compile_cache

        enable_compile_cache()
        run(*args, **options)

    return run_cached


def _help() -> str:
    width = max(map(len, COMMANDS))
    lines = [f"  {name:<{width}}  {line}" for name, line in COMMANDS.items()]
    return "\n".join(
        [
            "usage: glasshelm COMMAND [options]",
            "",
            "Explainable AI for ship collision avoidance. Not for navigation.",
            "",
            *lines,
            "",
            "glasshelm COMMAND --help shows the options of a command.",
        ]
    )
