# SPDX-License-Identifier: MIT
"""remote_test.py PROGRAM: clouds on HTTP servers and in archives answer as those on the disk."""

import gzip
import json
import os
import subprocess
import sys
import tempfile
import unittest
import zipfile

import country
import range_server

PROGRAM = ""


class RemoteTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder_object = tempfile.TemporaryDirectory()
        cls.folder = cls.folder_object.name
        cls.run_program("generate", "courtyard", "--points", "300000", "-o", "site.las")
        for name in ("site.laz", "site.copc.laz"):
            cls.run_program("convert", "site.las", "-o", name)
        cls.run_program("index", "site.las", "-o", "site.alidade")
        with zipfile.ZipFile(os.path.join(cls.folder, "site.zip"), "w") as archive:
            archive.write(os.path.join(cls.folder, "site.las"), "tiles/site.las")
        cls.server = range_server.RangeServer(cls.folder)

    @classmethod
    def tearDownClass(cls):
        cls.server.shutdown()
        cls.folder_object.cleanup()

    @classmethod
    def run_program(cls, *words, succeeds=True):
        environment = dict(os.environ, GDAL_HTTP_RETRY_DELAY="0.05")
        done = subprocess.run([PROGRAM, *words, "-q"], cwd=cls.folder, capture_output=True, text=True, timeout=120,
                              check=False, env=environment)
        if succeeds:
            assert done.returncode == 0, done.stderr
            return done.stdout
        assert done.returncode == 2, (done.returncode, done.stderr)
        return done.stderr

    def query(self, cloud, succeeds=True):
        return self.run_program("query", cloud, "--ray", "690000,5325000,640,0,0,-1", "--radius", "0.5", "--k", "4",
                                "--format", "csv", succeeds=succeeds)

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
        for href in ("../site.las", "/etc/passwd", "http://127.0.0.1:9/site.las", "file:///etc/passwd", "https:x.las"):
            with self.subTest(href):
                with open(os.path.join(self.folder, "bad.catalog.json"), "w", encoding="utf-8") as file:
                    json.dump({"type": "FeatureCollection", "features": [{"assets": {"data": {"href": href}}}]}, file)
                message = self.query(self.server.address("good", "bad.catalog.json"), succeeds=False)
                self.assertIn("bad.catalog.json:item 1: the href le", message)
                os.remove(os.path.join(self.folder, "bad.catalog.json"))

    def test_archives_are_read_in_place(self):
        self.assertEqual(self.query("/vsizip/site.zip/tiles/site.las"), self.query("site.las"))

    def test_a_server_that_is_busy_is_asked_again(self):
        self.assertEqual(self.query(self.server.address("busy", "site.laz")), self.query("site.laz"))

    def test_bad_servers_are_errors_that_name_the_file(self):
        for manner, name in (("good", "missing.laz"), ("short", "site.laz"), ("broken", "site.laz")):
            with self.subTest(manner):
                address = self.server.address(manner, name)
                self.assertIn(address, self.query(address, succeeds=False))

    def test_a_server_without_ranges_gives_the_same_or_an_error(self):
        address = self.server.address("plain", "site.laz")
        done = subprocess.run([PROGRAM, "query", address, "--ray", "690000,5325000,640,0,0,-1", "--radius", "0.5",
                               "--k", "4", "--format", "csv", "-q"], cwd=self.folder, capture_output=True, text=True,
                              timeout=120, check=False)
        if done.returncode == 0:
            self.assertEqual(done.stdout, self.query("site.laz"))
        else:
            self.assertIn(address, done.stderr)

    def test_a_server_that_is_not_there_is_an_error(self):
        self.assertIn("http://127.0.0.1:9/site.laz", self.query("http://127.0.0.1:9/site.laz", succeeds=False))


if __name__ == "__main__":
    PROGRAM = os.path.abspath(sys.argv.pop(1))
    unittest.main()
