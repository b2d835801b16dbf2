"""The command `cyclemap doctor`: its options."""

import click


@click.command("doctor")
@click.option("--json", "json_target", metavar="FILE", help="Write the findings as JSON; - prints them.")
def doctor_command(json_target: str | None) -> None:
    """Tell what is installed, and how far cycles are from an independent solver's.

    The exit code is 1 where something that should work does not.
    """
    from cyclemap.cli.run_doctor import run_doctor

    run_doctor(json_target)
