"""The network at nodes: distances that exist, and the nodes that a row needs."""

from ncdc_spec.errors import InputError

__all__ = ["GUARD_BITS", "NODES", "check_nodes", "nodes_fit", "row_nodes"]

NODES = (1, 8, 16, 32)      # distances of nodes in pixels; 1: the network at every pixel
GUARD_BITS = 4              # additional fraction bits of a node's coordinate
BEFORE, AFTER = 1, 2       # additional nodes of a row before and after those of its pixels


def row_nodes(columns, nodes):
    """Number of nodes for ``columns`` neighbouring pixels of a row, the first of them on a node."""
    return -(-columns // nodes) + BEFORE + AFTER


def nodes_fit(nodes, width):
    """Whether the nodes outside a picture ``width`` pixels wide stay within the scan's range.

    The row's last node is up to 2 S pixels right of its last pixel. The normalised coordinate
    spans +-0.9999 over width - 1 pixels, and stays below 2 there if that is at least 4 S.
    """
    return nodes == 1 or width > 4 * nodes


def check_nodes(nodes, width):
    """Raise :class:`InputError` unless there are nodes ``nodes`` pixels apart for a picture
    ``width`` pixels wide."""
    if nodes not in NODES or isinstance(nodes, bool):
        raise InputError(f"the distance of the nodes is {nodes}, one of "
                         f"{', '.join(map(str, NODES))} is needed")
    if not nodes_fit(nodes, width):
        raise InputError(f"the corrected width is {width}, nodes {nodes} pixels apart need more "
                         f"than {4 * nodes}")
