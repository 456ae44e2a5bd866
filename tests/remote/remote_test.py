# SPDX-License-Identifier: MIT
"""remote_test.py PROGRAM: clouds on HTTP servers and in archives answer as those on the disk."""

import os
import subprocess
import sys
import tempfile
import unittest
import zipfile

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
