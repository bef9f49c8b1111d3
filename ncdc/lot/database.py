"""The database of a lot: which units there are, what was found, and every try."""

import json
import zlib
from contextlib import contextmanager
from datetime import UTC, datetime
from importlib.metadata import version
from itertools import islice

import numpy as np
from sqlalchemy import String, create_engine, event, func, insert, inspect, select, update
from sqlalchemy.exc import IntegrityError, SQLAlchemyError

from ncdc.lot.figures import FIGURES, VERDICTS
from ncdc.lot.schema import FACTS, FILES, METADATA, SCHEMA, TRIES, UNITS
from ncdc_spec.errors import InputError

__all__ = ["DIED", "Database", "INTERRUPTED", "JUDGED", "reason_of"]

JUDGED, DIED, INTERRUPTED = "judged", "died", "interrupted"     # ends of a try

# Statement with which a transaction waits until no other one of this kind runs, by database.
_ALONE = {"sqlite": "BEGIN IMMEDIATE", "postgresql": "SELECT pg_advisory_xact_lock(1852007523)"}
_BATCH = 500            # rows that are in memory at a time
_NET, _PICTURE = "net.toml", "picture.jpg"


class Database:
    """A lot's database, at an address of SQLAlchemy, such as ``sqlite:///lot/lot.db``.

    Every method is one transaction: a process that is killed leaves none half done.

    Parameters
    ----------
    address : str or sqlalchemy.URL
    create : bool
        Make the tables if there are none.

    Raises
    ------
    InputError
        If there is no database of a lot, or its tables are of another version.
    """

    def __init__(self, address, create=False):
        try:
            self.engine = create_engine(address)
            self.address = address = str(self.engine.url)       # without the password
            if self.engine.dialect.name == "sqlite":
                event.listen(self.engine, "connect", _patient)
            if create:
                self._create()
            elif not inspect(self.engine).has_table(FACTS.name):
                raise InputError(f"{address} is no database of a lot: ncdc lot run makes one")
            schema = self.fact("schema")
        except (SQLAlchemyError, ImportError) as error:
            raise InputError(f"cannot open the database {address}: {reason_of(error)}") from error
        if schema != str(SCHEMA):
            raise InputError(f"{address} has tables of version {schema}, version {SCHEMA} is "
                             f"needed")

    def close(self):
        """End the connections."""
        self.engine.dispose()

    @contextmanager
    def _alone(self):
        """Connection of a transaction that waits until no other one of this kind runs.

        What it reads does not change before it writes. Databases other than SQLite and PostgreSQL
        do not wait: of two stations at once, one may end with the error of its database.
        """
        with self.engine.begin() as connection:
            if wait := _ALONE.get(self.engine.dialect.name):
                connection.exec_driver_sql(wait)
            yield connection

    def _create(self):
        """Make the tables, if there are none."""
        if not inspect(self.engine).has_table(FACTS.name):
            with self._alone() as connection:
                if not inspect(connection).has_table(FACTS.name):   # another station was faster
                    METADATA.create_all(connection)
                    connection.execute(insert(FACTS).values(name="schema", value=str(SCHEMA)))

    def fact(self, name):
        """Text of a fact about the lot; None without it."""
        with self.engine.connect() as connection:
            return connection.scalar(_fact(name))

    def begin(self, options, units, station):
        """Add ``units`` that are not there yet, and end the open tries of ``station``.

        A unit of this station that waits gets the photos that it has now.

        Parameters
        ----------
        options : dict
            What is done with every unit; the same in every run of a lot.
        units : iterable of Unit
        station : str

        Raises
        ------
        InputError
            If the lot was begun with other options; the message names the first one.
        """
        text = json.dumps(options, sort_keys=True)
        with self._alone() as connection:
            begun = connection.scalar(_fact("request"))
            if begun is None:
                connection.execute(insert(FACTS).values(name="request", value=text))
            elif begun != text:
                before = json.loads(begun)
                name = next(key for key in (*options, *before)
                            if before.get(key) != options.get(key))
                raise InputError(f"the lot was begun with {name} {before.get(name)}, this run has "
                                 f"{options.get(name)}: another -o, or the same options")
            _add(connection, units, station)
            connection.execute(update(TRIES).values(end=INTERRUPTED).where(
                TRIES.c.end.is_(None), TRIES.c.station == station))

    def add(self, units, station):
        """Add ``units`` that are not there yet; otherwise as :meth:`begin`."""
        with self._alone() as connection:
            _add(connection, units, station)

    def known(self, serials):
        """Those of ``serials`` that are units of the lot, as a set."""
        found, serials = set(), iter(serials)
        with self.engine.connect() as connection:
            while some := list(islice(serials, _BATCH)):
                found |= set(connection.scalars(select(UNITS.c.serial).where(
                    UNITS.c.serial.in_(some))))
        return found

    def waiting(self, suspects, station=None):
        """Yield (serial, photos, number of deaths) of the units without a verdict, in their order.

        ``suspects``: those whose worker died, or the others. ``station``: of that station alone. A
        unit that another station works on is left to it.
        """
        deaths = (select(func.count()).where(TRIES.c.serial == UNITS.c.serial,
                                             TRIES.c.end == DIED).scalar_subquery())
        running = (select(TRIES.c.serial).where(TRIES.c.serial == UNITS.c.serial,
                                                TRIES.c.end.is_(None)).exists())
        last = 0
        while True:
            with self.engine.connect() as connection:
                rows = connection.execute(
                    select(UNITS.c.serial, UNITS.c.photos, UNITS.c.number, deaths).where(
                        UNITS.c.verdict.is_(None), UNITS.c.number > last, ~running,
                        deaths > 0 if suspects else deaths == 0,
                        station is None or UNITS.c.station == station)
                    .order_by(UNITS.c.number).limit(_BATCH)).all()
            if not rows:
                return
            for serial, photos, last, died in rows:
                yield serial, json.loads(photos), died

    def start(self, serial, station):
        """Number of a new try of a unit, the first is 1; None if another station was faster."""
        try:
            with self._alone() as connection:
                taken = connection.scalar(select(func.count()).where(
                    TRIES.c.serial == serial, TRIES.c.end.is_(None) | (TRIES.c.end == JUDGED)))
                number = 1 + connection.scalar(select(func.count()).where(
                    TRIES.c.serial == serial))
                if taken:
                    return None
                connection.execute(insert(TRIES).values(serial=serial, number=number,
                                                        station=station, started=_now()))
        except IntegrityError:
            return None
        return number

    def end(self, serial, number, end):
        """End a try as DIED or INTERRUPTED: the unit waits again."""
        with self.engine.begin() as connection:
            connection.execute(_ended(serial, number, end))

    def save(self, serial, number, outcome, verdict, seed):
        """Record the :class:`ncdc.lot.work.Outcome` of a try; whether the unit had no verdict.

        What is recorded never changes: a second outcome of a unit is dropped.

        ``verdict``: result of :func:`ncdc.lot.figures.judge`.
        """
        verdict, cause, reasons = verdict
        with self.engine.begin() as connection:
            done = connection.execute(update(UNITS).where(
                UNITS.c.serial == serial, UNITS.c.verdict.is_(None)).values(
                    verdict=verdict, cause=cause, reasons=json.dumps(reasons), seed=seed,
                    photo_hashes=json.dumps(outcome.photo_hashes), software=version("ncdc"),
                    digest=outcome.digest or None, worker=outcome.worker, judged=_now(),
                    seconds=outcome.seconds,
                    **{figure.name: outcome.figures.get(figure.name) for figure in FIGURES}))
            if done.rowcount:
                files = {_NET: zlib.compress(outcome.descriptor.encode()),
                         _PICTURE: outcome.picture}
                rows = [{"serial": serial, "name": name, "content": content}
                        for name, content in files.items()
                        if (outcome.descriptor if name == _NET else content)]
                if rows:
                    connection.execute(insert(FILES), rows)
            connection.execute(_ended(serial, number, JUDGED))
        return bool(done.rowcount)

    def counts(self):
        """Number of units by verdict, and of all as ``units``."""
        with self.engine.connect() as connection:
            found = dict(connection.execute(
                select(UNITS.c.verdict, func.count()).group_by(UNITS.c.verdict)).all())
        return {"units": sum(found.values()), **{name: found.get(name, 0) for name in VERDICTS}}

    def unit(self, serial):
        """Row of a unit as a dict, lists instead of JSON, with the number of ``tries``.

        Raises
        ------
        InputError
            If there is no such unit.
        """
        with self.engine.connect() as connection:
            row = connection.execute(select(UNITS).where(
                UNITS.c.serial == serial)).mappings().one_or_none()
            tries = connection.scalar(select(func.count()).where(TRIES.c.serial == serial))
        if row is None:
            raise InputError(f"the lot has no unit {serial}")
        return unpacked(row) | {"tries": tries}

    def descriptor(self, serial):
        """Text of a unit's descriptor; None without one."""
        content = self._file(serial, _NET)
        return None if content is None else zlib.decompress(content).decode()

    def picture(self, serial):
        """JPEG of a unit; None without one."""
        return self._file(serial, _PICTURE)

    def _file(self, serial, name):
        with self.engine.connect() as connection:
            return connection.scalar(select(FILES.c.content).where(
                FILES.c.serial == serial, FILES.c.name == name))

    def rows(self):
        """Yield the row of every judged unit as a dict, in the order of the lot."""
        last = 0
        while True:
            with self.engine.connect() as connection:
                found = connection.execute(
                    select(UNITS).where(UNITS.c.verdict.is_not(None), UNITS.c.number > last)
                    .order_by(UNITS.c.number).limit(_BATCH)).mappings().all()
            if not found:
                return
            yield from map(unpacked, found)
            last = found[-1]["number"]

    def columns(self, names):
        """Values of some columns of every judged unit, in the order of judgement, by name.

        Numbers are an array with not-a-number for NULL, of 8 bytes a unit; times are seconds since
        1970; of texts the array has the position in a list, which is the second of a pair.
        """
        wanted = [UNITS.c[name] for name in names]
        query = select(*wanted).where(UNITS.c.verdict.is_not(None)).order_by(UNITS.c.judged,
                                                                             UNITS.c.number)
        count = sum(self.counts()[verdict] for verdict in VERDICTS)
        found = {name: np.full(count, np.nan) for name in names}
        texts = {column.name: {} for column in wanted if isinstance(column.type, String)}
        with self.engine.connect().execution_options(yield_per=_BATCH) as connection:
            for k, row in zip(range(count), connection.execute(query)):
                for name, value in zip(names, row):
                    if name in texts:
                        value = texts[name].setdefault(value, len(texts[name]))
                    elif isinstance(value, datetime):
                        value = value.replace(tzinfo=UTC).timestamp()
                    if value is not None:
                        found[name][k] = value
        return found | {name: (found[name].astype(int), list(known))
                        for name, known in texts.items()}


def _fact(name):
    return select(FACTS.c.value).where(FACTS.c.name == name)


def _add(connection, units, station):
    """Add units that are not there, and renew the photos of those of ``station`` that wait."""
    number = connection.scalar(select(func.coalesce(func.max(UNITS.c.number), 0)))
    units = iter(units)
    while some := list(islice(units, _BATCH)):
        there = dict(connection.execute(select(UNITS.c.serial, UNITS.c.photos).where(
            UNITS.c.serial.in_([unit.serial for unit in some]))).all())
        for unit in some:
            if there.get(unit.serial, photos := json.dumps(unit.photos)) != photos:
                connection.execute(update(UNITS).values(photos=photos).where(
                    UNITS.c.serial == unit.serial, UNITS.c.verdict.is_(None),
                    UNITS.c.station == (unit.station or station)))
        new = [unit for unit in some if unit.serial not in there]
        rows = [{"serial": unit.serial, "number": number + k, "station": unit.station or station,
                 "photos": json.dumps(unit.photos)} for k, unit in enumerate(new, 1)]
        number += len(rows)
        if rows:
            connection.execute(insert(UNITS), rows)


def unpacked(row):
    """A row of the table of units with lists instead of JSON."""
    packed = ("photos", "photo_hashes", "reasons")
    return dict(row) | {name: json.loads(row[name] or "[]") for name in packed}


def _ended(serial, number, end):
    return update(TRIES).values(end=end).where(TRIES.c.serial == serial,
                                               TRIES.c.number == number)


def _patient(connection, _record):
    """A second process, as the report's, waits until a transaction is over."""
    connection.execute("PRAGMA busy_timeout = 30000")


def reason_of(error):
    """First line of an error of the database itself."""
    return str(getattr(error, "orig", None) or error).splitlines()[0]


def _now():
    """Time in UTC; the columns have no zone."""
    return datetime.now(UTC).replace(tzinfo=None)
