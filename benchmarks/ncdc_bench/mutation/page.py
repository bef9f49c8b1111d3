"""Writes the tables of ``docs/evidence/mutation.md`` from the report next to it.

    python -m ncdc_bench.mutation.page
"""

import json

from ncdc_bench.mutation.netlist import ROOT

__all__ = ["PAGE", "REPORT", "filled", "main"]

PAGE = ROOT / "docs" / "evidence" / "mutation.md"
REPORT = PAGE.with_suffix(".json")


def filled(page, report):
    """The text of the page with the tables of a ``report`` between their marks."""
    for name, lines in (("scores", _scores(report)), ("survivors", _survivors(report))):
        before, mark, rest = page.partition(f"<!--{name}-->\n")
        _, end, after = rest.partition("<!--end-->")
        page = "\n".join([before + mark, *lines, "", end + after])
    return page


def main():
    """Write the tables."""
    PAGE.write_text(filled(PAGE.read_text(), json.loads(REPORT.read_text())))


def _scores(report):
    rows = [*report["rows"], {"design": "all", "module": "", **report["summary"]}]
    return ["| design | module | mutants | killed | equivalent | survived | score |",
            "|---|---|---|---|---|---|---|",
            *(f"| {row['design']} | {_code(row['module'])} | {row['mutants']} | {row['killed']} | "
              f"{row['equivalent']} | {row['survived']} | {100 * row['score']:.1f} % |"
              for row in rows)]


def _survivors(report):
    lines = ["| module | line | change |", "|---|---|---|"]
    for row in report["rows"]:
        lines += [f"| {_code(row['module'])} | {one['line']} | {one['change']} |"
                  for one in row["survivors"]]
    return lines


def _code(name):
    return f"`{name}`" if name else ""


if __name__ == "__main__":
    main()
