# SPDX-License-Identifier: MIT
"""What tests of remote files share. A test is called as check_*.py PROGRAM."""

import os
import subprocess
import sys
import tempfile
import unittest
import zipfile

import range_server

PROGRAM = os.path.abspath(sys.argv.pop(1))


class RemoteCase(unittest.TestCase):
    """Files on a server of its own; what is written by programs goes to `folder`."""

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
        cls.server.stop.set()
        cls.server.shutdown()
        cls.server.server_close()
        cls.folder_object.cleanup()

    @classmethod
    def run_program(cls, *words, succeeds=True, settings=None, largest_file=None):
        """`largest_file` is in KiB, as if the disk were full."""
        disk = ("sh", "-c", f"ulimit -f {2 * largest_file}; trap '' XFSZ; exec \"$@\"", "sh") if largest_file else ()
        environment = {**os.environ, "GDAL_HTTP_RETRY_DELAY": "0.02", **(settings or {})}
        done = subprocess.run([*disk, PROGRAM, *words, "-q"], cwd=cls.folder, capture_output=True, text=True, timeout=120,
                              check=False, env=environment)
        if succeeds:
            assert done.returncode == 0, done.stderr
            return done.stdout
        assert done.returncode == 2, (done.returncode, done.stderr)
        return done.stderr

    @staticmethod
    def words(cloud):
        return ("query", cloud, "--ray", "690000,5325000,640,0,0,-1", "--radius", "0.5", "--k", "4", "--format", "csv")

    def query(self, cloud, *words, cache=None, **how):
        return self.run_program(*self.words(cloud), *words, *(("--cache", cache) if cache else ()), **how)
