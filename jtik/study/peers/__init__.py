"""Other libraries as contenders, each imported only when a study prepares it."""

from __future__ import annotations

import warnings
from typing import Any

from jtik.errors import UnknownNameError
from jtik.study.peers.base import NotInstalledError, Peer
from jtik.study.peers.mink import MinkPeer
from jtik.study.peers.optik import OptikPeer
from jtik.study.peers.pink import PinkPeer
from jtik.study.peers.placo import PlacoPeer
from jtik.study.peers.pyroki import PyrokiPeer
from jtik.study.peers.toolbox import ToolboxPeer

_PEERS: tuple[type[Peer], ...] = (MinkPeer, PinkPeer, PlacoPeer, ToolboxPeer, OptikPeer, PyrokiPeer)


def names() -> tuple[str, ...]:
    """Names of the peers."""
    return tuple(peer().label for peer in _PEERS)


def named(name: str) -> Peer:
    """The peer that a study calls "peer:NAME", with its default options.

    Args:
        name: name of the peer, such as "mink".

    Raises:
        UnknownNameError: for an unknown name.
    """
    peers = {peer().label: peer for peer in _PEERS}
    if name not in peers:
        raise UnknownNameError("peer", name, peers)
    return peers[name]()


__all__ = [
    "MinkPeer",
    "NotInstalledError",
    "OptikPeer",
    "Peer",
    "PinkPeer",
    "PlacoPeer",
    "PyrokiPeer",
    "ToolboxPeer",
    "named",
    "names",
]

_RENAMED: dict[str, type[Peer]] = {
    "Mink": MinkPeer,
    "Optik": OptikPeer,
    "Pink": PinkPeer,
    "Placo": PlacoPeer,
    "Pyroki": PyrokiPeer,
    "Toolbox": ToolboxPeer,
}


def __getattr__(name: str) -> Any:
    if name in _RENAMED:
        message = f"jtik.study.peers.{name} is now jtik.study.peers.{name}Peer"
        warnings.warn(message, DeprecationWarning, stacklevel=2)
        return _RENAMED[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
