"""`cyclemap audit`: what a data set that exists is worth, as a paragraph for its card, JSON and a
picture.
"""

from pathlib import Path

from cyclemap.cli.options import ResultOptions, TableOptions, readable_data
from cyclemap.cli.output import file_stem, progress_bar, publish
from cyclemap.protocol.chosen_loop import loop_beside
from cyclemap.resets.audit import audit
from cyclemap.views.watch_page import audit_headline, audit_page, audit_paragraph
from cyclemap.written import degrees, direction_deg, json_of


def run_audit(data: Path, table: TableOptions, results: ResultOptions) -> None:
    """Audit the data, draw it, and print the paragraph for its card, or all of it as JSON."""
    read = readable_data(data, table, results.out)
    with progress_bar(f"auditing {data.name}") as progress:
        found = audit(read, loop=loop_beside(data), progress=progress)
    alarm, reset = found.report.alarm, found.reset
    told = {
        "data": str(data),
        "headline": audit_headline(found),
        "paragraph": audit_paragraph(found),
        "pushes": len(found.theta),
        **json_of(found, "others", "ordered", "covered"),
        "covered_share": found.report.coverage.covered,
        "locked_from": found.locked_from,
        "locked_towards_deg": [] if alarm is None else [*map(direction_deg, alarm.directions)],
        "worth": found.worth,
        "reset": None
        if reset is None
        else {
            "push_turn_deg": degrees(reset.push_turn.mean()),
            "reset_turn_deg": degrees(reset.reset_turn.mean()),
            **json_of(reset, "undone", "slope"),
        },
        "good": found.is_good,
    }
    publish(
        told,
        audit_page(found),
        results.out / f"audit_{file_stem(data.stem)}",
        results,
        audit_headline(found),
        audit_paragraph(found),
    )
