"""The Quartus project of a board."""

__all__ = ["project_name", "top_verilog"]


def project_name(board):
    """Name of the project, of its files and of its top."""
    return "ncdc_" + board.name.replace("-", "_")


def top_verilog(design):
    """Verilog of the top and of all below it but the user's module."""
    return _prepared(design)[f"{project_name(design.board)}.v"]


def _prepared(design, **overrides):
    """Text of each file that Amaranth writes, by name."""
    board = design.board
    plan = board.platform().prepare(board.top(design), project_name(board), **overrides)
    return {name: text.decode() if isinstance(text, bytes) else text
            for name, text in plan.files.items()}
