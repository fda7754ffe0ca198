"""The command line: finds the command, imports only that one, reports bad input in one line."""

import importlib
import os
import sys

from glasshelm import __version__

#: name -> one line of help. Each is a module of this package with a function
#: ``run`` whose typed parameters tyro turns into options.
COMMANDS = {
    "bridge": "Serve the live page: simulated, recorded or live traffic, advice and reasons",
    "evaluate": "Put pilots through suites of encounters: safety, rules, way, with intervals",
    "exam": "Put the explanations of a pilot to the test: which of them are true",
    "explain": "Sail an encounter and tell its story: figures, frames, report.html",
    "run": "Sail an encounter headless and write its frames",
    "train": "Train a pilot",
    "whatif": "Sail on from an instant of a log with something changed: what if?",
}


def main(argv: list[str] | None = None) -> int:
    """Entry point of ``glasshelm``; returns the exit status.

    2: bad input, or a file or device that does not do what is asked; 70: a fault of ours;
    130: interrupted; 141: nobody reads the output any more. Whatever goes wrong is one line
    on standard error; with ``GLASSHELM_DEBUG`` set, a traceback where there is one.
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
            tyro.cli(module.run, prog=f"glasshelm {args[0]}", args=args[1:])
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
            "glasshelm COMMAND --help tells a command's options.",
        ]
    )
