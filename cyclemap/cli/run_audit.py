"""`cyclemap audit`: what a data set that exists is worth, as a paragraph for its card, JSON and a
picture.
"""

from pathlib import Path

from cyclemap.cli.json_report import degrees, direction_deg
from cyclemap.cli.options import TableOptions, readable_data
from cyclemap.cli.output import PeopleConsole, file_stem, progress_bar, publish
from cyclemap.protocol.chosen_loop import loop_beside
from cyclemap.resets.monitor.audit import audit
from cyclemap.views.watch_page import audit_headline, audit_page, audit_paragraph


def run_audit(
    data: Path, table: TableOptions, out: Path, picture_format: str, json_target: str | None
) -> None:
    """Audit the data, draw it, and print the paragraph for its card, or all of it as JSON."""
    read = readable_data(data, table, out)
    with progress_bar(f"auditing {data.name}") as report:
        found = audit(read, loop=loop_beside(data), progress=report)
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
        "locked_towards_deg": []
        if alarm is None
        else [direction_deg(theta) for theta in alarm.directions],
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
    picture = publish(
        told, audit_page(found), out / f"audit_{file_stem(data.stem)}", picture_format, json_target
    )
    if picture is not None:
        PeopleConsole().tell(audit_headline(found), audit_paragraph(found), f"picture: {picture}")
