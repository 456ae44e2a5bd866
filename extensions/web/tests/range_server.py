# SPDX-License-Identifier: MIT
"""An HTTP server on the loopback interface for tests, as well and as badly behaved as the first folder of a path says.

/good/FILE       sends the ranges that are requested
/slow/FILE       the same, 20 ms later
/plain/FILE      does not support ranges: always sends the whole file
/plain-length/FILE  the same, but states a length of 0 to HEAD
/plain-tag/FILE  the same, but states another ETag to HEAD
/whole/FILE      sends ranges, but the whole file without one when the range holds all of it
/capped/FILE     sends at most 10000 bytes of a range, and does not say which
Behind the first 64 KiB:
/broken/FILE     closes the connection in the middle of every answer
/broken-once/FILE  the same, once
/drip/FILE       sends one answer slowly: 1000 bytes a second for 4 seconds, then the rest
/stalled/FILE    stops sending in the middle of every answer, but keeps the connection
/long/FILE       states a Content-Length that is too long
/cut/FILE        states a Content-Length that is too short
/shifted/FILE    sends bytes 100 before, and says so
/hidden/FILE     does not say which bytes it sends
/empty-range/FILE  states a Content-Range that is none
/tag/FILE        has another ETag from there on, and other bytes
/time/FILE       has another Last-Modified, and other bytes
/size/FILE       is only half as long from there on
Everywhere:
/short/FILE      states a length that is ten times too long
/busy-503/FILE   answers 503 (or 429, 500 ...) to two of three requests
/status-403/FILE  always answers 403, with a page of 40 kB
/moved/FILE      redirects to /good/FILE, each time with another ETag
/moved-bare/FILE  the same, to /bare/FILE
/away/FILE       redirects to /good/FILE of the server `other`
/bare/FILE       sends neither ETag nor Last-Modified
/dated/FILE      sends the time of the file's last change as Last-Modified, and no ETag
/keyed/FILE      answers 403 to requests without the header X-Key: 17
/silent-3/FILE   does not answer from the fourth request on
/gone-3/FILE     closes the connection from the fourth request on
"""

import email.utils
import http.server
import os
import re
import threading
import time
import urllib.parse
import zlib

FAR = 65536


class Handler(http.server.BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    # As servers of buckets answer.
    error_content_type = "application/xml"
    error_message_format = "<?xml version='1.0'?>\n<Error><Code>%(message)s</Code><Message>%(explain)s</Message></Error>\n"
    disable_nagle_algorithm = True  # the system would hold back what follows the header by 40 ms

    def log_message(self, *_):
        pass

    def do_HEAD(self):
        self.answer(with_body=False)

    def do_GET(self):
        self.answer(with_body=True)

    def answer(self, with_body):
        server = self.server
        _, manner, name = urllib.parse.unquote(urllib.parse.urlsplit(self.path).path).split("/", 2)
        with server.lock:
            server.requests += 1
            server.times.append(time.monotonic())
            number = server.requests
        content = server.content(name)
        if content is None:
            return self.send_error(404, "NoSuchKey")
        if manner.startswith("busy-") and number % 3 != 0:
            return self.send_error(int(manner[5:]))
        if manner.startswith("status-"):
            status = int(manner[7:])
            return self.send_error(status, "AccessDenied" if status == 403 else None, "no " * 13000)
        if manner.startswith("gone-") and number > int(manner[5:]):
            self.close_connection = True
            return None
        if server.closes_after is not None and server.sent > server.closes_after:
            self.close_connection = True
            return None
        if manner.startswith("silent-") and number > int(manner[7:]):
            server.stop.wait(60)
            self.close_connection = True
            return None
        if manner == "keyed" and self.headers.get("X-Key") != "17":
            return self.send_error(403)
        if manner in ("moved", "moved-bare", "away"):
            self.send_response(302)
            target = server.other if manner == "away" else server
            self.send_header("Location", target.address("bare" if manner == "moved-bare" else "good", name))
            self.send_header("ETag", f'"{number}"')
            self.send_header("Content-Length", "0")
            return self.end_headers()
        if manner == "slow":
            time.sleep(0.02)
        asked = re.fullmatch(r"bytes=(\d+)-(\d*)", self.headers.get("Range", ""))
        is_far = asked is not None and int(asked[1]) >= FAR
        tag, modified = zlib.crc32(content[:4096]), 0
        if is_far and manner in ("tag", "time"):
            content = bytes(len(content))
            tag, modified = tag + (manner == "tag"), int(manner == "time")
        if is_far and manner == "size":
            content = content[: len(content) // 2]
        if manner == "plain-tag" and not with_body:
            tag += 1
        first, last, status = 0, len(content) - 1, 200
        has_ranges = not manner.startswith("plain")
        if asked and has_ranges:
            first = int(asked[1])
            last = min(int(asked[2] or last), last)
            status = 206
        if status == 206 and manner == "whole" and (first, last) == (0, len(content) - 1):
            status = 200
        if manner == "capped":
            last = min(last, first + 9999)
        if is_far and manner == "shifted":
            first, last = first - 100, last - 100
        if first > last or first >= len(content):
            self.send_response(416)
            self.send_header("Content-Range", f"bytes */{len(content)}")
            self.send_header("Content-Length", "0")
            return self.end_headers()
        body = content[first : last + 1]
        self.send_response(status)
        if has_ranges:
            self.send_header("Accept-Ranges", "bytes")
        if manner == "dated":
            modified = int(os.path.getmtime(os.path.join(server.folder, name)))
        if manner not in ("time", "bare", "dated"):
            self.send_header("ETag", f'"{tag:x}"')
        if manner != "bare":
            self.send_header("Last-Modified", email.utils.formatdate(modified, usegmt=True))
        length = 0 if manner == "plain-length" and not with_body else len(body)
        if manner == "short" and status == 200:
            length = 10 * len(content)
        if is_far and manner in ("long", "cut"):
            length = 2 * length if manner == "long" else length // 2
        if status == 206 and manner != "capped" and not (is_far and manner == "hidden"):
            whole = 10 * len(content) if manner == "short" else len(content)
            stated = f"bytes {first}-{last}/{whole}"
            self.send_header("Content-Range", "lines 1-2" if is_far and manner == "empty-range" else stated)
        self.send_header("Content-Length", str(length))
        self.end_headers()
        if not with_body:
            return None
        if is_far and (manner in ("broken", "stalled") or manner == "broken-once" and server.is_first("broken")):
            body = body[: len(body) // 2]
        with server.lock:
            server.sent += len(body)
        try:
            for _ in range(40 if is_far and manner == "drip" and server.is_first("drip") else 0):
                self.wfile.write(body[:100])
                self.wfile.flush()
                body = body[100:]
                server.stop.wait(0.1)
            self.wfile.write(body)
            if is_far and manner == "stalled":
                self.wfile.flush()
                server.stop.wait(60)
        except OSError:
            pass
        if len(body) != length and manner != "drip":
            self.close_connection = True
        return None


class RangeServer(http.server.ThreadingHTTPServer):
    """Serves the files of a folder from a thread of its own; counts requests and the bytes it sent."""

    def __init__(self, folder):
        super().__init__(("127.0.0.1", 0), Handler)
        self.folder = folder
        self.lock = threading.Lock()
        self.stop = threading.Event()
        self.requests = self.sent = 0
        self.times = []  # of the requests, seconds
        self.seen = set()
        self.other = None
        self.closes_after = None  # bytes; answers nothing behind them
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

    def is_first(self, what):
        """Whether something has not been asked since forget()."""
        with self.lock:
            is_new = what not in self.seen
            self.seen.add(what)
        return is_new

    def forget(self):
        self.requests = self.sent = 0
        self.times.clear()
        self.seen.clear()
