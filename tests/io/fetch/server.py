"""A database as that of CMU on this machine, with one skeleton and two motions of one frame."""

from __future__ import annotations

import http.server
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from urllib.parse import parse_qs, urlsplit

ASF = """# made for the tests
:version 1.10
:name VICON
:units
  mass 1.0
  length 0.45
  angle deg
:root
  order TX TY TZ RX RY RZ
  axis XYZ
  position 0 0 0
  orientation 0 0 0
:bonedata
  begin
    id 1
    name leg
    direction 0 -1 0
    length 8
    axis 0 0 0 XYZ
    dof rx
    limits (-160.0 20.0)
  end
:hierarchy
  begin
    root leg
  end
"""
FRAMES = "1\nroot 0 17 0 0 0 0\nleg 10\n2\nroot 0 17 0 0 0 0\nleg 1{}\n"
AMC = "#!OML:ASF\n:FULLY-SPECIFIED\n:DEGREES\n" + FRAMES


class Database:
    """What the server has and how it behaves.

    Attributes:
        rates: frames per second of each motion, as its page states them; None: an empty cell.
        files: by path.
        asked: paths that were asked for, in their order.
        cut: paths whose answer ends before its size.
    """

    def __init__(self, rates: dict[str, int | None]) -> None:
        self.rates = rates
        self.files = {}
        for number, name in enumerate(rates):
            subject = name.split("_")[0]
            self.files[f"/subjects/{subject}/{subject}.asf"] = ASF
            self.files[f"/subjects/{subject}/{name}.amc"] = AMC.format(number)
        self.asked: list[str] = []
        self.cut: set[str] = set()
        self.address = ""

    def page(self, number: int) -> str:
        """As the database writes it."""
        rows = ""
        for name, rate in self.rates.items():
            subject, motion = name.split("_")
            if int(subject) == number:
                at = f"http://mocap.cs.cmu.edu:80/subjects/{subject}/{name}"
                rows += (
                    f"<TR BGCOLOR=#FFFFFF><TD></TD><TD>{int(motion)}</TD><TD>walk</TD>"
                    f'<TD><A HREF="{at}.tvd">tvd</A></TD><TD><A HREF="{at}.c3d">c3d</A></TD>'
                    f'<TD><A HREF="{at}.amc">amc</A></TD><TD><A HREF="{at}.mpg">mpg</A></TD>'
                    f"<TD></TD><TD>{rate or ''}</TD>"
                    f'<TD><A HREF="badtrial.php?subjectnumber={number}">Feedback</A></TD></TR>'
                )
        return f"<HTML><TABLE>{rows}</TABLE></HTML>"


@contextmanager
def served(database: Database) -> Iterator[Database]:
    """The database on a port of its own, while the block runs."""

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            split = urlsplit(self.path)
            database.asked.append(split.path)
            if split.path == "/search.php":
                text = database.page(int(parse_qs(split.query)["subjectnumber"][0]))
            elif split.path in database.files:
                text = database.files[split.path]
            else:
                self.send_error(404)
                return
            data = text.encode()
            self.send_response(200)
            self.send_header("Content-Length", str(len(data)))
            self.end_headers()
            self.wfile.write(data[: len(data) // 2] if split.path in database.cut else data)

        def log_message(self, *arguments: object) -> None:
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        database.address = f"http://127.0.0.1:{server.server_port}"
        try:
            yield database
        finally:
            server.shutdown()
            thread.join()
