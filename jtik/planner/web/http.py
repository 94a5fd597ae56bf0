"""HTTP of the planner's page: its files, answers, and who may ask."""

from __future__ import annotations

import http
import mimetypes
import re
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

if TYPE_CHECKING:
    from websockets.http11 import Response

PAGE = Path(__file__).with_name("page")
"""Folder of the page's files."""

LOOPBACK = ("127.0.0.1", "localhost", "::1")
"""Names that this machine has for itself. A request that names another host was led here by a foreign page."""

KINDS = {".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".svg": "image/svg+xml"}
"""Types of the page's files by their suffix."""

FILES = {f"/{path.name}": path for path in PAGE.iterdir() if path.suffix in KINDS}
"""The files that are served, by their address: no other file can be asked for."""
FILES["/"] = FILES["/index.html"]


def is_foreign(host: str, origin: str | None) -> bool:
    """Whether a request comes from a page of another server.

    Args:
        host: the name by which it calls this machine; another one was led here by its own name server.
        origin: where the page is from; None for a request that a page need not make.
    """
    own = {f"http://{host}", f"https://{host}"}
    try:
        name = urlsplit(f"//{host}").hostname
    except ValueError:  # no name at all
        return True
    return name not in LOOPBACK or (origin is not None and origin not in own)


def response(status: http.HTTPStatus, body: bytes, kind: str, **more: str) -> Response:
    """An answer.

    Args:
        status: its code.
        body: what is sent.
        kind: the type of what is sent.
        more: more headers.
    """
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    text = kind.startswith(("text/", "application/json"))
    headers = {
        "Content-Type": f"{kind}; charset=utf-8" if text else kind,
        "Content-Length": str(len(body)),
        "Cache-Control": "no-cache",
        "Connection": "close",
        "X-Content-Type-Options": "nosniff",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Content-Security-Policy": "default-src 'self'; style-src 'self' 'unsafe-inline'; "
        "frame-ancestors 'self' http://localhost:* http://127.0.0.1:*",
        **more,
    }
    return Response(status.value, status.phrase, Headers(headers), body)


def file(body: bytes, name: str, **more: str) -> Response:
    """A file to save, with more headers.

    Characters of its name that a header cannot have, or a file system should not, become underscores.
    """
    name = re.sub(r"[^A-Za-z0-9._-]", "_", name)
    kind = mimetypes.guess_type(name)[0] or "application/octet-stream"
    named = {"Content-Disposition": f'attachment; filename="{name}"'}
    return response(http.HTTPStatus.OK, body, kind, **named, **more)
