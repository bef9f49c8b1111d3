"""Figures that pages quote by name: stored in ``docs/figures.json``, written into the pages.

    python -m ncdc_bench.figures.quote RESULT.json...

takes reports of ``ncdc demo``, ``train``, ``evaluate``, ``simulate`` and ``bench NAME``
(``--json``), stores the numbers that pages quote, with the command, the date and the version, and
writes them into the pages. Reports of one command are joined: their rows, or each is a row. Without
a report it writes the stored numbers.

A quote is an HTML comment after a number. The site and other viewers do not show it::

    The largest error is 0.405<!--=demo.errors.frame_fixed.max--> px.

The number keeps its decimals. Before a table, a comment names a table of figures and gives the
form of a row; every row is written anew, but for cells whose form is "*". Before a block of code,
it is the form of lines in it::

    <!--rows=tansig | {variant} | {bits:d} | {max:.3f} |-->

A field with a format for numbers is a number, any other is text. A figure that is null is "-".
"""

import argparse
import json
import re
import string
import sys
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

from ncdc_bench.figures.chosen import GROUPS, groups_of
from ncdc_spec.errors import InputError
from ncdc_spec.files import write_text

__all__ = ["ROOT", "STORE", "Quote", "copies", "leaves", "load", "main", "pages", "prune",
           "quoted_leaves", "quotes", "rewrite", "store"]

ROOT = Path(__file__).resolve().parents[3]
STORE = "docs/figures.json"
_NUMBER = r"[-+]?\d[\d,]*(?:\.\d+)?"
_INLINE = re.compile(rf"(?<![\w.,])({_NUMBER})<!--=([\w.]+)-->")
_MARK = re.compile(r"<!--=(.*?)-->")
_ROWS = re.compile(r"<!--rows=([\w.]+) (.*)-->")
_COPY_DIGITS = 4        # of a number that is unlikely to occur twice


@dataclass(frozen=True)
class Quote:
    """A quoted number or table of a page.

    Parameters
    ----------
    name : str
        Of the figure, or of the table.
    line : int
        Line of the page, from 1.
    shown, right : list of str
        What the page shows, and what the figures give in the same form.
    fields : tuple of str
        Fields of each row of a table; empty for a number.
    """
    name: str
    line: int
    shown: list
    right: list
    fields: tuple = ()


class _Form(string.Formatter):
    """Formats rows; None becomes "-", and ".3r" stands for 3 digits without an exponent."""

    def format_field(self, value, spec):
        if value is None:       # with the width alone
            value, spec = "-", re.match(r"[<>]?\d*", spec)[0]
        elif match := re.fullmatch(r"\.(\d)r", spec):
            digits = int(match[1]) - 1 - int(f"{value:.{int(match[1]) - 1}e}".partition("e")[2])
            spec = f".{max(0, digits)}f"
        return super().format_field(value, spec)


def pages(root):
    """Paths of the pages that may quote figures."""
    return [root / "README.md", root / "CONTRIBUTING.md", *sorted((root / "docs").rglob("*.md"))]


def _groups(root):
    """The stored groups: command, date, version, and figures or the report that has them."""
    path = root / STORE
    return json.loads(path.read_text()) if path.exists() else {}


def load(root):
    """The figures by group.

    A group with ``report`` has its figures in that file of ``docs``, as the bench writes it.
    """
    return {name: _chosen(name, json.loads((root / "docs" / group["report"]).read_text()))
            if "report" in group else group["figures"] for name, group in _groups(root).items()}


def _chosen(name, report):
    """The figures of a report of group ``name``, as JSON keeps them."""
    try:
        return json.loads(json.dumps(GROUPS[name].choose(report)))
    except KeyError as error:
        raise InputError(f"the report of {GROUPS[name].command} has no {error}") from None


def _figure(figures, name):
    """A figure, or a table of them, by its name."""
    for part in name.split("."):
        if not isinstance(figures, dict) or part not in figures:
            raise InputError(f"no figure is named {name}")
        figures = figures[part]
    return figures


def _like(value, shown):
    """``value`` with the decimals, the sign and the separators of the number ``shown``."""
    whole, _, decimals = shown.partition(".")
    comma = "" if re.search(r"\d{4}", whole) else ","
    return f"{value:{'+' if shown.startswith('+') else ''}{comma}.{len(decimals)}f}"


def _rows(figures, name):
    """Rows of the table ``name``, or of all tables in it; numbers alone are a table of one row."""
    table = _figure(figures, name)
    if not isinstance(table, dict):
        raise InputError(f"{name} is a number, not a table")
    if not all(isinstance(row, dict) for row in table.values()):
        return [table]
    return [row for part in table for row in _rows(table, part)]


def _fields(form):
    """(text before, field, format) of each field of a form."""
    return [(text, field, spec) for text, field, spec, _ in string.Formatter().parse(form)]


def _is_number(spec):
    return bool(re.search(r"[dfr,]$", spec or ""))


def _matcher(form, rows):
    """Pattern of a line of code in this form: any numbers, and texts of these rows."""
    pattern = ""
    for text, field, spec in _fields(form):
        pattern += re.escape(text)
        if field and _is_number(spec):
            pattern += rf" *(?:{_NUMBER}|-)"
        elif field:
            pattern += f"(?:{'|'.join(re.escape(f'{row[field]:{spec}}') for row in rows)})"
    return re.compile(pattern.rstrip())


def _lines_of_form(lines, start, form, rows):
    """Indices of the lines that a form, in line ``start``, stands for."""
    first = start + 1
    while first < len(lines) and (not lines[first].strip() or _ROWS.fullmatch(lines[first])):
        first += 1
    last = first
    while last < len(lines) and lines[last].strip():
        last += 1
    if first < last and lines[first].startswith("|"):
        return list(range(first + 2, last))
    matcher = _matcher(form, rows)
    return [k for k in range(first, last) if matcher.fullmatch(lines[k].strip())]


def _table(lines, start, figures, name, form):
    """Quote of a table, and the indices of its lines."""
    rows = _rows(figures, name)
    fields = tuple(field for _, field, _ in _fields(form) if field)
    if missing := [field for field in fields for row in rows if field not in row]:
        raise InputError(f"a row of {name} has no {missing[0]}")
    found = _lines_of_form(lines, start, form, rows)
    if not found:
        raise InputError(f"no line below has the form of {name}")
    shown = [lines[k] for k in found]
    indent = shown[0][:len(shown[0]) - len(shown[0].lstrip())]
    right = [indent + _Form().vformat(form, (), row) for row in rows]
    if "| * |" in form:
        if len(right) != len(shown):
            raise InputError(f"{name} has {len(right)} rows, the page has {len(shown)}")
        right = list(map(_with_own_cells, right, shown))
    return Quote(name, start + 1, shown, right, fields), found


def _with_own_cells(line, own):
    """A row with the page's ``own`` cells where it has "*"."""
    cells, mine = line.split("|"), own.split("|")
    if len(cells) != len(mine):
        raise InputError(f"the form has {len(cells) - 2} cells, the page has {len(mine) - 2}")
    return "|".join(old if cell == " * " else cell for cell, old in zip(cells, mine))


def quotes(text, figures):
    """Quotes of a page's ``text``, in order.

    Raises
    ------
    InputError
        If a quote names no figure, or has no number before it; the message begins with the line.
    """
    return [quote for quote, _ in _found(text.splitlines(), figures)]


def _found(lines, figures):
    """(quote, indices of its lines) of a page; for a number (quote, its match)."""
    found = []
    for k, line in enumerate(lines):
        try:
            if match := _ROWS.fullmatch(line):
                found.append(_table(lines, k, figures, *match.groups()))
            elif line.startswith("<!--rows="):
                raise InputError(f"{line} is not a form of rows")
            for match in _INLINE.finditer(line):
                value = _figure(figures, match[2])
                if not isinstance(value, (int, float)):
                    raise InputError(f"the figure {match[2]} is not a number")
                right = _like(value, match[1])
                found.append((Quote(match[2], k + 1, [match[1]], [right]), match))
            if len(_INLINE.findall(line)) < len(_MARK.findall(line)):
                raise InputError(f"a quote has no number before it: {line.strip()}")
        except (InputError, TypeError, ValueError) as error:    # the last two: of a format
            raise InputError(f"{k + 1}: {error}") from None
    return found


def rewrite(text, figures):
    """A page's ``text`` with the figures as they are. Errors raised: as :func:`quotes`."""
    lines = text.splitlines()
    for quote, where in reversed(_found(lines, figures)):
        if isinstance(where, re.Match):
            k, line = quote.line - 1, lines[quote.line - 1]
            lines[k] = line[:where.start(1)] + quote.right[0] + line[where.end(1):]
        elif len(where) == len(quote.right):
            for k, right in zip(where, quote.right):
                lines[k] = right
        elif where[-1] - where[0] + 1 == len(where):
            lines[where[0]:where[-1] + 1] = quote.right
        else:
            raise InputError(f"{quote.line}: {quote.name} has {len(quote.right)} rows, the page "
                             f"has {len(where)} lines that do not follow one another")
    return "\n".join(lines) + "\n"


def leaves(figures, above=()):
    """Names of all single figures, as tuples of their parts."""
    found = set()
    for part, value in figures.items():
        name = (*above, part)
        found |= leaves(value, name) if isinstance(value, dict) else {name}
    return found


def quoted_leaves(quoted, figures):
    """Those of :func:`leaves` that some of ``quoted`` shows."""
    found = set()
    for quote in quoted:
        name = tuple(quote.name.split("."))
        found |= {leaf for leaf in leaves(_figure(figures, quote.name), name)
                  if leaf[-1] in quote.fields} if quote.fields else {name}
    return found


def prune(figures, names, above=()):
    """The part of ``figures`` that ``names``, some of :func:`leaves`, are of."""
    stored = {part: prune(value, names, (*above, part)) if isinstance(value, dict) else value
            for part, value in figures.items()
            if isinstance(value, dict) or (*above, part) in names}
    return {part: value for part, value in stored.items() if value != {}}


def copies(text, found, shown):
    """(line, number) of the numbers in prose and tables that equal a quoted one, without a quote.

    Parameters
    ----------
    text : str
        A page.
    found : list of Quote
        Its quotes.
    shown : set of str
        Quoted numbers of all pages; short ones are left out, as unrelated ones may be equal.
    """
    rows = {line for quote in found if quote.fields for line in quote.shown}
    long_ones = {number for number in shown
                 if len(re.sub(r"\D", "", number).lstrip("0")) >= _COPY_DIGITS}
    return [(k, number) for k, line in enumerate(text.splitlines(), 1)
            if line not in rows and not line.startswith("    ")
            for number in re.findall(rf"(?<![\w.,])({_NUMBER})(?!<!--=|[\w.,]*\d)", line)
            if number in long_ones]


def _read(path):
    """(group, report) of a result file."""
    try:
        report = json.loads(Path(path).read_text())
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except ValueError:
        raise InputError(f"{path} is not JSON") from None
    names = groups_of(report) if isinstance(report, dict) else []
    if not names:
        raise InputError(f"{path} is not a report of {', '.join(GROUPS)}")
    for name in names:
        if GROUPS[name].accepts(report):
            return name, report
    raise InputError(f"{path} was not made by {GROUPS[names[0]].command}")


def _take(root, results, groups, figures):
    """Put the figures of ``results`` and where they come from into ``figures`` and ``groups``."""
    joined = {}
    for path in map(Path, results):
        name, report = _read(path)
        before = joined[name][0].get("rows", []) if name in joined else []
        joined[name] = report | {"rows": before + report.get("rows", [report])}, path
    for name, (report, path) in joined.items():
        day = datetime.fromtimestamp(path.stat().st_mtime, UTC).date()
        group = {"command": GROUPS[name].command, "date": str(day), "version": version("ncdc")}
        if stored := groups.get(name, {}).get("report"):
            if path.resolve() != (root / "docs" / stored).resolve():
                raise InputError(f"{path}: the figures of {name} are in docs/{stored}, "
                                 "write the report there")
            group["report"] = stored
        groups[name], figures[name] = group, _chosen(name, report)


def store(root, results):
    """Take the results' figures, write them into the pages, and store those that pages quote.

    Parameters
    ----------
    root : pathlib.Path
        The repository.
    results : sequence of path
        Reports as JSON. The date of the file is the date of the figures.

    Returns
    -------
    list of pathlib.Path
        Pages that have changed.

    Raises
    ------
    InputError
        If a result is of another kind, or a quote is wrong. Nothing is written then.
    """
    groups, figures = _groups(root), load(root)
    _take(root, results, groups, figures)
    texts, quoted = {}, []
    for page in pages(root):
        text = page.read_text()
        try:
            quoted += quotes(text, figures)
            if (right := rewrite(text, figures)) != text:
                texts[page] = right
        except InputError as error:
            raise InputError(f"{page.relative_to(root)}:{error}") from None
    stored = prune(figures, quoted_leaves(quoted, figures))
    for name, group in groups.items():
        if "report" not in group:
            group["figures"] = stored.get(name, {})
    for page, text in texts.items():
        write_text(page, text)
    groups = {name: group for name, group in sorted(groups.items())
              if group.get("figures") or "report" in group}
    write_text(root / STORE, json.dumps(groups, indent=1) + "\n")
    return list(texts)


def main(arguments=None):
    """Run the command; its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m ncdc_bench.figures.quote",
        description="store figures of reports and write them into the pages that quote them")
    parser.add_argument("results", nargs="*", metavar="RESULT.json",
                        help="report of ncdc demo, train or bench")
    try:
        for page in store(ROOT, parser.parse_args(arguments).results):
            print(page.relative_to(ROOT))
    except InputError as error:
        print(f"quote: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
