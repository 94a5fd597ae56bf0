"""Other libraries as contenders, each imported only when a study prepares it."""

from __future__ import annotations

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
    """What `named` knows."""
    return tuple(peer().label for peer in _PEERS)


def named(name: str) -> Peer:
    """The peer of that name with its default options: what "peer:NAME" means to a study.

    Raises:
        UnknownNameError: when there is none.
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
