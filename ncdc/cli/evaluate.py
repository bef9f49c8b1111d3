"""``ncdc evaluate``: the error of an existing descriptor."""

import sys

from ncdc.cli.common import add_camera, add_json, write_report
from ncdc.cli.renamed import add_renamed
from ncdc.cli.train import error_table, nodes_text
from ncdc.terminal import Progress
from ncdc_model.compare import compare_with_reference
from ncdc_spec.descriptor import Descriptor

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc evaluate net.toml --reference points.json"


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("descriptor", metavar="NET", help="descriptor of ncdc train")
    spellings = parser.add_mutually_exclusive_group(required=True)
    spellings.add_argument("--reference", action="append", metavar="FILE",
                           help="points.json or points.csv of this camera, the one of training or "
                                "another, its camera file, or a map for OpenCV's remap; given "
                                "twice, for the tables of x and y in a file each")
    add_renamed(spellings, "--against", "--reference", append=True)
    add_camera(parser)
    add_json(parser)


def run(args) -> None:
    """Measure and report."""
    report = compare_with_reference(Descriptor.load(args.descriptor), args.reference, args.camera,
                                    Progress("measuring"))
    for sentence in report.get("notes", ()):
        print(sentence, file=sys.stderr)
    if write_report(report, args.json):
        return
    count = (f"{report['points']} points" if "points" in report
             else f"{report['valid_pixels']} pixels")
    print(f"{report['hidden_neurons']} hidden neurons, {nodes_text(report['nodes'])}, "
          f"measured on {report['measured_on']}: {count}")
    if "valid_pixels_differ" in report:
        print(f"{report['valid_pixels_differ']} pixels have a source in one of the two only")
    print(error_table({"": report}))
    print(f"fixed minus float: at most {report['fixed_minus_float_max_px']:.5f} px on an axis")
