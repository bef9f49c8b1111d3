"""The database of a lot: which units there are, what was found, and every try."""

import json
import sqlite3
import time
import zlib
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from functools import wraps
from itertools import islice

import numpy as np
from sqlalchemy import String, create_engine, event, func, insert, inspect, select, update
from sqlalchemy.exc import DBAPIError, IntegrityError, OperationalError, SQLAlchemyError

from ncdc.lot.figures import ERRORS, FIGURES, LOOK, PASS, VERDICTS
from ncdc.lot.schema import FACTS, FILES, METADATA, PHOTOS, SCHEMA, TRIES, UNITS
from ncdc.terminal import say
from ncdc_spec.errors import InputError

__all__ = ["DIED", "Database", "INTERRUPTED", "JUDGED", "reason_of"]

JUDGED, DIED, INTERRUPTED = "judged", "died", "interrupted"     # ends of a try

# Statement with which a transaction waits until no other one of this kind runs, by database.
_ALONE = {"sqlite": "BEGIN IMMEDIATE", "postgresql": "SELECT pg_advisory_xact_lock(1852007523)"}
_BATCH = 500            # rows that are in memory at a time
_NET, _PICTURE = "net.toml", "picture.jpg"
_RETRY = 60.0        # seconds for which a lost connection is tried again
_RACES = 3              # tries of a unit that may begin and end while one begins
_PAUSE = 1.0            # seconds between two tries


def _lasting(method):
    """A method of :class:`Database` that is called again while the connection is lost.

    A transaction whose end was not confirmed may have been done: its method says so if repeated.
    """
    @wraps(method)
    def called(self, *arguments, **named):
        end, waiting = time.monotonic() + (0 if self.lost else self.retry), False
        while True:
            try:
                result = method(self, *arguments, **named)
            except DBAPIError as error:
                if not _lost(error):
                    raise
                if time.monotonic() >= end:
                    self.lost = True        # what ends the command does not wait again
                    raise
                if not waiting:
                    say(f"the database does not answer ({reason_of(error)}): trying again for "
                        f"{self.retry:g} s")
                waiting = True
                time.sleep(_PAUSE)
            else:
                if waiting:
                    say("the database answers again")
                return result
    return called


def _lost(error):
    """Whether an error is of the connection to a server, not of what was asked."""
    state = getattr(error.orig, "sqlstate", None)       # without an answer there is none
    return error.connection_invalidated or (
        isinstance(error, OperationalError) and not isinstance(error.orig, sqlite3.Error)
        and (state is None or state.startswith(("08", "57P"))))


class Database:
    """A lot's database, at an address of SQLAlchemy, such as ``sqlite:///lot/lot.db``.

    Every method is one transaction: a process that is killed leaves none half done.

    Parameters
    ----------
    address : str or sqlalchemy.URL
    create : bool
        Make the tables if there are none.
    retry : float
        Seconds for which a connection to a server that is lost later is tried again.

    Raises
    ------
    InputError
        If there is no database of a lot, or its tables are of another version.
    """

    def __init__(self, address, create=False, retry=_RETRY):
        self.retry, self.lost = 0.0, False
        try:
            self.engine = create_engine(address, pool_pre_ping=True)
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
                             f"needed: a lot is read by the version of NCDC that began it")
        self.retry = retry

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

    @_lasting
    def fact(self, name):
        """Text of a fact about the lot; None without it."""
        with self.engine.connect() as connection:
            return connection.scalar(_fact(name))

    @_lasting
    def begin(self, options, units, station):
        """Add ``units`` that are not there yet, and end the open tries of ``station``.

        A unit of this station that waits gets the photos that it has now.

        Parameters
        ----------
        options : dict
            What is done with every unit; the same in every run of a lot.
        units : sequence of Unit
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

    @_lasting
    def add(self, units, station):
        """Add ``units`` that are not there yet; otherwise as :meth:`begin`."""
        with self._alone() as connection:
            _add(connection, units, station)

    @_lasting
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
        last = 0
        while rows := self._waiting(suspects, station, last):
            for serial, photos, last, died in rows:
                yield serial, json.loads(photos), died

    @_lasting
    def _waiting(self, suspects, station, last):
        """Rows of some units after number ``last``, for :meth:`waiting`."""
        deaths = (select(func.count()).where(TRIES.c.serial == UNITS.c.serial,
                                             TRIES.c.end == DIED).scalar_subquery())
        running = (select(TRIES.c.serial).where(TRIES.c.serial == UNITS.c.serial,
                                                TRIES.c.end.is_(None)).exists())
        with self.engine.connect() as connection:
            return connection.execute(
                select(UNITS.c.serial, UNITS.c.photos, UNITS.c.number, deaths).where(
                    UNITS.c.verdict.is_(None), UNITS.c.number > last, ~running,
                    deaths > 0 if suspects else deaths == 0,
                    station is None or UNITS.c.station == station)
                .order_by(UNITS.c.number).limit(_BATCH)).all()

    def start(self, serial, station):
        """Number of a new try of a unit, the first is 1; None if another station was faster."""
        for _ in range(_RACES):
            number = self._next(serial)
            with suppress(IntegrityError):      # another station was faster, and has ended again
                return number if self._started(serial, station, number) else None
        return None

    @_lasting
    def _next(self, serial):
        with self.engine.connect() as connection:
            return 1 + connection.scalar(select(func.count()).where(TRIES.c.serial == serial))

    @_lasting
    def _started(self, serial, station, number):
        """Whether the try of that number is this station's, and no other one is open or done."""
        with self._alone() as connection:
            taken = connection.execute(select(TRIES.c.number, TRIES.c.station).where(
                TRIES.c.serial == serial, TRIES.c.end.is_(None) | (TRIES.c.end == JUDGED))).all()
            if not taken:
                connection.execute(insert(TRIES).values(serial=serial, number=number,
                                                        station=station, started=_now()))
            # A try that is there already is that of a transaction whose end was not confirmed.
            return not taken or taken == [(number, station)]

    @_lasting
    def end(self, serial, number, end):
        """End a try as DIED or INTERRUPTED: the unit waits again."""
        with self.engine.begin() as connection:
            connection.execute(_ended(serial, number, end))

    @_lasting
    def save(self, serial, number, outcome, verdict, seed):
        """Record the :class:`ncdc.lot.work.Outcome` of a try; the units that it judges.

        What is recorded changes in one case: a photo that another unit has as well is a mix-up of
        which it is not known whose photo it is. Both units are to be looked at if they pass, and
        both say so. A second outcome of a unit is dropped.

        ``verdict``: result of :func:`ncdc.lot.figures.judge`.

        Returns
        -------
        list of (str, str, list of str, str or None)
            Serial number, verdict, reasons, and the verdict before of this unit and of those whose
            photos it has. Empty if the unit has a verdict of another try.
        """
        verdict, cause, reasons = verdict
        with self._alone() as connection:
            known = connection.execute(select(UNITS.c.verdict, TRIES.c.end).join(TRIES).where(
                UNITS.c.serial == serial, TRIES.c.number == number)).one()
            if known.verdict is not None:
                connection.execute(_ended(serial, number, JUDGED))
                # Judged by this try: a transaction whose end was not confirmed.
                mine = known.end == JUDGED
                return [(serial, known.verdict, reasons, None)] if mine else []
            others = _mixed_up(connection, serial, outcome.photo_hashes)
            if others:
                reasons = reasons + [_MIXED_UP.format(*found) for found in others]
                if verdict == PASS:
                    verdict, cause = LOOK, _MIXED_UP_CAUSE
            connection.execute(update(UNITS).where(UNITS.c.serial == serial).values(
                verdict=verdict, cause=cause, reasons=json.dumps(reasons), seed=seed,
                photo_hashes=json.dumps(outcome.photo_hashes), digest=outcome.digest or None,
                worker=outcome.worker, judged=_now(), seconds=outcome.seconds, **outcome.made_by,
                **{name: _number(outcome.figures.get(name))
                   for name in (*(figure.name for figure in FIGURES), *ERRORS)}))
            _add_files(connection, serial, outcome)
            connection.execute(_ended(serial, number, JUDGED))
            names = sorted({other for _, other, _ in others})
            return [(serial, verdict, reasons, None),
                    *(_also_mixed_up(connection, other, serial, outcome.photo_hashes)
                      for other in names)]

    @_lasting
    def counts(self):
        """Number of units by verdict, and of all as ``units``."""
        with self.engine.connect() as connection:
            found = dict(connection.execute(
                select(UNITS.c.verdict, func.count()).group_by(UNITS.c.verdict)).all())
        return {"units": sum(found.values()), **{name: found.get(name, 0) for name in VERDICTS}}

    @_lasting
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

    @_lasting
    def _file(self, serial, name):
        with self.engine.connect() as connection:
            return connection.scalar(select(FILES.c.content).where(
                FILES.c.serial == serial, FILES.c.name == name))

    def rows(self):
        """Yield the row of every judged unit as a dict, in the order of the lot."""
        last = 0
        while found := self._rows(last):
            yield from map(unpacked, found)
            last = found[-1]["number"]

    @_lasting
    def _rows(self, last):
        with self.engine.connect() as connection:
            return connection.execute(
                select(UNITS).where(UNITS.c.verdict.is_not(None), UNITS.c.number > last)
                .order_by(UNITS.c.number).limit(_BATCH)).mappings().all()

    @_lasting
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


# Of a unit and another one: name and hash of the photo, and the other unit.
_MIXED_UP = "{} is byte for byte a photo of the unit {} too (SHA-256 {}): photos are mixed up"
_MIXED_UP_CAUSE = "photo of two units"


def _mixed_up(connection, serial, hashes):
    """Record the hashes of a unit's photos; (file name, other unit, start of the hash) of each
    photo that another unit has."""
    names = json.loads(connection.scalar(select(UNITS.c.photos).where(UNITS.c.serial == serial)))
    found = []
    for digest, name in {digest: name for name, digest in zip(names, hashes)}.items():
        others = connection.scalars(select(PHOTOS.c.serial).where(
            PHOTOS.c.hash == digest, PHOTOS.c.serial != serial).order_by(PHOTOS.c.serial)).all()
        found += [(name.rpartition("/")[2], other, digest[:12]) for other in others]
        connection.execute(insert(PHOTOS).values(hash=digest, serial=serial))
    return found


def _also_mixed_up(connection, serial, other, hashes):
    """Note at a unit that was judged before that ``other`` has some of its photos; its serial
    number, verdict, reasons and verdict before."""
    row = unpacked(connection.execute(select(UNITS).where(
        UNITS.c.serial == serial)).mappings().one())
    reasons = row["reasons"] + [
        _MIXED_UP.format(name.rpartition("/")[2], other, digest[:12])
        for name, digest in zip(row["photos"], row["photo_hashes"]) if digest in hashes]
    values = {"reasons": json.dumps(reasons)}
    if row["verdict"] == PASS:
        values |= {"verdict": LOOK, "cause": _MIXED_UP_CAUSE}
    connection.execute(update(UNITS).where(UNITS.c.serial == serial).values(values))
    return serial, values.get("verdict", row["verdict"]), reasons, row["verdict"]


def _add_files(connection, serial, outcome):
    files = {_NET: zlib.compress(outcome.descriptor.encode()) if outcome.descriptor else b"",
             _PICTURE: outcome.picture}
    rows = [{"serial": serial, "name": name, "content": content}
            for name, content in files.items() if content]
    if rows:
        connection.execute(insert(FILES), rows)


def _number(value):
    """A number for the database, which has NULL for not-a-number."""
    return None if value is None or not np.isfinite(value) else float(value)


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
