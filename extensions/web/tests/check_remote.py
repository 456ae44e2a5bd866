# SPDX-License-Identifier: MIT
"""check_remote.py PROGRAM: clouds on HTTP servers and in archives answer as those on the disk."""

import gzip
import json
import os
import re
import shutil
import signal
import struct
import subprocess
import time
import unittest

import country
import range_server
from remote_case import PROGRAM, RemoteCase


class RemoteTest(RemoteCase):
    def test_answers_are_those_of_the_file(self):
        for name in ("site.las", "site.laz", "site.copc.laz", "site.alidade"):
            with self.subTest(name):
                self.assertEqual(self.query(self.server.address("good", name)), self.query(name))

    def test_copc_fetches_only_what_it_needs(self):
        self.server.forget()
        self.query(self.server.address("slow", "site.copc.laz"))
        size = os.path.getsize(os.path.join(self.folder, "site.copc.laz"))
        self.assertLess(self.server.sent, 0.7 * size)
        self.assertLess(self.server.requests, 40)

    def test_index_files_answer_as_on_the_disk(self):
        rays = os.path.join(self.folder, "rays.csv")
        with open(rays, "w", encoding="utf-8") as file:
            file.write("ox,oy,oz,dx,dy,dz\n")
            for i in range(100):
                file.write(f"{690000 + i % 10},{5325000 + i // 10},640,{0.1 * (i % 7)},0.1,-1\n")
        remote = self.server.address("good", "site.alidade")
        for words in (("query", "@", "--rays", "rays.csv", "--radius", "0.2"),
                      ("query", "@", "--rays", "rays.csv", "--radius", "0.2", "--k", "2", "--classes", "2"),
                      ("query", "@", "--point", "690000,5325000,601", "--k", "50"),
                      ("query", "@", "--box", "689990,5324990,600,690010,5325010,620", "--count"),
                      ("info", "@", "--json")):
            with self.subTest(words):
                local, far = (self.run_program(*(word.replace("@", name) for word in words))
                              for name in ("site.alidade", remote))
                self.assertGreater(len(local), 20)
                self.assertEqual(far.replace(remote, "site.alidade"), local)
        for name, output in (("site.alidade", "near"), (remote, "far")):
            self.run_program("render", "--cloud", name, "-o", output + ".png", "--size", "60x40", "--samples", "1")
            self.run_program("convert", name, "-o", output + ".las")
            self.run_program("index", name, "-o", output + ".alidade")
        self.run_program("compare", "near.png", "far.png", "--fail-above", "rmse>0")
        for extension in (".las", ".alidade"):
            with open(os.path.join(self.folder, "near" + extension), "rb") as near, \
                    open(os.path.join(self.folder, "far" + extension), "rb") as far:
                self.assertEqual(near.read().replace(b"site.alidade", b""),
                                 far.read().replace(remote.encode(), b""))

    def test_an_index_file_is_fetched_once_and_its_description_without_it(self):
        self.run_program("generate", "courtyard", "--points", "1000000", "-o", "large.las")
        self.run_program("index", "large.las", "-o", "large.alidade")
        size = os.path.getsize(os.path.join(self.folder, "large.alidade"))
        address = self.server.address("good", "large.alidade")
        for words in (("info", address), self.words(address) + ("--dry-run",)):
            self.server.forget()
            self.run_program(*words)
            self.assertLess(self.server.sent, 0.01 * size)
        self.server.forget()
        self.query(address)
        self.assertLess(self.server.sent, 1.01 * size)
        self.assertGreaterEqual(self.server.sent, size)
        self.assertLess(self.server.requests, 20)

    def test_the_size_of_an_index_file_is_said_before_it_is_fetched(self):
        address = self.server.address("good", "site.alidade")
        for cache, kept in (((), "--cache FOLDER keeps it for the next time"), (("--cache", "said"), "kept for the next time"),
                            (("--cache", "small", "--cache-size", "20k"), "a larger --cache-size keeps it for the next time")):
            done = subprocess.run([PROGRAM, *self.words(address), *cache], cwd=self.folder, capture_output=True, text=True,
                                  timeout=120, check=True)
            self.assertRegex(done.stderr, re.escape(address) + r": fetching the whole index file, [0-9.]+ MB, into .* \(" +
                             re.escape(kept) + r"\); of COPC files \(\.copc\.laz\) queries fetch only what they need\n")

    def test_an_index_file_that_the_disk_has_no_room_for_is_an_error(self):
        message = self.query(self.server.address("good", "site.alidade"), succeeds=False, largest_file=100)
        self.assertIn("cannot write a temporary file in this folder", message)

    def test_an_index_file_whose_server_goes_away_is_an_error(self):
        self.server.forget()
        self.query(self.server.address("good", "site.alidade"))
        for answered in range(1, self.server.requests):
            address = self.server.address(f"gone-{answered}", "site.alidade")
            for words in (("--format", "csv"), ("-o", "bad.csv")):
                with self.subTest(answered, words=words):
                    self.server.forget()
                    message = self.run_program("query", address, "--ray", "690000,5325000,640,0,0,-1", "--radius",
                                               "0.5", "--k", "4", *words, succeeds=False)
                    self.assertIn(f"alidade: error: {address}: cannot read from the server (4 attempts): ", message)
                    self.assertEqual([left for left in os.listdir(self.folder) if "bad" in left], [])

    def test_explain_tells_what_was_fetched(self):
        self.server.forget()
        done = subprocess.run([PROGRAM, "query", self.server.address("good", "site.copc.laz"), "--ray",
                               "690000,5325000,640,0,0,-1", "--radius", "0.5", "--k", "4", "--explain", "-q"],
                              cwd=self.folder, capture_output=True, text=True, timeout=120, check=True)
        told = dict(line.rsplit(None, 1) for line in done.stderr.splitlines() if line.startswith("remote "))
        self.assertEqual(int(told["remote requests"]), self.server.requests)
        self.assertEqual(int(told["remote bytes"]), self.server.sent)

    def test_a_ray_through_many_tiles_fetches_little_of_few(self):
        side = 14
        self.run_program("generate", "courtyard", "--points", "5000", "-o", "tile.las", "--overwrite")
        self.run_program("convert", "tile.las", "-o", "tile.copc.laz", "--overwrite")
        server = country.Country(self.folder, os.path.join(self.folder, "tile.copc.laz"))
        self.addCleanup(server.server_close)
        self.addCleanup(server.shutdown)
        tiles = os.path.join(self.folder, "country")
        os.mkdir(tiles)
        for name in country.tile_names(side):
            with open(os.path.join(tiles, name), "wb") as file:
                file.write(server.content(name)[:])
        self.run_program("catalog", "country", "-o", "country/site.catalog.json")
        catalog = os.path.join(self.folder, "site.catalog.json")
        os.rename(os.path.join(tiles, "site.catalog.json"), catalog)
        with open(catalog, "rb") as file, gzip.open(catalog + ".gz", "wb") as packed:
            packed.write(file.read())
        catalog_size = os.path.getsize(catalog)
        for name, ray in country.rays(side).items():
            for limit in ((), ("--k", "1"), ("--count",)):
                with self.subTest(name, limit=limit):
                    words = ("--ray", ray, "--radius", "1.5", *limit, "--format", "csv")
                    expected = self.run_program("query", "country", "--load", *words)
                    self.assertGreater(expected.count("\n"), 1)
                    server.forget()
                    address = server.address("good", "site.catalog.json")
                    self.assertEqual(self.run_program("query", address, *words), expected)
                    self.assertLess(server.sent, catalog_size + 20 * len(server.tile))
                    self.assertLess(server.requests, 200)
                    server.forget()
                    self.assertEqual(self.run_program("query", address + ".gz", *words), expected)
                    self.assertLess(server.sent, catalog_size / 5 + 20 * len(server.tile))

    def test_a_remote_catalog_leads_nowhere_else(self):
        for href in ("../site.las", "/etc/passwd", "http://127.0.0.1:9/site.las", "file:///etc/passwd", "https:x.las",
                     "%2e%2e/site.las", "a/%2E%2E/../../site.las"):
            with self.subTest(href):
                with open(os.path.join(self.folder, "bad.catalog.json"), "w", encoding="utf-8") as file:
                    json.dump({"type": "FeatureCollection", "features": [{"assets": {"data": {"href": href}}}]}, file)
                message = self.query(self.server.address("good", "bad.catalog.json"), succeeds=False)
                self.assertIn("bad.catalog.json:item 1: the href le", message)
                os.remove(os.path.join(self.folder, "bad.catalog.json"))

    def test_a_catalog_names_files_below_it_or_of_hosts_that_are_allowed_redirections_included(self):
        other = range_server.RangeServer(self.folder)
        self.addCleanup(other.server_close)
        self.addCleanup(other.shutdown)
        self.server.other = other
        host, away = (f"127.0.0.1:{server.server_port}" for server in (self.server, other))
        expected = self.query("site.copc.laz")

        def catalog(href):
            with open(os.path.join(self.folder, "hosts.catalog.json"), "w", encoding="utf-8") as file:
                json.dump({"type": "FeatureCollection", "features": [{"assets": {"data": {"href": href}}}]}, file)

        # Beside the folder of the catalog, from a catalog here, and by a redirection of what lies below it.
        for manner, href, needed in (("good", self.server.address("plain", "site.copc.laz"), host),
                                     (None, self.server.address("good", "site.copc.laz"), host),
                                     ("away", "site.copc.laz", away)):
            with self.subTest(manner=manner, href=href):
                catalog(href)
                name = self.server.address(manner, "hosts.catalog.json") if manner else "hosts.catalog.json"
                message = self.query(name, succeeds=False)
                self.assertRegex(message, "is not allowed; expected .*--allow-host " + needed)
                self.assertIn("is not allowed", self.query(name, "--allow-host", "example.org", succeeds=False))
                self.assertEqual(self.query(name, "--allow-host", needed), expected)
                self.assertEqual(self.query(name, settings={"ALIDADE_ALLOW_HOSTS": "example.org," + needed}), expected)
        # Who names a file goes where its server leads.
        self.assertEqual(self.query(self.server.address("away", "site.copc.laz")), expected)
        catalog(self.server.address("good", "site.copc.laz"))
        self.assertEqual(self.query(self.server.address("good", "hosts.catalog.json")), expected)
        self.assertIn("invalid host", self.query("site.laz", "--allow-host", "http://example.org", succeeds=False))

    def bucket_settings(self):
        """Buckets are then the manners of the server."""
        return {"AWS_S3_ENDPOINT": f"127.0.0.1:{self.server.server_port}", "AWS_HTTPS": "NO",
                "AWS_VIRTUAL_HOSTING": "FALSE", "AWS_NO_SIGN_REQUEST": "YES"}

    def test_a_checkpoint_continues_only_with_the_same_version(self):
        if "--checkpoint" not in self.run_program("index", "--help"):
            self.skipTest("without the extension scratch")

        def change_tag(path):
            with open(path, "r+b") as file:
                file.seek(26)  # the name of a system in the header
                file.write(b"another")

        def change_time(path):
            os.utime(path, (1e9, 1e9))

        self.run_program("generate", "courtyard", "--points", "60000", "-o", "sound.las")
        for number, (address, change) in enumerate(((self.server.address("good", "kept.las"), change_tag),
                                                    (self.server.address("dated", "kept.las"), change_time),
                                                    ("s3://dated/kept.las", change_time))):
            with self.subTest(address):
                path, state = os.path.join(self.folder, "kept.las"), f"state-{number}"
                shutil.copyfile(os.path.join(self.folder, "sound.las"), path)
                words = ("index", address, "--memory", "1M", "-o", f"kept-{number}.alidade", "--checkpoint", state)
                self.run_program(*words, settings=self.bucket_settings(), succeeds=False, largest_file=1500)
                with open(os.path.join(self.folder, state, "manifest"), "rb") as manifest:
                    self.assertIn(b"positions", manifest.read())
                times = (os.stat(path).st_atime, os.stat(path).st_mtime)
                change(path)
                resumed = (*words, "--resume")
                self.assertRegex(self.run_program(*resumed, settings=self.bucket_settings(), succeeds=False),
                                 f"{state}: this checkpoint belongs to another run: it has {re.escape(address)} "
                                 ".+, this run has .+; expected the same cloud and options, or no --resume")
                if change is change_time:
                    os.utime(path, times)
                    self.run_program(*resumed, settings=self.bucket_settings())

    def test_of_buckets_ranges_are_read_and_none_is_cached(self):
        settings = self.bucket_settings()
        for name, most in (("site.copc.laz", 0.7), ("site.alidade", 1.1)):
            size = os.path.getsize(os.path.join(self.folder, name))
            for address in (f"s3://good/{name}", f"/vsis3/good/{name}"):
                with self.subTest(address):
                    self.server.forget()
                    self.assertEqual(self.query(address, cache="bucket", settings=settings), self.query(name))
                    self.assertLess(self.server.sent, most * size)
                    self.assertGreater(self.server.requests, 3)
        self.assertEqual(os.listdir(os.path.join(self.folder, "bucket")), ["alidade-cache"])
        for name in ("good/none.laz", "status-403/site.laz"):
            self.assertRegex(self.query(f"s3://{name}", settings=settings, succeeds=False),
                             f"s3://{name}: cannot open the file: .+; expected an existing file that you may read\n$")
        message = self.query("s3://good/site.laz", settings=dict(settings, AWS_S3_ENDPOINT="127.0.0.1:9"), succeeds=False)
        self.assertRegex(message, "s3://good/site.laz: cannot open the file: .*[Cc]onnect.*\n$")
        self.assertNotIn("expected", message)

    def test_archives_are_read_in_place(self):
        self.assertEqual(self.query("/vsizip/site.zip/tiles/site.las"), self.query("site.las"))

    def test_compressed_files_are_read_in_turn(self):
        for number in range(2):
            self.run_program("generate", "courtyard", "--points", "20000", "--seed", str(number), "-o", f"turn-{number}.las")
            self.run_program("index", f"turn-{number}.las", "-o", f"turn-{number}.alidade")
            for extension in ("las", "alidade"):
                name = os.path.join(self.folder, f"turn-{number}.{extension}")
                with open(name, "rb") as file, gzip.open(name + ".gz", "wb") as smaller:
                    smaller.write(file.read())
        query, change = self.words("")[2:], ("--no-sight", "--json", "-o", "turn.las", "--overwrite")
        for command, extension, words in (("query", "las", query), ("change", "alidade", change)):
            names = [f"turn-{number}.{extension}" for number in range(2)]
            expected = self.run_program(command, *names, *words)
            for folder in ("/vsigzip/", "/vsigzip//vsicurl/" + self.server.address("good", "")):
                with self.subTest(command, folder=folder):
                    packed = [folder + name + ".gz" for name in names]
                    self.assertEqual(self.run_program(command, *packed, *words), expected)

    def test_requests_to_a_busy_server_are_repeated(self):
        for status in (429, 500, 502, 503, 504):
            with self.subTest(status):
                self.server.forget()
                self.assertEqual(self.query(self.server.address(f"busy-{status}", "site.laz")), self.query("site.laz"))
                self.assertGreater(self.server.requests, 3)

    def test_pauses_before_requests_are_repeated_double(self):
        self.server.forget()
        self.assertIn("(4 attempts): HTTP status 503",
                      self.query(self.server.address("status-503", "site.laz"), succeeds=False,
                                 settings={"GDAL_HTTP_RETRY_DELAY": "0.1"}))
        pauses = [later - earlier for earlier, later in zip(self.server.times, self.server.times[1:])]
        for pause, least in zip(pauses[:3], (0.1, 0.2, 0.4), strict=True):
            self.assertGreaterEqual(pause, least)

    def test_servers_that_redirect_or_ask_for_a_key_are_read(self):
        for manner in ("moved", "moved-bare"):  # the ETags are those of redirections, and change
            self.assertEqual(self.query(self.server.address(manner, "site.laz")), self.query("site.laz"))
        address = self.server.address("keyed", "site.laz")
        self.assertIn("HTTP status 403", self.query(address, succeeds=False))
        self.assertEqual(self.query(address, settings={"GDAL_HTTP_HEADERS": "X-Other: 1,X-Key: 17"}),
                         self.query("site.laz"))

    def test_a_connection_that_breaks_once_is_made_again(self):
        for name in ("site.laz", "site.copc.laz"):
            with self.subTest(name):
                self.server.forget()
                self.assertEqual(self.query(self.server.address("broken-once", name)), self.query(name))
                self.assertFalse(self.server.is_first("broken"))

    def test_bad_servers_are_errors_that_name_the_file(self):
        for manner, expected in {
                "good": "missing.laz: cannot read from the server: HTTP status 404",
                "status-403": ": cannot read from the server: HTTP status 403",
                "broken": ": cannot read from the server (4 attempts): ",
                "long": ": cannot read from the server (4 attempts): ",
                "cut": ": the server sent another number of bytes than it stated; expected ",
                "shifted": ": the server sent other bytes than requested; expected bytes ",
                "hidden": ": the server does not state which bytes it sent; expected the header Content-Range",
                "empty-range": ": invalid Content-Range from the server; expected bytes FIRST-LAST/SIZE, found lines 1-2",
                "tag": ": the file changed on the server while it was read; read it again; expected ",
                "time": ": the file changed on the server while it was read; read it again; expected ",
                "size": ": the file changed on the server while it was read; read it again; expected ",
        }.items():
            names = ("site.laz", "site.copc.laz", "site.alidade") if manner in ("broken", "tag") else ("site.laz",)
            for name in ("missing.laz",) if manner == "good" else names:
                with self.subTest(manner, name=name):
                    self.server.forget()
                    address = self.server.address(manner, name)
                    message = self.run_program("convert", address, "-o", "bad.las", succeeds=False)
                    self.assertRegex(message, "^alidade: error: " + address.replace(name, ""))
                    self.assertIn(expected, message)
                    self.assertLess(self.server.requests, 40)
                    self.assertEqual([left for left in os.listdir(self.folder) if "bad" in left], [])

    def test_servers_that_state_a_wrong_size_are_errors(self):
        for name in ("site.las", "site.laz", "site.copc.laz"):
            with self.subTest(name):
                address = self.server.address("short", name)
                self.assertIn(address, self.query(address, succeeds=False))

    def test_a_server_that_stalls_is_an_error(self):
        address = self.server.address("stalled", "site.laz")
        limits = {"GDAL_HTTP_LOW_SPEED_TIME": "1", "GDAL_HTTP_MAX_RETRY": "1"}
        self.assertIn(address + ": cannot read from the server (2 attempts): ",
                      self.run_program("convert", address, "-o", "bad.las", succeeds=False, settings=limits))
        self.assertFalse(os.path.exists(os.path.join(self.folder, "bad.las")))

    def test_a_server_that_drips_is_an_error_unless_the_limit_is_lower(self):
        address = self.server.address("drip", "site.las")
        limits = {"GDAL_HTTP_LOW_SPEED_TIME": "1", "GDAL_HTTP_MAX_RETRY": "0"}
        self.server.forget()
        message = self.run_program("convert", address, "-o", "bad.las", succeeds=False, settings=limits)
        self.assertIn(address + ": cannot read from the server: ", message)
        self.assertIn("; expected a faster one, or a lower GDAL_HTTP_LOW_SPEED_LIMIT (bytes/s)", message)
        self.assertFalse(os.path.exists(os.path.join(self.folder, "bad.las")))
        limits["GDAL_HTTP_LOW_SPEED_LIMIT"] = "10"
        self.server.forget()
        self.assertEqual(self.query(address, settings=limits), self.query("site.las"))

    def test_waiting_for_a_server_can_be_interrupted(self):
        for manner, name, requests, settings in (("stalled", "site.laz", 2, {}), ("silent-1", "site.alidade", 2, {}),
                                                 ("stalled", "site.alidade", 4, {}),
                                                 ("status-503", "site.laz", 1, {"GDAL_HTTP_RETRY_DELAY": "1000"})):
            with self.subTest(manner):
                self.server.forget()
                words = (*self.words(self.server.address(manner, name)), "-o", "bad.csv", "-q")
                with subprocess.Popen([PROGRAM, *words], cwd=self.folder, stderr=subprocess.PIPE,
                                      env=dict(os.environ, **settings)) as program:
                    while self.server.requests < requests:
                        time.sleep(0.01)
                    time.sleep(0.1)
                    program.send_signal(signal.SIGINT)
                    begin = time.monotonic()
                    _, message = program.communicate(timeout=20)
                self.assertEqual((program.returncode, message), (130, b"alidade: error: interrupted\n"))
                self.assertLess(time.monotonic() - begin, 5)
                self.assertEqual([left for left in os.listdir(self.folder) if "bad" in left], [])

    def test_a_server_without_ranges_gives_the_same(self):
        for name in ("site.las", "site.laz", "site.copc.laz"):
            self.server.forget()
            self.assertEqual(self.query(self.server.address("plain", name)), self.query(name))
            self.assertEqual(self.server.requests, 1)

    def test_what_a_server_without_ranges_sends_is_kept_in_an_unnamed_file(self):
        address, scratch = self.server.address("plain", "site.laz"), os.path.join(self.folder, "scratch")
        os.mkdir(scratch)
        self.query(address, settings={"TMPDIR": scratch})
        self.assertEqual(os.listdir(scratch), [])
        os.rmdir(scratch)
        self.assertIn("scratch: no folder for temporary files; expected the environment variable TMPDIR",
                      self.query(address, settings={"TMPDIR": scratch}, succeeds=False))
        self.assertIn("cannot read from the server: HTTP status 403",
                      self.query(self.server.address("status-403", "site.laz"), settings={"TMPDIR": scratch},
                                 succeeds=False))

    def test_files_about_as_long_as_the_first_request_are_whole_or_an_error(self):
        points = "".join(f"{690000 + i % 9}.{i % 7} {5325000 + i % 11}.5 {600 + i % 5}.25\n" for i in range(700))
        for size in (9000, 16383, 16384, 16385):
            name = f"of-{size}.xyz"
            with open(os.path.join(self.folder, name), "w", encoding="ascii") as file:
                end = points.rindex("\n", 0, size - 1)
                file.write(points[:end] + "0" * (size - 1 - end) + "\n")
            expected = self.run_program("info", name, "--json")
            for manner in ("good", "plain", "whole", *(("capped",) if size < 10000 else ())):
                with self.subTest(size, manner=manner):
                    address = self.server.address(manner, name)
                    self.assertEqual(self.run_program("info", address, "--json").replace(address, name), expected)
            if size > 10000:
                self.assertIn("the server does not state which bytes it sent",
                              self.run_program("info", self.server.address("capped", name), succeeds=False))

    def test_what_is_secret_in_a_url_is_neither_said_nor_stored(self):
        address = self.server.address("good", "site.laz").replace("://", "://paul:pass0word@") + "?sig=sig0nature"
        public = self.server.address("good", "site.laz")
        for extension in ("alidade", "las"):
            self.run_program("index" if extension == "alidade" else "convert", address, "-o", "secret." + extension)
            with open(os.path.join(self.folder, "secret." + extension), "rb") as file:
                content = file.read()
            self.assertNotIn(b"0word", content)
            self.assertNotIn(b"sig0nature", content)
        self.assertIn(public, self.run_program("info", "secret.alidade", "--json"))
        observer = ("--observer=690000,5325000,640", "--anywhere")
        for words in (("render", address, "--size", "16x16", "--samples", "1", "-o", "secret.png"),
                      ("visibility", "summary", address, *observer, "-o", "secret.json"),
                      ("visibility", "raster", address, *observer, "--resolution", "5", "-o", "secret.tif")):
            self.run_program(*words)
            with open(os.path.join(self.folder, words[-1]), "rb") as file:
                content = file.read()
            self.assertIn(b"site.laz", content, words)
            self.assertNotIn(b"0word", content, words)
            self.assertNotIn(b"sig0nature", content, words)
        message = self.query(address.replace("site.laz", "missing.laz"), succeeds=False)
        self.assertIn("missing.laz: cannot read from the server: HTTP status 404", message)
        self.assertNotIn("0word", message)
        self.assertNotIn("sig0nature", message)

    def test_a_hierarchy_that_loops_is_an_error(self):
        with open(os.path.join(self.folder, "site.copc.laz"), "rb") as file:
            content = bytearray(file.read())
        page, size = struct.unpack_from("<QQ", content, 469)
        struct.pack_into("<Qii", content, page + size - 16, page, size, -1)
        with open(os.path.join(self.folder, "loop.copc.laz"), "wb") as file:
            file.write(content)
        address = self.server.address("good", "loop.copc.laz")
        self.assertIn(f"{address}:byte {page}: page of the COPC hierarchy referenced more than once",
                      self.query(address, succeeds=False))

    def test_a_missing_tile_of_a_catalog_is_an_error(self):
        os.mkdir(os.path.join(self.folder, "tiles"))
        for name in ("a", "b"):
            self.run_program("convert", "site.las", "-o", f"tiles/{name}.copc.laz")
        self.run_program("catalog", "tiles", "-o", "tiles/site.catalog.json")
        os.remove(os.path.join(self.folder, "tiles/b.copc.laz"))
        self.assertIn("tiles/b.copc.laz: cannot read from the server: HTTP status 404",
                      self.query(self.server.address("good", "tiles/site.catalog.json"), succeeds=False))

    def test_a_server_that_is_not_there_is_an_error(self):
        self.assertIn("http://127.0.0.1:9/site.laz", self.query("http://127.0.0.1:9/site.laz", succeeds=False))


if __name__ == "__main__":
    unittest.main()
