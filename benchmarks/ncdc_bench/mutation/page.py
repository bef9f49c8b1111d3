"""Writes the tables of ``docs/evidence/mutation.md`` from the report next to it.

    python -m ncdc_bench.mutation.page
"""

import json

from ncdc_bench.mutation.netlist import ROOT
from ncdc_bench.mutation.reasons import explained
from ncdc_bench.mutation.score import summary

__all__ = ["PAGE", "REPORT", "filled", "main", "reasoned"]

PAGE = ROOT / "docs" / "evidence" / "mutation.md"
REPORT = PAGE.with_suffix(".json")


def filled(page, report):
    """The text of the page with the tables of a ``report`` between their marks."""
    for name, lines in (("scores", _scores(report)), ("survivors", _survivors(report)),
                        ("argued", _survivors(report, "argued"))):
        before, mark, rest = page.partition(f"<!--{name}-->\n")
        _, end, after = rest.partition("<!--end-->")
        page = "\n".join([before + mark, *lines, "", end + after])
    return page


def main():
    """Apply the reasons to the report, and write it and the tables."""
    report = reasoned(json.loads(REPORT.read_text()))
    REPORT.write_text(json.dumps(report, indent=1) + "\n")
    PAGE.write_text(filled(PAGE.read_text(), report))


def reasoned(report):
    """The ``report`` with the present reasons of all its survivors."""
    rows = [explained(row) for row in report["rows"]]
    return report | {"rows": rows, "summary": summary(rows)}


def _scores(report):
    every = [one for row in report["rows"] for one in row.get("argued", ())]
    rows = [*report["rows"], {"design": "all", "module": "", "argued": every, **report["summary"]}]
    return ["| design | module | mutants | killed | equivalent | (argued) | survived | score |",
            "|---|---|---|---|---|---|---|---|",
            *(f"| {row['design']} | {_code(row['module'])} | {row['mutants']} | {row['killed']} | "
              f"{row['equivalent']} | {len(row.get('argued', ()))} | {row['survived']} | "
              f"{100 * row['score']:.1f} % |" for row in rows)]


def _survivors(report, kind="survivors"):
    lines = ["| design | module | line | change | reason |", "|---|---|---|---|---|"]
    for row in report["rows"]:
        lines += [f"| {row['design']} | {_code(row['module'])} | {one['line']} | {one['change']} | "
                  f"{one.get('why', '')} |" for one in row.get(kind, ())]
    return lines


def _code(name):
    return f"`{name}`" if name else ""


if __name__ == "__main__":
    main()
