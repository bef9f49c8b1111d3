"""``ncdc export``: maps and points for other software."""

from pathlib import Path

from ncdc_model.calibration.points import TargetPoints
from ncdc_model.calibration.points_csv import STYLES, save_csv
from ncdc_model.remap_tables import SUFFIXES, remap_tables, save_tables
from ncdc_model.training.source import is_points_file
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc export net.toml -o maps.npz"


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("source", metavar="FILE",
                        help="descriptor of ncdc train, or points.json of ncdc calibrate")
    parser.add_argument("-o", "--output", required=True, metavar="OUT",
                        help=f"of a descriptor map_x, map_y and sensor "
                             f"({', '.join(SUFFIXES)}), of points a .csv")
    parser.add_argument("--style", choices=list(STYLES),
                        help="columns of the CSV: opencv: object and image points (default); "
                             "discorpy: line by line")


def run(args) -> None:
    """Convert and write."""
    if is_points_file(args.source):
        if Path(args.output).suffix.lower() != ".csv":
            raise InputError(f"{args.output}: points are written as .csv")
        points = TargetPoints.load(args.source)
        save_csv(args.output, points, args.style or "opencv")
        print(f"{args.output}: {points.whole} points")
        return
    if args.style:
        raise InputError(f"style {args.style} is for points, {args.source} holds none")
    descriptor = Descriptor.load(args.source)
    map_x, map_y = remap_tables(descriptor)
    save_tables(args.output, map_x, map_y, descriptor.geometry.distorted)
    print(f"{args.output}: map_x and map_y, {map_x.shape[1]}x{map_x.shape[0]}")
