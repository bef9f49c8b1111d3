"""``ncdc correct``: corrects an image with a bit-exact model of the hardware."""

import sys
from functools import cache

from ncdc.cli.colour import add_colour, colour_choice, colour_line, colour_report
from ncdc.cli.common import add_json, add_samples, raw_frame, write_report
from ncdc.terminal import Progress, percent, say
from ncdc_model.correction import MODELS, coloured, correct, default_model
from ncdc_model.images import check_suffix, write_image
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.interpolation import CRESTS
from ncdc_spec.raw_gains import NO_RAW_GAINS

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc correct net.toml frame.png -o corrected.png"


def add_arguments(parser) -> None:
    """Declare the command's arguments on an argparse parser."""
    parser.add_argument("descriptor", metavar="NET", help="descriptor of ncdc train")
    parser.add_argument("image", metavar="IMAGE",
                        help="raw Bayer frame (one channel), or a colour picture to be mosaiced")
    parser.add_argument("-o", "--output", required=True, metavar="OUT", help="corrected picture")
    parser.add_argument("--model", choices=MODELS,
                        help="compiled: C functions, which need a C compiler (default, if there is "
                             "one); reference: NumPy, which takes a hundred times as long; both "
                             "give the same bits")
    add_colour(parser.add_argument_group("colour"))
    add_samples(parser.add_argument_group("samples of the file"))
    add_json(parser)


def run(args) -> None:
    """Correct, write, report."""
    check_suffix(args.output)
    choice = colour_choice(args)
    descriptor = Descriptor.load(args.descriptor)
    raw, note = raw_frame(args.image, descriptor.geometry, args.raw, args.bits)
    model = args.model or default_model(say)

    @cache
    def corrected_with(raw_gains):
        return correct(descriptor, raw, percent(Progress("correcting")),
                       crest=CRESTS[args.crest], raw_gains=raw_gains, model=model)

    colour = choice(corrected_with) if choice else None
    corrected = corrected_with(colour.raw_gains if colour else NO_RAW_GAINS)
    write_image(args.output, coloured(corrected, colour, model) if colour else
                corrected.picture)
    if note:
        print(note, file=sys.stderr)
    report = {"hidden_neurons": descriptor.hidden_neurons, "pixels": corrected.blank.size,
              "pixels_blank": int(corrected.blank.sum()), "windows_fetched": corrected.fetches,
              "fetch": "multiport", "model": model,
              **(colour_report(args, colour) if colour else {})}
    if not write_report(report, args.json):
        share = 100 * corrected.blank.mean()
        print(f"{args.output}: {'x'.join(map(str, descriptor.geometry.corrected))} pixels, "
              f"{share:.1f} % without a source")
        if colour:
            print(colour_line(args, colour))
