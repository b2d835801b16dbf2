"""The entry point: the commands, and what every failure looks like from outside.

Exit codes: 0 done, 1 the computation or the disk failed, 2 bad use, 130 interrupted, 141 the reader
of the output went away.
"""

import gc
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

import click
from click.shell_completion import shell_complete

from cyclemap.cli.commands import cli as cli
from cyclemap.cli.options import one_line, shown_warnings
from cyclemap.errors import CycleMapError, InvalidInput

# Pictures go to files: no screen that the user's own drawing wants, be it there or not.
os.environ["MPLBACKEND"] = "agg"
# One thread does small linear algebra fastest; two that share a busy core take several times as
# long.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# New objects between two looks for garbage: Python's own 700 are meant for less than a drawing
# makes.
_ALLOCATIONS = 10_000
# By this variable a shell asks which words may follow, or for the script that makes it ask.
_COMPLETE = "_CYCLEMAP_COMPLETE"
DONE, FAILED, BAD_USE, INTERRUPTED, NO_READER = 0, 1, 2, 130, 141


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line with `arguments` (those of the process by default), and exit."""
    # What a command imports lives as long as it does: looking through it for garbage takes a tenth
    # of a short one.
    gc.set_threshold(_ALLOCATIONS)
    code = run(sys.argv[1:] if arguments is None else arguments)
    gc.freeze()
    sys.exit(code)


def run(arguments: Sequence[str]) -> int:
    """Run the command line and return the exit code; every failure is one line on stderr."""
    if sys.stderr is None:
        sys.stderr = Path(os.devnull).open("w", encoding="utf-8")  # noqa: SIM115
    if asked := os.environ.get(_COMPLETE):
        return shell_complete(cli, {}, "cyclemap", _COMPLETE, asked)
    if sys.stdout is None:
        return _complain("standard output is closed; send it to a file, or to /dev/null", FAILED)
    try:
        # A terminal that cannot show θ gets a replacement sign, not a traceback.
        if hasattr(sys.stdout, "reconfigure"):
            sys.stdout.reconfigure(errors="replace")
        with shown_warnings(), cli.make_context("cyclemap", list(arguments)) as context:
            cli.invoke(context)
        sys.stdout.flush()
    except click.exceptions.Exit as end:
        return end.exit_code
    except click.exceptions.NoArgsIsHelpError as empty:
        click.echo(empty.format_message(), err=True)
        return BAD_USE
    except click.ClickException as error:
        return _complain(error.format_message(), BAD_USE)
    except InvalidInput as error:
        return _complain(str(error), BAD_USE)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return NO_READER
    except (CycleMapError, OSError) as error:
        return _complain(str(error), FAILED)
    except (KeyboardInterrupt, click.Abort):
        return INTERRUPTED
    return DONE


def _complain(message: str, code: int) -> int:
    click.echo(f"error: {one_line(message)}", err=True)
    return code
