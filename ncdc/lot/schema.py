"""The tables of a lot's database."""

from sqlalchemy import (
    Column,
    DateTime,
    Float,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    String,
    Table,
    Text,
)

from ncdc.lot.figures import ERRORS, FIGURES
from ncdc.lot.identity import IDENTITY
from ncdc.lot.units import STATION_LENGTH

__all__ = ["FILES", "FACTS", "METADATA", "PHOTOS", "SCHEMA", "TRIES", "UNITS"]

SCHEMA = 2              # counts changes of these tables

METADATA = MetaData()

# What holds for the whole lot: ``schema``, and ``request``, the options as JSON.
FACTS = Table("facts", METADATA,
              Column("name", String(40), primary_key=True),
              Column("value", Text, nullable=False))

# One row per unit. ``verdict`` is NULL as long as the unit waits for its work.
UNITS = Table(
    "units", METADATA,
    Column("serial", String(32), primary_key=True),
    Column("number", Integer, nullable=False, unique=True),     # position in the lot
    Column("station", String(STATION_LENGTH), nullable=False),
    Column("photos", Text, nullable=False),                     # addresses, JSON
    Column("photo_hashes", Text),                               # SHA-256 each, JSON
    Column("verdict", String(4)),                               # pass, look, fail
    Column("cause", String(80)),                                # of fail or look, a few words
    Column("reasons", Text),                                    # sentences, JSON
    *(Column(name, String(40)) for name in IDENTITY),           # of the worker
    Column("seed", Integer),
    Column("digest", String(12)),                               # of the descriptor
    Column("worker", String(255)),                              # name of the machine
    Column("judged", DateTime),                                 # UTC
    Column("seconds", Float),
    *(Column(figure.name, Float) for figure in FIGURES),
    *(Column(name, Float) for name in ERRORS),                  # standard errors
    Index("units_by_verdict", "verdict"),
    Index("units_by_time", "judged"))

# One row per photo of a unit that was read, to find a photo that two units have.
PHOTOS = Table(
    "photos", METADATA,
    Column("hash", String(64), primary_key=True),               # SHA-256 of the file
    Column("serial", String(32), ForeignKey("units.serial"), primary_key=True))

# One row per start of the work on a unit.
TRIES = Table(
    "tries", METADATA,
    Column("serial", String(32), ForeignKey("units.serial"), primary_key=True),
    Column("number", Integer, primary_key=True),                # 1 is the first
    Column("station", String(STATION_LENGTH), nullable=False),      # where the run was started
    Column("started", DateTime, nullable=False),                # UTC
    Column("end", String(12)))      # judged, died (its worker), interrupted; NULL while it runs

# What belongs to a unit: ``net.toml`` (compressed by zlib) and ``picture.jpg``.
FILES = Table(
    "files", METADATA,
    Column("serial", String(32), ForeignKey("units.serial"), primary_key=True),
    Column("name", String(40), primary_key=True),
    Column("content", LargeBinary, nullable=False))
