"""report.html: what one shows a colleague."""

import jinja2

__all__ = ["report_page"]


def report_page(report, sections):
    """HTML text of a report.

    ``report``: figures by name, shown in full at the end. ``sections``: dicts with ``title``,
    ``text``, and optionally ``pictures`` (file names) and ``rows`` (lists of cells, the first
    row the heading).
    """
    environment = jinja2.Environment(loader=jinja2.PackageLoader("ncdc.report", "."),
                                     autoescape=True, undefined=jinja2.StrictUndefined,
                                     trim_blocks=True, lstrip_blocks=True)
    return environment.get_template("report.html.jinja").render(report=report, sections=sections)
