"""Other libraries as contenders, each imported only when a study prepares it."""

from __future__ import annotations

from jtik.errors import UnknownNameError
from jtik.study.peers.base import NotInstalledError, Peer
from jtik.study.peers.mink import Mink
from jtik.study.peers.optik import Optik
from jtik.study.peers.pink import Pink
from jtik.study.peers.placo import Placo
from jtik.study.peers.pyroki import Pyroki
from jtik.study.peers.toolbox import Toolbox

_PEERS: tuple[type[Peer], ...] = (Mink, Pink, Placo, Toolbox, Optik, Pyroki)


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


__all__ = ["Mink", "NotInstalledError", "Optik", "Peer", "Pink", "Placo", "Pyroki", "Toolbox", "named", "names"]
