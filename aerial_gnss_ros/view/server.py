# Copyright 2026 aerial_gnss_ros developers
# SPDX-License-Identifier: Apache-2.0
"""An HTTP server with WebSockets for the package's own pages; the caller registers the routes.

    run(application("view.html", [(r"/socket", MySocket, {"source": source})]), "127.0.0.1", 8060)

Pages load nothing from elsewhere: a Content-Security-Policy forbids it. Requests for another host
name are refused, so that a page of another site cannot read ours through its own name.
"""

from __future__ import annotations

import asyncio
import errno
import ipaddress
import json
import signal
import socket
from collections.abc import Callable, Coroutine, Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any, Protocol

import tornado.httpserver
import tornado.ioloop
import tornado.netutil
import tornado.web
import tornado.websocket

from aerial_gnss_ros.core.values.errors import InputError

STATIC = Path(__file__).resolve().parent / "static"
LOCAL = "127.0.0.1"
PORT = 8060
_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_LONGEST_MESSAGE = 1_000_000  # bytes of one message from a browser
_PING_S = 10.0  # a browser that left without a word is noticed after two of these

Route = tuple[str, type[tornado.web.RequestHandler], dict[str, Any]]


class _Handler(Protocol):
    """The attributes used of a tornado handler."""

    request: Any

    def set_header(self, name: str, value: str) -> None: ...


def application(page: str, routes: Sequence[Route], static: Path = STATIC) -> Any:
    """Return a tornado application.

    Args:
        page: name of the HTML file in `static` that is served at `/`.
        routes: further ones: (pattern, handler class, its arguments); use `Answer` and `Socket`.
        static: folder of the files served below `/static/`.
    """
    return tornado.web.Application(
        [
            *routes,
            (r"/()", _File, {"path": str(static), "default_filename": page}),
            (r"/static/(.*)", _File, {"path": str(static)}),
        ],
        websocket_ping_interval=_PING_S,
        websocket_max_message_size=_LONGEST_MESSAGE,
        log_function=lambda _handler: None,
    )


def run(
    app: Any,
    bind: str,
    port: int,
    began: Callable[[str], None] = lambda _url: None,
    tick: tuple[float, Callable[[], None]] | None = None,
) -> None:
    """Serve until SIGINT or SIGTERM.

    Args:
        app: of `application`.
        bind: address to listen on; 127.0.0.1 serves this computer only.
        port: TCP port; 0 takes a free one.
        began: called with the page's address once the server listens.
        tick: an interval in s, and what is called as often.

    Raises:
        InputError: the port is in use, or the address is not this computer's.
    """
    asyncio.run(_until_signal(app, bind, port, began, tick))


async def _until_signal(
    app: Any,
    bind: str,
    port: int,
    began: Callable[[str], None],
    tick: tuple[float, Callable[[], None]] | None,
) -> None:
    ended = asyncio.Event()
    loop = asyncio.get_running_loop()
    for number in _SIGNALS:
        loop.add_signal_handler(number, ended.set)
    server, address = listen(app, bind, port)
    ticking = None if tick is None else tornado.ioloop.PeriodicCallback(tick[1], tick[0] * 1e3)
    try:
        if ticking is not None:
            ticking.start()
        began(address)
        await ended.wait()
    finally:
        if ticking is not None:
            ticking.stop()
        server.stop()
        await server.close_all_connections()
        for number in _SIGNALS:
            loop.remove_signal_handler(number)


def listen(app: Any, bind: str, port: int) -> tuple[Any, str]:
    """Start a server in the running event loop; return it and the page's address.

    Raises:
        InputError: the port is in use, or the address is not this computer's.
    """
    try:
        sockets = tornado.netutil.bind_sockets(port, bind)
    except OSError as error:
        raise InputError(_why_not(error, bind, port)) from error
    server = tornado.httpserver.HTTPServer(app)
    server.add_sockets(sockets)
    return server, f"http://{_url_host(bind)}:{sockets[0].getsockname()[1]}/"


def begin(work: Coroutine[Any, Any, None]) -> Any:
    """Begin a coroutine beside the present one; keep what is returned, and ask it for `done()`."""
    return asyncio.ensure_future(work)


async def result_of(future: Future[Any]) -> Any:
    """Return what a thread gives, without holding up others."""
    return await asyncio.wrap_future(future)


def is_local(bind: str) -> bool:
    """Return whether an address serves this computer only."""
    try:
        return bind == "localhost" or ipaddress.ip_address(bind).is_loopback
    except ValueError:
        return False


def _why_not(error: OSError, bind: str, port: int) -> str:
    if error.errno == errno.EADDRINUSE:
        return f"port {port} of {bind} is in use; choose another one with --port."
    if error.errno == errno.EACCES:
        return f"port {port} needs root's rights; choose one above 1023 with --port."
    return (
        f"{bind} is no address of this computer ({error.strerror or error}); --bind takes one of "
        "its own, or 0.0.0.0 for all."
    )


def _url_host(bind: str) -> str:
    """Return the host of an address to print: where all are served, this computer's name."""
    if bind in ("", "0.0.0.0", "::"):  # noqa: S104 - compared, not bound
        return socket.gethostname()
    return f"[{bind}]" if ":" in bind else bind


def _own_name(host: str) -> bool:
    """Return whether a request's host is this computer's: an address, or its own name."""
    name = host.rpartition(":")[0] if host.rpartition(":")[2].isdecimal() else host
    name = name.strip("[]").lower()
    own = socket.gethostname().lower()
    if name in ("localhost", own, f"{own.partition('.')[0]}.local"):
        return True
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _guard(handler: _Handler) -> None:
    """Set the headers of every answer, and refuse requests for another host name."""
    host = handler.request.host
    if not _own_name(host):
        raise tornado.web.HTTPError(403, reason="Not the name of this computer")
    handler.set_header(
        "Content-Security-Policy",
        f"default-src 'self'; img-src 'self' blob: data:; connect-src 'self' ws://{host}",
    )
    handler.set_header("X-Content-Type-Options", "nosniff")
    handler.set_header("Referrer-Policy", "no-referrer")


class _File(tornado.web.StaticFileHandler):
    def prepare(self) -> None:
        _guard(self)
        if any("\0" in part for part in self.path_args):  # no name of a file
            raise tornado.web.HTTPError(404)

    def set_extra_headers(self, path: str) -> None:  # noqa: ARG002 - tornado's signature
        self.set_header("Cache-Control", "no-cache")  # after an update the new page comes


class Answer(tornado.web.RequestHandler):
    """Base of handlers that answer single requests; override `get` or `post`."""

    def prepare(self) -> None:
        """Check the request's host, and set the headers."""
        _guard(self)


class Socket(tornado.websocket.WebSocketHandler):
    """Base of a browser's connection: override `opened`, `received` and `closed`.

    Only pages of this server may connect (tornado compares Origin with Host).
    """

    def prepare(self) -> None:
        """Check the request's host, and set the headers."""
        _guard(self)

    def opened(self) -> None:
        """Called once the browser is connected."""

    def received(self, fields: dict[str, Any]) -> None:
        """Called with each message of the browser, a JSON object."""

    def closed(self) -> None:
        """Called when the browser has left, however it did."""

    def send(self, message: dict[str, Any] | str | bytes) -> bool:
        """Send a JSON object, a JSON text or bytes; return False if the browser has left."""
        whole = json.dumps(message) if isinstance(message, dict) else message
        try:
            sent = self.write_message(whole, binary=isinstance(whole, bytes))
        except tornado.websocket.WebSocketClosedError:
            return False
        self._sending = asyncio.ensure_future(sent)
        # A browser that leaves while we write is no error; it must be looked at all the same.
        self._sending.add_done_callback(lambda done: done.cancelled() or done.exception())
        return True

    @property
    def busy(self) -> bool:
        """Whether the browser has not yet received what was sent last: then skip what is next."""
        return self._sending is not None and not self._sending.done()

    _sending: asyncio.Future[None] | None = None

    def open(self, *_args: str, **_kwargs: str) -> None:
        """Tornado's name of `opened`."""
        self.set_nodelay(True)
        self.opened()

    def on_message(self, message: str | bytes) -> None:
        """Pass on what is a JSON object; anything else is not of our page and is ignored."""
        try:
            fields = json.loads(message)
        except (ValueError, RecursionError):
            return
        if isinstance(fields, dict):
            self.received(fields)

    def on_close(self) -> None:
        """Tornado's name of `closed`."""
        self.closed()
