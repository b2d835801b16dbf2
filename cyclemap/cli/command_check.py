"""`cyclemap check`: what is likely wrong with a collection file, in plain words, and a picture of what it says."""

from pathlib import Path

import click


@click.command("check")
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--out", metavar="DIR", type=click.Path(path_type=Path), default="out", show_default=True, help="Of the picture."
)
@click.option("--json", "json_target", metavar="FILE", help="Write JSON there; '-' prints JSON and nothing else.")
def check_command(file: Path, out: Path, json_target: str | None) -> None:
    """Look at a collection FILE.toml as a careful colleague would: say what is likely wrong, and draw it."""
    tell_check(file, out / f"check_{file.stem}.png", json_target, [])


def tell_check(file: Path, picture: Path, json_target: str | None, said: list[str]) -> None:
    """Check a file, draw it, and tell what was said before and what was found; InvalidInput where nothing would run."""
    from cyclemap.cli.output import publish_json
    from cyclemap.cli.terminal import PeopleConsole
    from cyclemap.collection.own_object import check_collection
    from cyclemap.errors import InvalidInput
    from cyclemap.views.object_page import object_page
    from cyclemap.views.style import render
    from cyclemap.whole_files import write_whole

    found = check_collection(file)
    wrong = [finding.words for finding in found.findings if finding.wrong]
    doubts = [finding.words for finding in found.findings if not finding.wrong]
    write_whole(picture, render(object_page(found)))
    report: dict[str, object] = {
        "file": str(file),
        "said": said,
        "wrong": wrong,
        "doubts": doubts,
        "picture": str(picture),
    }
    if not publish_json(report, json_target):
        console = PeopleConsole()
        for line in said:
            console.print(line)
        for words in doubts:
            console.print(f"check: {words}")
        if not (wrong or doubts):
            console.print(f"{file}: nothing to object to", style="bold")
        console.print(f"picture: {picture}")
    if wrong:
        raise InvalidInput(f"{file}: {'; '.join(wrong)}")
    if json_target != "-":
        PeopleConsole().print(f"next: cyclemap portrait {file}")
