"""`cyclemap audit`: what a data set that exists is worth, as a paragraph for its card, JSON and a picture."""

from __future__ import annotations

from pathlib import Path

import click

from cyclemap.cli.options import PATH, readable_data, result_options, table_options


@click.command("audit")
@click.argument("data", type=PATH)
@table_options
@result_options("audit_DATA.png and .json")
def audit_command(
    data: Path, columns: str | None, units: str | None, out: Path, picture_format: str, json_target: str | None
) -> None:
    """Audit a data set of pushes: what it covers, where it locked in, what it is worth, what its reset did.

    DATA is a file, folder or tree in the MIT layout, or a table: orientations alone tell much, poses more.
    """
    from cyclemap.cli.json_report import degrees, direction_deg
    from cyclemap.cli.output import PeopleConsole, file_stem, progress_bar, publish
    from cyclemap.resets.monitor.audit import audit
    from cyclemap.views.audit_page import audit_headline, audit_page, audit_paragraph

    read = readable_data(data, columns, units, out)
    with progress_bar(f"auditing {data.name}") as report:
        found = audit(read, progress=report)
    alarm, reset = found.report.alarm, found.reset
    told = {
        "data": str(data),
        "headline": audit_headline(found),
        "paragraph": audit_paragraph(found),
        "pushes": len(found.theta),
        "pushes_of_other_sets": found.others,
        "order_known": found.ordered,
        "covered_deg": [[direction_deg(low), direction_deg(high)] for low, high in found.covered],
        "covered_share": found.report.coverage.covered,
        "locked_from": found.locked_from,
        "locked_towards_deg": [] if alarm is None else [direction_deg(theta) for theta in alarm.directions],
        "worth": found.worth,
        "reset": None
        if reset is None
        else {
            "push_turn_deg": degrees(float(reset.push_turn.mean())),
            "reset_turn_deg": degrees(float(reset.reset_turn.mean())),
            "undone": reset.undone,
            "slope": reset.slope if reset.slope == reset.slope else None,
        },
        "good": found.is_good,
    }
    picture = publish(told, audit_page(found), out / f"audit_{file_stem(data.stem)}", picture_format, json_target)
    if picture is not None:
        PeopleConsole().tell(audit_headline(found), audit_paragraph(found), f"picture: {picture}")
