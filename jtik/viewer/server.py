"""A server of viser on the loopback address."""

from __future__ import annotations

import logging
import socket
from contextlib import redirect_stdout
from io import StringIO
from typing import Any

from jtik.arguments import integer
from jtik.errors import ArgumentError, MissingExtraError

HOST = "127.0.0.1"
"""The loopback address: nobody else can connect."""

FIRST, LAST = 1024, 65535
"""Ports that a program may use."""


def read_port(port: Any) -> int:
    """A free port: the one given, or any for None.

    Raises:
        ArgumentError: for a number that is no port, or a port in use.
    """
    accepted = f"a free port from {FIRST} to {LAST}, or None for any"
    if port is not None:
        number = integer("port", port, minimum=FIRST, accepted=accepted)
        if number > LAST:
            raise ArgumentError("port", port, accepted)
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((HOST, 0 if port is None else number))
        except OSError as error:
            raise ArgumentError("port", f"{port}, which is in use", accepted) from error
        found: int = probe.getsockname()[1]
    return found


def start(port: Any, title: str) -> Any:
    """A ``viser.ViserServer`` with jtik's appearance.

    Args:
        port: the port, or None for any.
        title: title of its panel.

    Raises:
        ArgumentError: for a port that cannot be used.
        MissingExtraError: when viser is not installed.
    """
    try:
        import viser
    except ImportError as error:
        raise MissingExtraError("viser", "view", "jtik.view") from error
    logging.getLogger("websockets").addHandler(logging.NullHandler())  # a browser that hangs up is no news
    with redirect_stdout(StringIO()):  # it prints a banner
        server = viser.ViserServer(host=HOST, port=read_port(port), label=title, verbose=False)
    server.gui.configure_theme(
        control_width="medium", show_logo=False, show_share_button=False, brand_color=(0, 114, 178)
    )
    return server


def stop(server: Any) -> None:
    """End a server."""
    with redirect_stdout(StringIO()):
        server.stop()
