"""The rows of a lot as a Parquet file, for other software."""

from itertools import islice

import pyarrow as pa
from pyarrow import parquet
from sqlalchemy import DateTime, Float, Integer

from ncdc.lot.schema import UNITS
from ncdc_spec.files import replace_file

__all__ = ["write_parquet"]

_GROUP = 5000           # rows that are in memory at a time
_LISTS = "photos", "photo_hashes", "reasons"


def write_parquet(path, rows):
    """Write ``rows``, dicts of :meth:`ncdc.lot.database.Database.rows`, to the file ``path``."""
    schema = pa.schema([(column.name, _type(column)) for column in UNITS.columns])
    rows = iter(rows)
    with replace_file(path) as temporary, parquet.ParquetWriter(temporary, schema) as writer:
        while some := list(islice(rows, _GROUP)):
            writer.write_table(pa.Table.from_pylist(some, schema))


def _type(column):
    if column.name in _LISTS:
        return pa.list_(pa.string())
    kinds = {Float: pa.float64(), Integer: pa.int64(), DateTime: pa.timestamp("us")}
    return kinds.get(type(column.type), pa.string())
