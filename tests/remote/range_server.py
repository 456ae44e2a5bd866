# SPDX-License-Identifier: MIT
"""An HTTP server on the loopback interface for tests, as well and as badly behaved as the first folder of a path says.

/good/FILE      sends the ranges that are asked for
/slow/FILE      the same, 20 ms later
/plain/FILE     knows no ranges: always sends the whole file
/short/FILE     states a length that is ten times too long
/broken/FILE    closes the connection in the middle of every answer behind the first 64 KiB
/busy/FILE      answers 503 to every other request
/changing/FILE  is another file, of other length, from the fourth request on
"""

import http.server
import os
import re
import threading
import time
import urllib.parse


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    disable_nagle_algorithm = True  # the system would hold back what follows the header by 40 ms

    def log_message(self, *_):
        pass

    def do_HEAD(self):
        self.answer(with_body=False)

    def do_GET(self):
        self.answer(with_body=True)

    def answer(self, with_body):
        server = self.server
        _, manner, name = urllib.parse.unquote(self.path).split("/", 2)
        with server.lock:
            server.requests += 1
            number = server.requests
        content = server.content(name)
        if content is None:
            return self.send_error(404)
        if manner == "busy" and number % 2 == 1:
            return self.send_error(503)
        if manner == "changing" and number >= 4:
            content = content[: len(content) // 2]
        if manner == "slow":
            time.sleep(0.02)
        first, last, status = 0, len(content) - 1, 200
        asked = re.fullmatch(r"bytes=(\d+)-(\d*)", self.headers.get("Range", ""))
        if asked and manner != "plain":
            first = int(asked[1])
            last = min(int(asked[2] or last), last)
            if first > last:
                return self.send_error(416)
            status = 206
        body = content[first : last + 1]
        length = 10 * len(content) if manner == "short" else len(body)
        self.send_response(status)
        if manner != "plain":
            self.send_header("Accept-Ranges", "bytes")
        if status == 206:
            whole = 10 * len(content) if manner == "short" else len(content)
            self.send_header("Content-Range", f"bytes {first}-{last}/{whole}")
            length = len(body)
        self.send_header("Content-Length", str(length))
        self.end_headers()
        if not with_body:
            return None
        if manner == "broken" and first >= 65536:
            body = body[: len(body) // 2]
        with server.lock:
            server.sent += len(body)
        try:
            self.wfile.write(body)
        except OSError:
            pass
        if len(body) < length:
            self.close_connection = True
        return None


class RangeServer(http.server.ThreadingHTTPServer):
    """Serves the files of a folder from a thread of its own; counts requests and the bytes it sent."""

    def __init__(self, folder):
        super().__init__(("127.0.0.1", 0), Handler)
        self.folder = folder
        self.lock = threading.Lock()
        self.requests = self.sent = 0
        threading.Thread(target=self.serve_forever, daemon=True).start()

    def content(self, name):
        """The bytes of a file; None if there is no such file."""
        path = os.path.join(self.folder, name)
        if not os.path.isfile(path):
            return None
        with open(path, "rb") as file:
            return file.read()

    def address(self, manner, name):
        return f"http://127.0.0.1:{self.server_port}/{manner}/{name}"

    def forget(self):
        self.requests = self.sent = 0
