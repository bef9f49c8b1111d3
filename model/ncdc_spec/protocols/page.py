"""The protocols as a page of the documentation: ``python -m ncdc_spec.protocols.page``."""

from importlib.resources import files

from ncdc_spec.pixel_formats import PIXEL_FORMATS
from ncdc_spec.protocols import auto_control, gvcp, gvsp, table_one, table_two
from ncdc_spec.protocols.features import FEATURES, VIEW_FEATURES, VIEWS_FEATURES, features_of
from ncdc_spec.protocols.gvcp_tables import COMMANDS, STATUSES
from ncdc_spec.sensors.catalogue import SENSORS

__all__ = ["protocols_doc"]

_SENSORS = [one for one in SENSORS if one.controls]


def protocols_doc():
    """Markdown page of all that device and client agree on."""
    page = (files("ncdc_spec.protocols") / "protocols.md").read_text()
    return page.format(
        tcp_port=table_one.TCP_PORT, unknown=table_one.UNKNOWN, users=table_one.MAX_USERS,
        page=table_one.SYSTEM_PAGE, header=table_two.HEADER_BYTES, port=gvcp.PORT,
        registers=gvcp.REGISTERS_MAX, heartbeat=gvcp.HEARTBEAT_MS,
        idle=table_one.IDLE_SECONDS,
        sensors=_rows(_sensors()), names=" | ".join(one.name for one in _SENSORS),
        lines="|---" * (1 + len(_SENSORS)),
        memory=gvcp.MEMORY_BYTES_MAX,
        feature_base=gvcp.FEATURE_BASE, xml_base=gvcp.XML_BASE,
        corrector_base=gvcp.CORRECTOR_BASE, headers=gvsp.HEADERS_BYTES, stored=gvsp.STORED_BLOCKS,
        commands=_rows((f"0x{c.code:02X}", c.address, c.data, c.text, c.answer)
                       for c in table_one.COMMANDS),
        words=_rows((f"0x{w.address:04X}", f"`{w.name}`", w.access, w.text)
                    for w in table_one.SYSTEM_WORDS),
        fields=_rows((f.name, str(f.length), f.text) for f in table_two.FIELDS),
        formats=_rows((f"0x{f.mraw:02X}", f.name, f"0x{f.pfnc:08X}", str(f.pixel_bytes), f.text)
                      for f in PIXEL_FORMATS),
        features=_rows(map(_feature, FEATURES)),
        view_features=_rows(map(_feature, (*VIEW_FEATURES, *VIEWS_FEATURES))),
        samples=auto_control.SAMPLES, target=auto_control.TARGET // 16,
        band=f"{auto_control.BAND / 16:g}", step=auto_control.STEP_FACTOR,
        balance=auto_control.BALANCE_BAND, dark=auto_control.BALANCE_DARK,
        messages=_rows((f"`{m.name}`", f"0x{m.code:04X}", _fields(m.request),
                        "none; the packets" if m.answer is None else _fields(m.answer))
                       for m in COMMANDS),
        statuses=_rows((f"0x{s.code:04X}", f"`{s.name}`", s.text) for s in STATUSES),
        gvsp_header=_layout(gvsp.HEADER_FIELDS), gvsp_leader=_layout(gvsp.LEADER_FIELDS, 8),
        gvsp_trailer=_layout(gvsp.TRAILER_FIELDS, 8), pending=gvcp.PENDING_ACK,
        bootstrap=_rows((f"0x{p.address:04X}", f"`{p.name}`", str(p.length), p.access, p.text)
                        for p in gvcp.BOOTSTRAP))


def _rows(rows):
    return "".join(f"| {' | '.join(row)} |\n" for row in rows)


def _fields(fields):
    """The fields of a payload in one cell."""
    return ", ".join(f"{size} bytes: {text}" if size else text for size, text in fields) or "empty"


def _layout(fields, at=0):
    """A row for each field of a packet; the first one is at byte ``at``."""
    rows = []
    for size, text in fields:
        rows.append((str(at), str(size), text))
        at += size
    return _rows(rows)


def _feature(one):
    access = f"{one.access}, locked" if one.locked else one.access
    if one.locked_by:
        access += f", locked by `{one.locked_by}`"
    return (f"`{one.name}`", f"0x{one.address:05X}", one.kind, access, _limits(one), one.unit,
            _words_of(one, 16), one.text)


def _words_of(one, bits):
    """Words of ``bits`` that hold a feature, with the bits in them if it is not the whole word."""
    found = []
    for part in one.parts:
        text, last = f"0x{part.address:04X}", part.shift + part.width - 1
        if part.width < bits:
            text += f" bit {last}" if part.width == 1 else f" bits {last}..{part.shift}"
        found.append(text)
    return ", ".join(found)


def _sensors():
    """A row for each feature that is in registers of the sensor, with a cell for each sensor, and
    one of all registers that users write."""
    features = [features_of(sensor) for sensor in _SENSORS]
    rows = [(f"`{same[0].name}`", *(
        f"{_limits(one) or 'off, on'}: {_words_of(one, sensor.value_bits)}"
        for sensor, one in zip(_SENSORS, same)))
        for same in zip(*features) if len(set(same)) > 1]
    return [*rows, ("registers that any user writes", *(
        ", ".join(f"0x{one.address:0{sensor.pointer_bits // 4}X}" for one in sensor.user_registers)
        for sensor in _SENSORS))]


def _limits(one):
    if one.kind == "enumeration":
        return ", ".join(choice.name for choice in one.choices)
    if one.kind not in ("integer", "float") or one.access != "rw":
        return ""
    high = f"{one.high}"
    if one.high_from:
        high = " - ".join(one.high_from)
    if one.kind == "float":
        scale = one.scale[0] / one.scale[1]
        unit = f" x {one.scale_from}" if one.scale_from else ""
        return f"{one.low * scale:g} to {one.high * scale:g}, step {scale:g}{unit}"
    return f"{one.low} to {high}" + (f", step {one.step}" if one.step > 1 else "")


if __name__ == "__main__":
    print(protocols_doc(), end="")
