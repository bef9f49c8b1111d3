"""``ncdc bench view``: views of the integer model, and a shaking camera held still."""

from ncdc.cli.common import add_json, write_report
from ncdc.terminal import Progress
from ncdc_bench.reference_lenses import REFERENCE_LENSES
from ncdc_bench.view.clocks import clocks_of
from ncdc_bench.view.measure import row_of, view_lens
from ncdc_bench.view.steadiness import steadiness, trained_lens
from ncdc_model.example import example_camera
from ncdc_spec.errors import InputError

__all__ = ["EXAMPLE", "HELP", "add_arguments", "complaints", "run", "table"]

HELP = ("compare random views of the integer model with real numbers, and measure how still a "
        "shaking camera's points stand")
EXAMPLE = "ncdc bench view --lens 105kb --views 20"

_LENSES = ("PC105", "105kb", "120br", "120dbr")
_ADDED = 0.01           # px that a view may add to the lens's own error
_STEADY = 0.3           # px rms from frame to frame
_PLANNED = 50           # views of each lens whose clocks are predicted
_OFF = 0.01             # of its clocks that a prediction may be off


def add_arguments(parser):
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("--lens", nargs="+", choices=REFERENCE_LENSES, metavar="NAME",
                        default=list(_LENSES),
                        help=f"of {', '.join(REFERENCE_LENSES)} (default: {', '.join(_LENSES)})")
    parser.add_argument("--neurons", type=int, default=12, metavar="N",
                        help="hidden neurons (default: 12)")
    parser.add_argument("--views", type=int, default=200, metavar="N",
                        help="random views of each lens (default: 200)")
    parser.add_argument("--no-simulation", action="store_true",
                        help="leave out the frames on the generated Verilog")
    parser.add_argument("--frames", type=int, default=60, metavar="N",
                        help="of the shaking camera, at 30 per second (default: 60)")
    add_json(parser)


def run(args):
    """Train, measure and report; 1 if a figure is beyond its limit."""
    for name, low in (("views", 1), ("frames", 2)):
        if getattr(args, name) < low:
            raise InputError(f"--{name} is {getattr(args, name)}, {low} is the limit")
    rows, progress, parts = [], Progress("views"), len(args.lens) + 1
    for k, lens in enumerate(args.lens):
        descriptor = view_lens(lens, args.neurons)
        rows.append(row_of(lens, descriptor, args.views,
                           lambda fraction, k=k: progress((k + fraction) / parts)))
        if not args.no_simulation:
            rows[-1] |= clocks_of(descriptor, min(args.views, _PLANNED))
    camera = example_camera()
    steady = steadiness(camera, trained_lens(camera), args.frames,
                        progress=lambda fraction: progress((parts - 1 + fraction) / parts))
    if not write_report({"rows": rows, "steadiness": steady}, args.json):
        print(table(rows, steady))
    found = complaints(rows, steady)
    for text in found:
        print(text)
    return int(bool(found))


def complaints(rows, steady):
    """A sentence for each figure that is beyond its limit."""
    found = []
    for row in rows:
        limit = row["lens_error_max_px"] + _ADDED
        if row["map_error_max_px"] > limit:
            found.append(f"{row['lens']}: the map is off by {row['map_error_max_px']:.4f} px, the "
                         f"limit is {limit:.4f}")
        found += [f"{row['lens']}: {row[name]} pixels are {text}" for name, text in (
            ("wrongly_filled", "filled without a source"),
            ("wrongly_blank", "blank with a source")) if row[name]]
        if "clocks_per_pixel" in row:
            ratio = row["predicted_clocks_per_pixel"] / row["clocks_per_pixel"]
            if abs(ratio - 1) > _OFF:
                found.append(f"{row['lens']}: {ratio:.3f} of the clocks are predicted, 1 % off is "
                             f"the limit")
            if row["random_clocks_per_pixel"] > row["bound_clocks_per_pixel"]:
                found.append(f"{row['lens']}: a random view takes "
                             f"{row['random_clocks_per_pixel']:.4f} clocks per pixel, "
                             f"{row['bound_clocks_per_pixel']:.4f} are the planner's bound")
            if row["pixels_different"]:
                found.append(f"{row['lens']}: {row['pixels_different']} pixels of the Verilog are "
                             f"not the golden model's")
    found += [f"a point moves by {steady[name]:.2f} px rms from frame to frame{how}, the limit is "
              f"{_STEADY}" for name, how in (("moved_px_rms", ""), (
                  "moved_px_rms_hardware", " with the hardware's table"))
              if steady[name] > _STEADY]
    return found


def table(rows, steady):
    """The figures as text."""
    lines = ["largest error of a source in px, pixels that are filled or blank and should not be",
             f"{'lens':<7} {'views':>5} {'view':>8} {'lens':>8} {'filled':>6} {'blank':>6} "
             f"{'clocks/pixel':>12} {'predicted':>9} {'bound':>8} {'random':>8} {'differ':>6}"]
    lines += [f"{row['lens']:<7} {row['views']:5d} {row['map_error_max_px']:8.5f} "
              f"{row['lens_error_max_px']:8.5f} {row['wrongly_filled']:6d} "
              f"{row['wrongly_blank']:6d} " + _clocks(row) for row in rows]
    return "\n".join([
        *lines, "",
        f"a camera that shakes by {steady['shake_degrees_rms']:g} degrees rms about each axis, "
        f"{steady['shake_rate_rms']:.0f} degrees/s, readout {steady['readout_ms']:g} ms, "
        f"{steady['frames']} frames",
        f"a point moves from frame to frame by {steady['moved_px_rms']:.3f} px rms; "
        f"{steady['moved_px_rms_hardware']:.3f} px with the hardware's table, "
        f"{steady['moved_px_rms_frame']:.3f} px with one matrix per frame, "
        f"{steady['moved_px_rms_without']:.1f} px without stabilisation"])


def _clocks(row):
    if "clocks_per_pixel" not in row:
        return f"{'-':>12} {'-':>9} {'-':>8} {'-':>8} {'-':>6}"
    return (f"{row['clocks_per_pixel']:12.5f} {row['predicted_clocks_per_pixel']:9.5f} "
            f"{row['bound_clocks_per_pixel']:8.5f} {row['random_clocks_per_pixel']:8.5f} "
            f"{row['pixels_different']:6d}")
