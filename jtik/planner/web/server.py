"""The planner's web server: the files of the page, and the socket that carries edits, frames and texts."""

from __future__ import annotations

import asyncio
import contextlib
import http
import json
import logging
import os
import socket
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from types import TracebackType
from typing import TYPE_CHECKING, Any, TypeVar
from urllib.parse import unquote

from jtik.arguments import integer
from jtik.errors import ArgumentError, JtikError, MissingExtraError
from jtik.planner.attempts.rows import AttemptRows, Row
from jtik.planner.edits import messages as edits
from jtik.planner.web.documents import document
from jtik.planner.web.http import is_foreign, response
from jtik.planner.web.outgoing import Outgoing
from jtik.planner.web.planning import Planning

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

T = TypeVar("T")

PORT = 8731
"""Port when none is given."""

HOST = "127.0.0.1"
"""Address that the server listens on: no other machine reaches it."""

TABULATE = 0.1
"""Period in which the table of attempts is brought up to date [s]."""

OPENING = 600
"""Longest time until a request is answered [s]: an animation takes long to draw."""

MAX_MESSAGE = 64 * 2**20
"""Largest message of a page [bytes]: a whole plan."""

WORKERS = 4
"""Number of threads that answer requests."""

STEERING = ("move_target", "hold_target", "jog")
"""Edits that keep the arm in motion after they were sent."""


class PortInUseError(JtikError):
    """The port cannot be opened: another program uses it."""


def check_port(port: object) -> int:
    """The number of a port that is free.

    Raises:
        ArgumentError: when it is no number of a port.
        PortInUseError: when it is taken.
    """
    number = _port(port)
    with socket.socket() as trial:
        if os.name == "posix":  # a port whose last connections are still closing is free
            trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            trial.bind((HOST, number))
        except OSError as error:
            raise _in_use(number) from error
    return number


def _port(port: object) -> int:
    accepted = "a number from 0 to 65535"
    number = integer("port", port, accepted=accepted)
    if number > 65535:
        raise ArgumentError("port", port, accepted)
    return number


def _in_use(port: int) -> PortInUseError:
    return PortInUseError(f"port {port} cannot be opened; accepted: a free one, by --port (0: any)")


class Server:
    """Serves the page of a planner on the loopback address.

    Args:
        planner: the planner.
        port: port to listen on; 0 for any free one.

    Attributes:
        port: the port, once it listens.

    Raises:
        MissingExtraError: when websockets is not installed.
        PortInUseError: when the port is taken, by `start` and `run`.
    """

    def __init__(self, planner: Planning, *, port: int = PORT) -> None:
        try:
            import websockets  # noqa: F401
        except ImportError as error:
            raise MissingExtraError("websockets", "planner", "the planner's page") from error
        self._planner = planner
        self.port = _port(port)
        self._steering: object = None
        self._table = AttemptRows(planner.arm, planner.measures)
        self._rows: tuple[Row, ...] = ()
        self._news: set[asyncio.Event] = set()
        self._thread: threading.Thread | None = None
        self._ends: Callable[[], None] = lambda: None
        # of its own: the end of an event loop waits for the threads of its executor, and a film takes a minute
        self._workers = ThreadPoolExecutor(WORKERS, "jtik planner page")

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://{HOST}:{self.port}/"

    async def serve(self, ready: Callable[[], None] = lambda: None) -> None:
        """Serve until the task is cancelled; ``ready`` is called once the port is open."""
        from websockets.asyncio.server import serve

        quiet = logging.getLogger("jtik.planner.web.server")
        quiet.addHandler(logging.NullHandler())
        quiet.propagate = False  # connections that a browser opens ahead and drops are no errors
        try:
            server = await serve(
                self._talk,
                HOST,
                self.port,
                process_request=self._answer,
                max_size=MAX_MESSAGE,
                compression=None,  # on the loopback address it only costs time
                logger=quiet,
                open_timeout=OPENING,
                close_timeout=1,
            )
        except OSError as error:
            raise _in_use(self.port) from error
        here = asyncio.get_running_loop()

        def published() -> None:
            with contextlib.suppress(RuntimeError):  # it has ended
                here.call_soon_threadsafe(self._wake)

        ignore = self._planner.loop.listen(published)
        try:
            async with server:
                self.port = next(iter(server.sockets)).getsockname()[1]
                ready()
                await self._tabulate()
        finally:
            ignore()
            self._workers.shutdown(wait=False, cancel_futures=True)

    def start(self) -> Server:
        """Serve in a thread of its own, until `close`."""
        listening = threading.Event()
        failed: list[BaseException] = []

        async def main() -> None:
            task = asyncio.current_task()
            loop = asyncio.get_running_loop()
            assert task is not None
            self._ends = lambda: (loop.call_soon_threadsafe(task.cancel), None)[1]
            with contextlib.suppress(asyncio.CancelledError):
                await self.serve(listening.set)

        def work() -> None:
            try:
                asyncio.run(main())
            except BaseException as error:  # raised again by `start`
                failed.append(error)
            listening.set()

        self._thread = threading.Thread(target=work, name="jtik planner server", daemon=True)
        self._thread.start()
        listening.wait()
        if failed:
            raise failed[0]
        return self

    def close(self) -> None:
        """Close all connections and the port."""
        if self._thread is not None:
            with contextlib.suppress(RuntimeError):  # its event loop has ended
                self._ends()
            self._thread.join()
            self._thread = None

    def __enter__(self) -> Server:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _in_thread(self, work: Callable[..., T], *arguments: Any) -> asyncio.Future[T]:
        return asyncio.get_running_loop().run_in_executor(self._workers, work, *arguments)

    async def _tabulate(self) -> None:
        """Keep the table of attempts up to date, measured in another thread."""
        seen = None
        while True:
            history = self._planner.loop.history
            if history is not seen:
                seen, tables = history, self._table.of(history)
                while (rows := await self._in_thread(next, tables, None)) is not None:
                    self._rows = rows
                    self._wake()
                    if self._planner.loop.history is not history:
                        break
            await asyncio.sleep(TABULATE)

    def _wake(self) -> None:
        """Have every connection look for what is new."""
        for each in self._news:
            each.set()

    async def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """The answer to a request; None lets the socket open."""
        path = unquote(request.path.partition("?")[0])
        host, origin = request.headers.get("Host", ""), request.headers.get("Origin")
        if is_foreign(host, origin) or (path == "/socket" and origin is None):
            return response(http.HTTPStatus.FORBIDDEN, b"This page may not open the planner.\n", "text/plain")
        if path == "/socket":
            return None
        return await self._in_thread(document, path, self._planner)

    async def _talk(self, connection: ServerConnection) -> None:
        """Serve one page: send what is new, submit its edits, and stop what it steered when it is gone."""
        from websockets.exceptions import ConnectionClosed

        outgoing, news = Outgoing(self._planner.loop, lambda: self._rows), asyncio.Event()
        self._news.add(news)
        sender = asyncio.create_task(_send(connection, outgoing, news))
        try:
            async for text in connection:
                await self._receive(connection, text, outgoing)
        except ConnectionClosed:
            pass
        finally:
            sender.cancel()
            self._news.discard(news)
            if self._steering is connection:
                self._steering = None
                self._stop()

    async def _receive(self, connection: ServerConnection, text: str | bytes, outgoing: Outgoing) -> None:
        """Submit the edit that a message describes; one that describes none gets an answer."""
        try:
            given = _read(text)
            if not isinstance(given, dict):
                raise ArgumentError("message", given, "an edit, as an object with the key edit")
            if given.get("type") == "hello":
                return
            if given.get("type") == "load_plan":
                text, name = str(given.get("text", "")), str(given.get("name", "plan.json"))
                await self._in_thread(self._planner.load_text, text, name)
                return
            if given.get("edit") in ("save_plan", "load_plan"):
                raise ArgumentError("message", given["edit"], "edits that name no file: a page saves by a download")
            self._planner.loop.submit(edits.from_json(given))
        except (JtikError, ValueError, RecursionError, OSError) as error:
            outgoing.answer(f"{error}")
            self._wake()
            return
        if given["edit"] in STEERING:
            self._steering = connection

    def _stop(self) -> None:
        """Stop the target and the self-motion."""
        still = (0.0,) * self._planner.arm.robot.dimension
        self._planner.loop.submit(edits.HoldTarget(velocity=still))
        self._planner.loop.submit(edits.Jog(rate=0.0))


def _read(text: str | bytes) -> Any:
    """What a message says. Raises ArgumentError for one that is no JSON."""
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        given = f"what is no JSON: {str(error)[:100]}"
        raise ArgumentError("message", given, "an edit, as an object with the key edit") from None


async def _send(connection: ServerConnection, outgoing: Outgoing, news: asyncio.Event) -> None:
    """Send what is new once there is something, at the pace of the page: one that is slow gets the newest only."""
    from websockets.exceptions import ConnectionClosed

    with contextlib.suppress(ConnectionClosed):
        while True:
            news.clear()
            for message in outgoing.news():
                await connection.send(message)
            await news.wait()
