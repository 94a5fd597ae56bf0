"""What the web server answers to a request: a file of the page, or what is made on demand."""

from __future__ import annotations

import http
import json
from typing import TYPE_CHECKING
from urllib.parse import quote

from jtik.errors import JtikError
from jtik.planner.web.http import FILES, KINDS, file, response
from jtik.planner.web.planning import Planning

if TYPE_CHECKING:
    from websockets.http11 import Response

ABOUT = "Jtik-Export"
"""Header of an exported file: how its motion was timed, and what a check of it finds, as JSON in percent encoding."""

NOTES = "Jtik-Notes"
"""Header of the meshes: what could not be read, as JSON in percent encoding."""

MOST_FINDINGS = 50
"""Largest number of findings, and of notes, in such a header."""


def document(path: str, planner: Planning) -> Response:
    """A file of the page, or what is made on demand: a check, an export, the plan."""
    place = FILES.get(path)
    if place is not None:
        return response(http.HTTPStatus.OK, place.read_bytes(), KINDS[place.suffix])
    try:
        if path == "/plan.json":
            return file(planner.plan_text().encode(), "plan.json")
        if path == "/meshes":
            meshes = planner.meshes()
            notes = {NOTES: quote(json.dumps(meshes.notes[:MOST_FINDINGS]))}
            return response(http.HTTPStatus.OK, meshes.data, "application/octet-stream", **notes)
        if path.startswith("/check/"):
            found = planner.findings(planner.loop.history[path.removeprefix("/check/")])
            return response(http.HTTPStatus.OK, json.dumps(list(found)).encode(), "application/json")
        if path.startswith("/export/"):
            kind, _, name = path.removeprefix("/export/").partition("/")
            made = planner.exported(planner.loop.history[name], kind)
            about = json.dumps({"about": made.about, "findings": made.findings[:MOST_FINDINGS]})
            return file(made.body, f"{name}.{kind}", **{ABOUT: quote(about)})
    except (JtikError, OSError) as error:
        return response(http.HTTPStatus.BAD_REQUEST, f"{error}\n".encode(), "text/plain")
    return response(http.HTTPStatus.NOT_FOUND, b"There is nothing at this address.\n", "text/plain")
