"""The explorer's server: Python's own, on this machine's loopback only.

What comes in is not trusted: only known names are served, a request must come from the page itself (Host, Origin and a
token that only the page's address holds), be JSON and be short. Nothing from the browser names a file.
"""

from __future__ import annotations

import json
import secrets
import threading
from collections import OrderedDict
from collections.abc import Callable
from hmac import compare_digest
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib import resources
from typing import Any

from cyclemap.errors import CycleMapError, InvalidInput

Answer = dict[str, object]
# From the JSON of a request to that of the reply; what it calls now and then ends it once it is overtaken.
Work = Callable[[Answer, Callable[[float], None]], Answer]

LONGEST_BODY = 65_536
_PATIENCE_SECONDS = 30.0
_MOST_PAGES = 64
_TYPES = {"html": "text/html", "css": "text/css", "js": "text/javascript", "svg": "image/svg+xml"}
_FILES = ("page.html", "page.css", "explore.js", "drawing.js", "uplot/uPlot.iife.min.js", "uplot/uPlot.min.css")
_HEADERS = {
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
        "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
}


class ExplorerServer(ThreadingHTTPServer):
    """Serves the page, and answers its requests by name.

    One answer is worked out at a time; one that a later request of the same page overtakes is given up.
    """

    daemon_threads = True
    allow_reuse_address = False

    def __init__(self, answers: dict[str, Work]) -> None:
        """Bind to a free port of the loopback."""
        self.answers, self.token = answers, secrets.token_urlsafe(24)
        here = resources.files("cyclemap.views.explorer")
        self.files = {
            f"/{name}": (_TYPES[name.rpartition(".")[2]], here.joinpath(name).read_bytes()) for name in _FILES
        }
        self.files["/"] = self.files["/page.html"]
        self.working, self.newest = threading.Lock(), OrderedDict[str, int]()
        super().__init__(("127.0.0.1", 0), _Request)

    @property
    def origin(self) -> str:
        """The page's origin."""
        return f"http://127.0.0.1:{self.server_address[1]}"

    @property
    def address(self) -> str:
        """What the browser opens: the token is in the fragment, which no request sends."""
        return f"{self.origin}/#token={self.token}"

    def handle_error(self, request: object, client_address: object) -> None:
        """A browser that goes away in the middle is no fault."""

    def answer(self, name: str, asked: Answer) -> Answer:
        """Work out one answer; `stale` where a later request of the same page waits behind it."""
        page, number = str(asked.pop("page", "")), asked.pop("number", 0)
        if len(page) > 64 or isinstance(number, bool) or not isinstance(number, int):
            raise InvalidInput("page must be a short text and number a whole number")
        self.newest[page] = max(number, self.newest.get(page, number))
        self.newest.move_to_end(page)
        while len(self.newest) > _MOST_PAGES:
            self.newest.popitem(last=False)

        def check(_: float = 0.0) -> None:
            if number < self.newest.get(page, number):
                raise _OvertakenError

        try:
            with self.working:
                check()
                return self.answers[name](asked, check)
        except _OvertakenError:
            return {"stale": True}


class _OvertakenError(Exception):
    """A later request of the same page waits."""


class _Request(BaseHTTPRequestHandler):
    server: ExplorerServer
    protocol_version = "HTTP/1.1"
    timeout = _PATIENCE_SECONDS
    # Head and body are two writes: the second would wait 40 ms for the browser to acknowledge the first.
    disable_nagle_algorithm = True
    server_version, sys_version = "cyclemap", ""

    def do_GET(self) -> None:
        if self.headers.get_all("Host") != [self.server.origin.removeprefix("http://")]:
            self._send(HTTPStatus.FORBIDDEN, "text/plain", b"this host is not served")
        elif (found := self.server.files.get(self.path)) is None:
            self._send(HTTPStatus.NOT_FOUND, "text/plain", b"there is no such page")
        else:
            self._send(HTTPStatus.OK, *found)

    def do_POST(self) -> None:
        refused = self._refusal()
        if refused is not None:
            # The body is not read: the connection cannot go on.
            self.close_connection = True
            self._send(refused[0], "text/plain", refused[1].encode())
            return
        try:
            asked = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
            if not isinstance(asked, dict):
                raise InvalidInput("a request is a JSON object")
            told = self.server.answer(self.path.removeprefix("/api/"), asked)
        except (ValueError, RecursionError, CycleMapError) as error:
            told = {"refused": str(error)}
        self._send(HTTPStatus.OK, "application/json", json.dumps(told, allow_nan=False).encode())

    def _refusal(self) -> tuple[HTTPStatus, str] | None:
        """Why a request is not taken: not from the page, not for it, not JSON, or too long."""
        one = {name: self.headers.get_all(name, []) for name in ("Host", "Origin", "X-Token", "Content-Length")}
        if one["Host"] != [self.server.origin.removeprefix("http://")] or one["Origin"] != [self.server.origin]:
            return HTTPStatus.FORBIDDEN, "requests come from the page itself"
        if len(one["X-Token"]) != 1 or not compare_digest(one["X-Token"][0].encode(), self.server.token.encode()):
            return HTTPStatus.FORBIDDEN, "open the address that cyclemap printed"
        if self.path.removeprefix("/api/") not in self.server.answers or not self.path.startswith("/api/"):
            return HTTPStatus.NOT_FOUND, "there is no such request"
        if self.headers.get_content_type() != "application/json":
            return HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "requests are JSON"
        length = one["Content-Length"]
        if len(length) != 1 or not length[0].isascii() or not length[0].isdigit():
            return HTTPStatus.LENGTH_REQUIRED, "a request tells its length"
        if len(length[0]) > 9 or int(length[0]) > LONGEST_BODY:
            return HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"a request has at most {LONGEST_BODY} bytes"
        return None

    def _send(self, status: HTTPStatus, kind: str, body: bytes) -> None:
        self.send_response(status)
        for name, value in {**_HEADERS, "Content-Type": f"{kind}; charset=utf-8"}.items():
            self.send_header(name, value)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *arguments: Any) -> None:
        """Say nothing: the terminal is the user's."""
