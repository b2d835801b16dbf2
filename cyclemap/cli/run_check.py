"""`cyclemap check`: what is likely wrong with a file for one's own object, and a picture of it."""

from pathlib import Path

from cyclemap.cli.output import PeopleConsole, publish_json
from cyclemap.errors import InvalidInput
from cyclemap.protocol.own_object import check_collection
from cyclemap.text_files import write_whole
from cyclemap.views.object_page import object_page
from cyclemap.views.style import render
from cyclemap.written import Json


def run_check(file: Path, out: Path, json_target: str | None) -> None:
    """Check the file, and draw it under `out`."""
    tell_check(file, out / f"check_{file.stem}.png", json_target, [])


def tell_check(file: Path, picture: Path, json_target: str | None, said: list[str]) -> None:
    """Check a file, draw it, and tell what was said before and what was found; InvalidInput where
    nothing would run.
    """
    found = check_collection(file)
    wrong = [finding.words for finding in found.findings if finding.wrong]
    doubts = [finding.words for finding in found.findings if not finding.wrong]
    write_whole(picture, render(object_page(found)))
    report: Json = {
        "file": str(file),
        "said": said,
        "wrong": wrong,
        "doubts": doubts,
        "picture": str(picture),
    }
    if not publish_json(report, json_target):
        console = PeopleConsole()
        for line in (*said, *(f"check: {words}" for words in doubts)):
            console.print(line)
        if not (wrong or doubts):
            console.print(f"{file}: nothing to object to", style="bold")
        console.print(f"picture: {picture}")
    if wrong:
        raise InvalidInput(f"{file}: {'; '.join(wrong)}")
    if json_target != "-":
        PeopleConsole().print(f"next: cyclemap portrait {file}")
