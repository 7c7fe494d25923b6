"""Who may talk to the server: pages that it served itself, under the names it is reached by."""

from __future__ import annotations

import ipaddress
import socket

LOOPBACK = ("127.0.0.1", "localhost", "[::1]")


def own_hosts(host: str, port: int) -> frozenset[str]:
    """Values of ``Host`` under which the server is reached.

    On an address of this machine alone these are its names; foreign ones could be a page whose
    name was made to point here. On other addresses it is that address, and this machine's name.
    """
    names = set(LOOPBACK)
    if not is_loopback(host):
        names |= {host, socket.gethostname()}
    return frozenset(f"{name}:{port}" for name in names)


def is_loopback(host: str) -> bool:
    """Whether an address is reached from this machine only."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host.strip("[]")).is_loopback
    except ValueError:
        return False


def host_is_own(value: str | None, hosts: frozenset[str], host: str) -> bool:
    """Whether a ``Host`` header names this server; on all addresses any number will do."""
    if value is None:
        return False
    if value.lower() in hosts:
        return True
    if is_loopback(host):
        return False
    name, _, port = value.rpartition(":")
    own_port = next(iter(hosts)).rpartition(":")[2]
    try:
        ipaddress.ip_address(name.strip("[]"))
    except ValueError:
        return False
    return port == own_port and host in ("0.0.0.0", "::")


def origin_is_own(origin: str | None, host_header: str | None) -> bool:
    """Whether a page of this very server asks: its ``Origin`` is the ``Host`` it came from."""
    return origin is not None and host_header is not None and origin == f"http://{host_header}"
