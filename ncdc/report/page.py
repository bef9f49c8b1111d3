"""Reports as one page of HTML: of a whole run, of a user's camera, and of a production lot."""

import jinja2

from ncdc_spec.files import replace_file

__all__ = ["camera_page", "report_page", "write_lot_page"]

_LINES = 1000           # parts of a page that are written at a time


def report_page(report, sections):
    """HTML text of the report of a whole run: what one shows a colleague.

    ``report``: figures by name, shown in full at the end. ``sections``: dicts with ``title``,
    ``text``, and optionally ``slider`` (two pictures, before and after), ``legend`` (pairs of a
    colour and a name), ``pictures``, ``rows`` (lists of cells, the first row the heading) and
    ``commands`` (lines). Pictures are file names or data URIs.
    """
    return _page("report.html.jinja", "Camera distortion correction", sections, report=report)


def camera_page(title, lead, warnings, sections):
    """HTML text on a camera: a sentence below the title, warnings, and :func:`report_page`'s
    ``sections``."""
    return _page("camera.html.jinja", title, sections, lead=lead, warnings=warnings)


def write_lot_page(path, title, lead, sections, **lists):
    """Write a page on a lot to the file ``path``, with :func:`report_page`'s ``sections``.

    ``lists``: ``groups`` of units with pictures, (title, text, units) each; titles of the
    ``columns`` of the table of all units, and its ``rows``, each as JSON, which may be an iterator.
    """
    page = _template("lot.html.jinja").stream(title=title, lead=lead, warnings=(),
                                              sections=sections, **lists)
    page.enable_buffering(_LINES)
    with replace_file(path) as temporary:
        # Names of files may be no UTF-8.
        page.dump(str(temporary), encoding="utf-8", errors="replace")


def _page(template, title, sections, **values):
    return _template(template).render(title=title, sections=sections, **values)


def _template(name):
    environment = jinja2.Environment(loader=jinja2.PackageLoader("ncdc.report", "."),
                                     autoescape=True, undefined=jinja2.StrictUndefined,
                                     trim_blocks=True, lstrip_blocks=True)
    return environment.get_template(name)
