"""Port lists by interface, with a comment for each port."""

__all__ = ["AGENT", "AXI_CLOCK", "AXI_LITE", "AXI_READ", "AXI_VIDEO", "AXI_WRITE", "CLOCK",
           "READ_HOST", "STREAM", "WRITE_HOST", "port_lines"]

# Purpose of each port, by interface; for a repeated interface, by its kind.
CLOCK = {"clk": "the only clock; synchronous to all ports", "rst": "synchronous, active high",
          "memory_rst": "the memory is in reset, and drops requests"}
AGENT = {
    "address": "word address, see docs/reference/registers.md",
    "read": "read strobe, held while waitrequest",
    "write": "write strobe, held while waitrequest", "writedata": "word to write",
    "readdata": "word read, valid with readdatavalid", "readdatavalid": "one clock per read",
    "waitrequest": "low in the clock that accepts an access"}
READ_HOST = {
    "address": "byte address of a burst, on a word",
    "read": "requests a burst, held in waitrequest",
    "burstcount": "words of the burst", "waitrequest": "the memory takes no command now",
    "readdata": "words in the order of the requests",
    "readdatavalid": "a word has come; it is always taken"}
WRITE_HOST = {
    "address": "byte address of a burst, on a word",
    "write": "a word of a burst, held in waitrequest",
    "burstcount": "words of the burst, constant in it",
    "writedata": "pixels in the format of OUTPUT_FORMAT",
    "byteenable": "bytes of the word that count",
    "waitrequest": "the memory takes no word now"}
STREAM = {
    "valid": "a group of pixels is there, held until ready", "ready": "it is taken in this clock",
    "data": "24 bits a pixel, red on top, leftmost lowest",
    "startofpacket": "first group of a frame", "endofpacket": "last group of a frame"}

AXI_CLOCK = {
    "aclk": "for all ports but a sensor's",
    "aresetn": "resets the core and the bus to the memory",
    "core_rst": "active high: resets only the core"}


def _burst(channel, what):
    """Comments on the channel of a burst's address."""
    texts = {"id": "always 0: answers come in order", "addr": "byte address, on a word",
             "len": "words less one; no burst crosses 4 KB", "size": "log2 of a word's bytes",
             "burst": "INCR", "lock": "none", "cache": "normal memory, not cached, not buffered",
             "prot": "data, secure, unprivileged", "qos": "none",
             "valid": f"a burst is offered, held until {channel}ready"}
    return {channel + name: text for name, text in texts.items()} | {
        f"{channel}ready": f"the memory takes the {what}"}


AXI_READ = _burst("ar", "burst") | {
    "rid": "ignored", "rdata": "words in the order of the requests",
    "rresp": "bit 1: an error, which FAULT.MEMORY shows", "rlast": "a burst's last word",
    "rvalid": "a word is there", "rready": "always high: there is space for all requested words"}
AXI_WRITE = _burst("aw", "burst's address") | {
    "wdata": "samples, or pixels in the format of OUTPUT_FORMAT",
    "wstrb": "bytes of the word that count", "wlast": "a burst's last word",
    "wvalid": "a word is offered, held until wready", "wready": "the memory takes the word",
    "bid": "ignored", "bresp": "bit 1: an error, which FAULT.MEMORY shows",
    "bvalid": "a burst is in memory; a frame is done with its last",
    "bready": "always high"}
AXI_LITE = {
    "awaddr": "byte address, see docs/reference/registers.md", "awprot": "ignored",
    "awvalid": "an address is there", "awready": "it is taken",
    "wdata": "word to write", "wstrb": "all bytes or none: others are rejected",
    "wvalid": "a word is there", "wready": "it is taken",
    "bresp": "OKAY, or SLVERR to a write of some bytes", "bvalid": "the write is over",
    "bready": "its answer is taken",
    "araddr": "byte address", "arprot": "ignored", "arvalid": "an address is there",
    "arready": "it is taken", "rdata": "word read", "rresp": "OKAY",
    "rvalid": "the word is there", "rready": "it is taken"}
AXI_VIDEO = {
    "tdata": "24 bits a pixel: red on top, blue, green; leftmost lowest",
    "tuser": "first group of a frame", "tlast": "last group of a row",
    "tvalid": "a group of pixels is there, held until tready", "tready": "it is taken"}


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
