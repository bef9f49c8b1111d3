"""Port lists by interface, with a comment for each port."""

__all__ = ["AGENT", "CLOCK", "READ_HOST", "STREAM", "WRITE_HOST", "port_lines"]

# What each port is for, by interface; of one that comes several times, by the interface's kind.
CLOCK = {"clk": "the only clock; all ports belong to it", "rst": "synchronous, active high",
          "memory_rst": "the memory forgets what it owes"}
AGENT = {
    "address": "word address, see docs/registers.md",
    "read": "read strobe, held while waitrequest",
    "write": "write strobe, held while waitrequest", "writedata": "word to write",
    "readdata": "word read, valid with readdatavalid", "readdatavalid": "one clock per read",
    "waitrequest": "low in the clock that accepts an access"}
READ_HOST = {
    "address": "byte address of a burst, on a word",
    "read": "asks for a burst, held in waitrequest",
    "burstcount": "words of the burst", "waitrequest": "the memory takes no command now",
    "readdata": "words in the order asked for",
    "readdatavalid": "a word has come; it is not refused"}
WRITE_HOST = {
    "address": "byte address of a burst, on a word",
    "write": "a word of a burst, held in waitrequest",
    "burstcount": "words of the burst, constant in it",
    "writedata": "pixels as OUTPUT_FORMAT has them",
    "byteenable": "bytes of the word that count",
    "waitrequest": "the memory takes no word now"}
STREAM = {
    "valid": "a group of pixels is there, held until ready", "ready": "it is taken in this clock",
    "data": "24 bits a pixel, red on top, leftmost lowest",
    "startofpacket": "first group of a frame", "endofpacket": "last group of a frame"}


def port_lines(head, ports, interfaces):
    """The port list of a module by interface, with a comment for each port.

    Parameters
    ----------
    head : str
    ports : sequence of (name, wire, kind, initial)
    interfaces : sequence of (title, names or prefix, comment by name)

    Raises
    ------
    ValueError
        If a port belongs to no interface.
    """
    left = {name: port for name, *port in ports}
    groups = []
    for title, which, texts in interfaces:
        prefix = which if isinstance(which, str) else ""
        names = ([prefix + name for name in texts] if prefix else list(which))
        found = [(name, *left.pop(name), texts[name.removeprefix(prefix)])
                 for name in names if name in left]
        if found:
            groups.append((title, found))
    if left:
        raise ValueError(f"the ports {', '.join(left)} belong to no interface")
    last = groups[-1][1][-1][0]
    lines = [f"module {head} ("]
    for title, found in groups:
        lines.append(f"  // {title}")
        for name, wire, kind, initial, text in found:
            width = f"[{wire.width - 1}:0]" if wire.width > 1 else ""
            end = "" if name == last else ","
            port = f"  {wire.port:<6} {kind:<4} {width:>7} {name}{initial}{end}"
            lines.append(f"{port:<48} // {text}")
    return [*lines, ");"]
