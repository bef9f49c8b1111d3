"""``ncdc target``: a page of a calibration target, to be printed."""

from pathlib import Path

from ncdc.cli.common import add_json, write_report
from ncdc.target.layout import KINDS, PAPERS, layout_of, paper_of
from ncdc_spec.errors import InputError
from ncdc_spec.files import write_bytes

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc target chessboard:9x6 --paper A4 -o page.pdf"
_FORMS = {".pdf": "pdf", ".svg": "svg"}


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    given = ", ".join(name + (":{}x{}".format(*size) if size else "")
                      for name, size in KINDS.items())
    parser.add_argument("target", metavar="KIND",
                        help=f"as ncdc calibrate --target has it; columns and rows may be left "
                             f"out: {given}; dots fill the page")
    parser.add_argument("--paper", default="A4", metavar="SIZE",
                        help=f"{', '.join(PAPERS)}, lying, or WxHmm, as in 400x300mm "
                             f"(default: A4)")
    parser.add_argument("--step", type=float, metavar="MM",
                        help="millimetres between neighbouring points; of a board, side of a "
                             "square or tag (default: as many as fit; of dots 10)")
    parser.add_argument("-o", "--output", required=True, metavar="FILE",
                        help="page to write: .pdf or .svg")
    add_json(parser)


def run(args) -> None:
    """Lay out, draw, write."""
    form = _FORMS.get(Path(args.output).suffix.lower())
    if form is None:
        raise InputError(f"{args.output}: a page is written as {' or '.join(_FORMS)}")
    layout = layout_of(args.target, paper_of(args.paper), args.step)
    # Matplotlib takes a second to import: bad options are reported before.
    from ncdc.target.draw import page
    write_bytes(args.output, page(layout, form))
    width, height = layout.paper
    report = {"page": args.output, "paper_mm": layout.paper, "target": layout.target,
              "points": layout.points, "step_mm": layout.step}
    if not write_report(report, args.json):
        print(f"{args.output}: {width:g}x{height:g} mm, {layout.description}")
        print("print it at 100 %, without fitting to the page, and measure its ruler; then\n"
              f"    ncdc calibrate PHOTO... --target {layout.target} -o points.json")
