"""The protocols as a page of the documentation: ``python -m ncdc_spec.protocols.page``."""

from importlib.resources import files

from ncdc_spec.pixel_formats import PIXEL_FORMATS
from ncdc_spec.protocols import auto_control, gvcp, gvsp, table_one, table_two
from ncdc_spec.protocols.features import FEATURES, VIEW_FEATURES
from ncdc_spec.protocols.gvcp_tables import COMMANDS, STATUSES
from ncdc_spec.sensors import mt9p031

__all__ = ["protocols_doc"]


def protocols_doc():
    """Markdown page of all that device and client agree on."""
    page = (files("ncdc_spec.protocols") / "protocols.md").read_text()
    return page.format(
        tcp_port=table_one.TCP_PORT, unknown=table_one.UNKNOWN, users=table_one.MAX_USERS,
        page=table_one.SYSTEM_PAGE, header=table_two.HEADER_BYTES, port=gvcp.PORT,
        registers=gvcp.REGISTERS_MAX,
        idle=table_one.IDLE_SECONDS,
        writable=", ".join(f"0x{one.address:02X}" for one in mt9p031.SENSOR.user_registers),
        memory=gvcp.MEMORY_BYTES_MAX,
        feature_base=gvcp.FEATURE_BASE, xml_base=gvcp.XML_BASE,
        corrector_base=gvcp.CORRECTOR_BASE, headers=gvsp.HEADERS_BYTES,
        commands=_rows((f"0x{c.code:02X}", c.address, c.data, c.text, c.answer)
                       for c in table_one.COMMANDS),
        words=_rows((f"0x{w.address:04X}", f"`{w.name}`", w.access, w.text)
                    for w in table_one.SYSTEM_WORDS),
        fields=_rows((f.name, str(f.length), f.text) for f in table_two.FIELDS),
        formats=_rows((f"0x{f.mraw:02X}", f.name, f"0x{f.pfnc:08X}", str(f.pixel_bytes), f.text)
                      for f in PIXEL_FORMATS),
        features=_rows(map(_feature, FEATURES)),
        view_features=_rows(map(_feature, VIEW_FEATURES)),
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
    table = ", ".join(f"0x{address:04X}" for address in one.table)
    if table and one.field:
        lowest, width = one.field
        table += f" bit {lowest}" if width == 1 else f" bits {lowest + width - 1}..{lowest}"
    return (f"`{one.name}`", f"0x{one.address:05X}", one.kind, access, _limits(one), one.unit,
            table, one.text)


def _limits(one):
    if one.choices:
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
