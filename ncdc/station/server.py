"""Serves the page of a station, in a thread of its own."""

import asyncio
import socket
import threading
from functools import cache
from importlib import resources

import jinja2
from sqlalchemy.exc import SQLAlchemyError
from tornado.httpserver import HTTPServer
from tornado.netutil import bind_sockets
from tornado.web import Application, RequestHandler

from ncdc.lot.database import reason_of
from ncdc.station.state import READY, state_of
from ncdc_spec.errors import InputError

__all__ = ["StationPage"]

_ANY = "0.0.0.0", "::"      # all addresses of this machine
_FILES = {"station.css": "text/css", "station.js": "text/javascript"}
_HEADERS = {
    # Whatever a name holds, the browser runs nothing but our own file.
    "Content-Security-Policy": "default-src 'none'; connect-src 'self'; img-src 'self'; "
                               "script-src 'self'; style-src 'self'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-cache"}        # another lot has the same addresses


class StationPage:
    """The page of a station; the address is taken at once, and answers between start and close.

    Parameters
    ----------
    host : str
        Name or address of this machine.
    port : int
        0: any that is free.

    Attributes
    ----------
    url : str

    Raises
    ------
    InputError
        If the address cannot be taken.
    """

    def __init__(self, host, port):
        try:
            self._sockets = bind_sockets(port, host)
        except OSError as error:
            raise InputError(f"cannot listen on {host}, port {port}: {error.strerror}") from error
        name = socket.gethostname() if host in ("", *_ANY) else host
        name = f"[{name}]" if ":" in name else name
        self.url = f"http://{name}:{self._sockets[0].getsockname()[1]}/"
        self._thread = None

    def start(self, title, database, station, arrivals):
        """Serve the ``station`` of a ``database``, and what its ``arrivals`` wait for."""
        def shown():
            return {"title": title, "station": station, "READY": READY,
                    "waiting": arrivals.waiting, "problems": arrivals.problems,
                    **state_of(database, station)}
        routes = [(r"/(state|)", _State, {"shown": shown}),
                  (r"/picture/([^/]+)", _Picture, {"database": database}),
                  (rf"/({'|'.join(_FILES)})", _File)]
        application = Application(routes, log_function=lambda handler: None)
        started = threading.Event()
        self._thread = threading.Thread(target=asyncio.run, daemon=True, args=[
            self._serve(application, started)])
        self._thread.start()
        started.wait()

    async def _serve(self, application, started):
        server = HTTPServer(application)
        server.add_sockets(self._sockets)
        self._loop, self._end = asyncio.get_running_loop(), asyncio.Event()
        started.set()
        await self._end.wait()
        server.stop()
        await server.close_all_connections()

    def close(self):
        """Give the address back."""
        if self._thread is None:
            for one in self._sockets:
                one.close()
            return
        self._loop.call_soon_threadsafe(self._end.set)
        self._thread.join()


class _Handler(RequestHandler):
    def set_default_headers(self):
        for name, value in _HEADERS.items():
            self.set_header(name, value)

    def log_exception(self, kind, error, trace):
        if not isinstance(error, SQLAlchemyError):      # that is the answer
            super().log_exception(kind, error, trace)

    def write_error(self, status_code, exc_info=(None, None, None), **_):
        error = exc_info[1]
        text = (f"the database failed: {reason_of(error)}" if isinstance(error, SQLAlchemyError)
                else self._reason)
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(f"{status_code} {text}\n")


class _State(_Handler):
    """The page, and its part that changes."""

    def initialize(self, shown):
        self._shown = shown

    def get(self, part):
        text = _template(f"{part or 'page'}.html.jinja").render(self._shown())
        self.finish(text.encode(errors="replace"))      # names of files may be no UTF-8


class _Picture(_Handler):
    """JPEG of a unit."""

    def initialize(self, database):
        self._database = database

    def get(self, serial):
        content = self._database.picture(serial)
        if content is None:
            self.send_error(404)
            return
        self.set_header("Content-Type", "image/jpeg")
        self.finish(content)


class _File(_Handler):
    def get(self, name):
        self.set_header("Content-Type", f"{_FILES[name]}; charset=utf-8")
        self.finish((resources.files("ncdc.station") / name).read_bytes())


@cache
def _template(name):
    environment = jinja2.Environment(loader=jinja2.PackageLoader("ncdc.station", "."),
                                     autoescape=True, undefined=jinja2.StrictUndefined,
                                     trim_blocks=True, lstrip_blocks=True)
    return environment.get_template(name)
