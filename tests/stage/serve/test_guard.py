import pytest

from mgjax.stage.serve.guard import host_is_own, is_loopback, origin_is_own, own_hosts


@pytest.mark.parametrize(
    ("host", "loopback"),
    [
        *((host, True) for host in ("127.0.0.1", "localhost", "::1", "127.9.9.9")),
        *((host, False) for host in ("0.0.0.0", "192.168.1.2", "example.org", "")),
    ],
)
def test_loopback(host, loopback):
    assert is_loopback(host) == loopback


@pytest.mark.parametrize("value", ["127.0.0.1:8765", "localhost:8765", "LOCALHOST:8765"])
def test_own_names(value):
    assert host_is_own(value, own_hosts("127.0.0.1", 8765), "127.0.0.1")


@pytest.mark.parametrize(
    "value",
    [None, "", "evil.example:8765", "127.0.0.1", "127.0.0.1:80", "127.0.0.1.evil.example:8765"],
)
def test_foreign_names(value):
    assert not host_is_own(value, own_hosts("127.0.0.1", 8765), "127.0.0.1")


def test_all_addresses_take_numbers_but_no_foreign_names():
    hosts = own_hosts("0.0.0.0", 8765)
    assert host_is_own("192.168.1.2:8765", hosts, "0.0.0.0")
    assert not host_is_own("192.168.1.2:80", hosts, "0.0.0.0")
    assert not host_is_own("evil.example:8765", hosts, "0.0.0.0")


def test_one_address_takes_no_other():
    hosts = own_hosts("192.168.1.2", 8765)
    assert host_is_own("192.168.1.2:8765", hosts, "192.168.1.2")
    assert not host_is_own("192.168.1.3:8765", hosts, "192.168.1.2")


@pytest.mark.parametrize(
    ("origin", "own"),
    [
        ("http://127.0.0.1:8765", True),
        ("https://127.0.0.1:8765", False),
        ("http://127.0.0.1:9999", False),
        ("http://evil.example", False),
        ("null", False),
        (None, False),
    ],
)
def test_origins(origin, own):
    assert origin_is_own(origin, "127.0.0.1:8765") == own
