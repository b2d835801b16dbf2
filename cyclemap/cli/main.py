"""The entry point: the commands, and what every failure looks like from outside.

Exit codes: 0 done, 1 the computation or the disk failed, 2 bad use, 130 interrupted, 141 the reader of the
output went away.
"""

import gc
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NoReturn

import click
from click.shell_completion import shell_complete

from cyclemap.cli.command_audit import audit_command
from cyclemap.cli.command_doctor import doctor_command
from cyclemap.cli.command_dynamics import dynamics_command
from cyclemap.cli.command_experiment import experiment_command
from cyclemap.cli.command_explore import explore_command
from cyclemap.cli.command_init import check_command, init_command
from cyclemap.cli.command_probe import probe_command
from cyclemap.cli.command_report import report_command
from cyclemap.cli.command_reset import reset_command
from cyclemap.cli.command_watch import watch_command
from cyclemap.cli.commands import (
    compare_command,
    cycle_command,
    figures_command,
    fingerprint_command,
    fit_command,
    identify_command,
    portrait_command,
    replay_command,
    simulate_command,
    staircase_command,
    sweep_command,
)
from cyclemap.cli.options import one_line, quiet_option, told_warnings
from cyclemap.errors import CycleMapError, InvalidInput

# Pictures go to files: no screen that the user's own drawing wants, be it there or not.
os.environ["MPLBACKEND"] = "agg"
# One thread does small linear algebra fastest; two that share a busy core take several times as long.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# New objects between two looks for garbage: Python's own 700 are meant for less than a drawing makes.
_ALLOCATIONS = 10_000
# By this variable a shell asks which words may follow, or for the script that makes it ask.
_COMPLETE = "_CYCLEMAP_COMPLETE"
DONE, FAILED, BAD_USE, INTERRUPTED, NO_READER = 0, 1, 2, 130, 141


class _Commands(click.Group):
    """The commands, each listed with its whole first sentence."""

    def format_commands(self, context: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands into the help."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, one.get_short_help_str(limit=1000)) for name, one in self.commands.items()])


_SHOWN = {"help_option_names": ["-h", "--help"], "max_content_width": 100, "show_default": True}


@click.group(cls=_Commands, context_settings=_SHOWN)
@click.version_option(package_name="cyclemap")
def cli() -> None:
    """What a robot that pushes an object and drags it back will record, predicted from friction."""


for _command in (
    *(init_command, check_command, audit_command, probe_command),
    *(cycle_command, portrait_command, staircase_command, fingerprint_command),
    *(explore_command, dynamics_command, experiment_command, figures_command),
    *(simulate_command, fit_command, identify_command, compare_command, replay_command, watch_command),
    *(reset_command, report_command, sweep_command, doctor_command),
):
    _command.params.append(quiet_option())
    cli.add_command(_command)


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Run the command line with `arguments` (those of the process by default), and exit."""
    # What a command imports lives as long as it does: looking through it for garbage takes a tenth of a short one.
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
        with told_warnings(), cli.make_context("cyclemap", list(arguments)) as context:
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
