"""``ncdc lot show``: what is known of one unit, and its files."""

from pathlib import Path

from ncdc.cli.common import add_json, write_report
from ncdc.cli.lot_run import database_at
from ncdc.lot.figures import FIGURES
from ncdc.lot.identity import IDENTITY
from ncdc_spec.errors import InputError
from ncdc_spec.files import write_bytes, write_text

__all__ = ["EXAMPLE", "add_arguments", "run"]

EXAMPLE = "ncdc lot show lot U0017 -o U0017"


def add_arguments(parser) -> None:
    """Declare the action's arguments on an argparse parser."""
    parser.add_argument("lot", metavar="LOT", help="folder or address of ncdc lot run -o")
    parser.add_argument("unit", metavar="UNIT", help="serial number")
    parser.add_argument("-o", "--output", metavar="FOLDER",
                        help="write the unit's net.toml and picture.jpg into this folder")
    add_json(parser)


def run(args) -> None:
    """Print the unit's row; write its files."""
    database = database_at(args.lot)
    row = database.unit(args.unit)
    files = {"net.toml": database.descriptor(args.unit), "picture.jpg": database.picture(args.unit)}
    database.close()
    written = _write(args, {name: content for name, content in files.items() if content})
    judged = row["judged"] and row["judged"].isoformat(" ", "seconds")
    if not write_report({**row, "judged": judged, "files": written}, args.json):
        _print(row, judged)
        print("\n".join(written), end="\n" if written else "")


def _write(args, files):
    """Write the files into the folder of --output; their paths."""
    if args.output is None:
        return []
    if not files:
        raise InputError(f"the unit {args.unit} has neither a descriptor nor a picture")
    paths = [Path(args.output) / name for name in files]
    for path, content in zip(paths, files.values()):
        write_text(path, content) if isinstance(content, str) else write_bytes(path, content)
    return list(map(str, paths))


def _print(row, judged):
    print(f"{row['serial']}: {row['verdict'] or 'not judged yet'}")
    for reason in row["reasons"]:
        print(f"  {reason}")
    for figure in FIGURES:
        if row[figure.name] is not None:
            print(f"{figure.title:<36} {figure.text_of(row)}")
    about = {"station": row["station"], "judged (UTC)": judged, "tries": row["tries"],
             "worker": row["worker"], **{title: row[name] for name, title in IDENTITY.items()},
             "seed": row["seed"], "descriptor": row["digest"]}
    for name, value in about.items():
        if value is not None:
            print(f"{name:<36} {value}")
    for photo, digest in zip(row["photos"], row["photo_hashes"] or [""] * len(row["photos"])):
        print(f"{photo}{f'  sha256 {digest}' if digest else ''}")
