"""Reports as one page of HTML: of a whole run, and of a user's camera."""

import jinja2

__all__ = ["camera_page", "report_page"]


def report_page(report, sections):
    """HTML text of the report of a whole run: what one shows a colleague.

    ``report``: figures by name, shown in full at the end. ``sections``: dicts with ``title``,
    ``text``, and optionally ``slider`` (two pictures, before and after), ``pictures``, ``rows``
    (lists of cells, the first row the heading) and ``commands`` (lines). Pictures are file names
    or data URIs.
    """
    return _page("report.html.jinja", "Camera distortion correction", sections, report=report)


def camera_page(title, lead, warnings, sections):
    """HTML text on a camera: a sentence below the title, warnings, and :func:`report_page`'s
    ``sections``."""
    return _page("camera.html.jinja", title, sections, lead=lead, warnings=warnings)


def _page(template, title, sections, **values):
    environment = jinja2.Environment(loader=jinja2.PackageLoader("ncdc.report", "."),
                                     autoescape=True, undefined=jinja2.StrictUndefined,
                                     trim_blocks=True, lstrip_blocks=True)
    return environment.get_template(template).render(title=title, sections=sections, **values)
