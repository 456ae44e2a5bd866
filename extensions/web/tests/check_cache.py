# SPDX-License-Identifier: MIT
"""check_cache.py PROGRAM: what --cache FOLDER keeps of web servers, and what it leaves alone."""

import os
import subprocess
import unittest

from remote_case import PROGRAM, RemoteCase


class CacheTest(RemoteCase):
    def test_a_cache_saves_all_requests_but_one_of_each_file(self):
        os.mkdir(os.path.join(self.folder, "two"))
        for name in ("a", "b"):
            self.run_program("convert", "site.las", "-o", f"two/{name}.copc.laz")
        self.run_program("catalog", "two", "-o", "two/site.catalog.json")
        for name, files in (("site.las", 1), ("site.copc.laz", 1), ("site.alidade", 1), ("two/site.catalog.json", 3)):
            with self.subTest(name):
                address, expected = self.server.address("good", name), self.query(name)
                for run in range(2):
                    self.server.forget()
                    self.assertEqual(self.query(address, cache="kept/folder"), expected)
                    self.assertEqual(self.server.requests <= files, run == 1)
        self.server.forget()
        self.query(self.server.address("good", "site.las"), settings={"ALIDADE_CACHE": "kept/folder"})
        self.assertEqual(self.server.requests, 1)

    def wholes(self, cache):
        return [path for path in self.blocks(cache) if path.endswith(".whole")]

    def test_a_cache_keeps_index_files_whole(self):
        address, size = self.server.address("good", "site.alidade"), os.path.getsize(os.path.join(self.folder, "site.alidade"))
        expected = self.query("site.alidade")
        self.assertEqual(self.query(address, cache="wholes"), expected)
        (path,) = self.wholes("wholes")
        with open(path, "rb") as kept, open(os.path.join(self.folder, "site.alidade"), "rb") as file:
            self.assertEqual(kept.read()[:size], file.read())
        # One that is damaged or gone is fetched again, and so is another version of the file.
        for damage in (lambda: os.truncate(path, size - 1), lambda: os.remove(path)):
            damage()
            self.server.forget()
            self.assertEqual(self.query(address, cache="wholes"), expected)
            self.assertGreaterEqual(self.server.sent, size)
        for number in range(2):
            self.run_program("generate", "courtyard", "--points", "20000", "--seed", str(number), "-o", "version.las",
                             "--overwrite")
            self.run_program("index", "version.las", "-o", "version.alidade", "--overwrite")
            address = self.server.address("good", "version.alidade")
            self.assertEqual(self.query(address, cache="wholes"), self.query("version.alidade"))

    def test_an_interrupted_fetch_is_continued(self):
        self.run_program("generate", "courtyard", "--points", "1000000", "-o", "long.las")
        self.run_program("index", "long.las", "-o", "long.alidade")
        size, expected = os.path.getsize(os.path.join(self.folder, "long.alidade")), self.query("long.alidade")
        self.assertGreater(size, 20 << 20)
        # The server goes away before it has sent all; its address is that of one that stays.
        self.server.forget()
        self.server.closes_after = 12 << 20
        address = self.server.address("good", "long.alidade")
        self.assertIn("cannot read from the server", self.query(address, cache="continued", succeeds=False))
        self.server.closes_after = None
        self.server.forget()
        self.assertEqual(self.query(address, cache="continued"), expected)
        self.assertLess(self.server.sent, size - (8 << 20) + 100_000)
        self.server.forget()
        self.assertEqual(self.query(address, cache="continued"), expected)
        self.assertEqual(self.server.requests, 1)

    def test_a_cache_keeps_files_of_servers_without_ranges(self):
        address = self.server.address("plain", "site.copc.laz")
        size = os.path.getsize(os.path.join(self.folder, "site.copc.laz"))
        whole = ("query", address, "--box", "-1e9,-1e9,-1e9,1e9,1e9,1e9", "--count", "--cache", "whole")
        self.assertEqual(self.query(address, cache="whole"), self.query("site.copc.laz"))
        self.server.forget()
        self.assertEqual(self.run_program(*whole).splitlines()[-1], "0,300000")
        self.assertEqual((self.server.requests, self.server.sent), (1, 0))
        # What is missing in the cache, and another version, are fetched as a whole.
        for path in self.blocks("whole")[::3]:
            os.remove(path)
        self.assertEqual(self.run_program(*whole).splitlines()[-1], "0,300000")
        self.assertGreater(self.server.sent, 0)
        self.assertLessEqual(self.server.sent, size)
        for number in range(2):
            self.run_program("generate", "courtyard", "--points", "20000", "--seed", str(number), "-o", "old.las",
                             "--overwrite")
            address = self.server.address("plain", "old.las")
            self.assertEqual(self.query(address, cache="whole"), self.query("old.las"))
        # One that the cache is too small for is fetched by each run.
        address, size = self.server.address("plain", "site.las"), os.path.getsize(os.path.join(self.folder, "site.las"))
        self.server.forget()
        for _ in range(2):
            self.assertEqual(self.query(address, "--cache-size", "1M", cache="small-whole"), self.query("site.las"))
        self.assertEqual(self.server.sent, 2 * size)
        # Or of which it would lose a part again; one that just fits stays, whatever else was there.
        for share in (1.0, 1.24, 1.26):
            cache = f"share-{share}"
            self.query(self.server.address("good", "site.alidade"), cache=cache)
            self.server.forget()
            for _ in range(2):
                self.query(address, "--cache-size", str(int(share * size)), cache=cache)
            self.assertEqual((self.server.requests, self.server.sent), (2, (1 if share > 1.25 else 2) * size))

    def test_headers_that_state_another_version_are_not_believed(self):
        size = os.path.getsize(os.path.join(self.folder, "site.laz"))
        for manner in ("plain-length", "plain-tag"):
            with self.subTest(manner):
                self.server.forget()
                for run in range(2):
                    self.assertEqual(self.query(self.server.address(manner, "site.laz"), cache=manner),
                                     self.query("site.laz"))
                self.assertEqual((self.server.requests, self.server.sent), (3, 2 * size))

    def test_sql_uses_the_cache(self):
        self.run_program("catalog", "site.copc.laz", "-o", "sql.catalog.json")
        statement = "SELECT id, dist FROM points(690000,5325000,640, 0,0,-1) ORDER BY dist LIMIT 4"
        expected = self.run_program("sql", "site.copc.laz", statement, "--csv")
        self.assertEqual(expected.count("\n"), 5)
        for run in range(2):
            self.server.forget()
            address = self.server.address("good", "sql.catalog.json")
            self.assertEqual(self.run_program("sql", address, statement, "--csv", "--cache", "sql"), expected)
            self.assertEqual(self.server.requests <= 2, run == 1)

    def blocks(self, cache):
        return [os.path.join(folder, file) for folder, _, files in os.walk(os.path.join(self.folder, cache))
                for file in files if file != "alidade-cache"]

    def test_damaged_blocks_of_a_cache_are_fetched_again(self):
        address, expected = self.server.address("good", "site.laz"), self.query("site.laz")
        self.query(address, cache="damaged")
        blocks = self.blocks("damaged")
        self.assertGreater(len(blocks), 100)
        with open(blocks[0], "rb") as file:
            sound = file.read()
        for number, path in enumerate(blocks):
            with open(path, "rb") as file:
                content = bytearray(file.read())
            if number % 3 == 0:
                content = content[: number % 50]
            elif number % 3 == 1:
                content[100 + number] ^= 1
            else:
                content = sound  # that of another block
            with open(path, "wb") as file:
                file.write(content)
        self.assertEqual(self.query(address, cache="damaged"), expected)
        self.server.forget()
        self.assertEqual(self.query(address, cache="damaged"), expected)
        self.assertEqual(self.server.requests, 1)

    def test_a_cache_forgets_what_changed_on_the_server(self):
        for number in range(2):
            self.run_program("generate", "courtyard", "--points", "20000", "--seed", str(number), "-o", "new.las",
                             "--overwrite")
            self.assertEqual(self.query(self.server.address("good", "new.las"), cache="changed"),
                             self.query("new.las"))

    def test_a_cache_stays_within_its_size(self):
        for name in ("site.laz", "site.copc.laz", "site.alidade"):
            self.assertEqual(self.query(self.server.address("good", name), "--cache-size", "1M", cache="small"),
                             self.query(name))
            self.assertLessEqual(sum(os.path.getsize(path) for path in self.blocks("small")), 1 << 20)

    def test_programs_share_a_cache(self):
        address, expected = self.server.address("slow", "site.laz"), self.query("site.laz")
        programs = [subprocess.Popen([PROGRAM, *self.words(address), "--cache", "shared", "-q"], cwd=self.folder,
                                     stdout=subprocess.PIPE, text=True) for _ in range(3)]
        for program in programs:
            self.assertEqual((program.communicate(timeout=120)[0], program.returncode), (expected, 0))
        self.assertEqual([path for path in self.blocks("shared") if not path.endswith(".block")], [])

    def test_a_cache_that_cannot_be_written_is_an_error(self):
        self.assertIn("site.las/cache: cannot make the folder of the cache: ",
                      self.query(self.server.address("good", "site.las"), cache="site.las/cache", succeeds=False))

    def test_a_cache_removes_nothing_but_its_blocks(self):
        precious = os.path.join(self.folder, "precious")
        os.makedirs(precious)
        names = ("precious.block", "ab/precious.block", "zz/0123456789abcd.block", "ab/0123456789abcd.block",
                 "ab/0123456789ABCD.block", "abc/0123456789abcd.block")

        def write_all(content):
            for name in names:
                os.makedirs(os.path.dirname(os.path.join(precious, name)), exist_ok=True)
                with open(os.path.join(precious, name), "wb") as file:
                    file.write(content)
                os.utime(os.path.join(precious, name), (0, 0))

        write_all(bytes(1 << 19))
        address = self.server.address("good", "site.laz")
        self.assertIn("precious: the folder of the cache holds something else; expected a new or an empty folder",
                      self.query(address, cache="precious", succeeds=False))
        self.query(address, cache="elsewhere")
        with open(self.blocks("elsewhere")[0], "rb") as file:
            block = file.read()
        open(os.path.join(precious, "alidade-cache"), "wb").close()
        # What lies where blocks lie is kept if it is none; elsewhere, even blocks are.
        elsewhere = [name for name in names if name != "ab/0123456789abcd.block"]
        for content in (bytes(1 << 19), block):
            write_all(content)
            os.makedirs(os.path.join(self.folder, "linked"), exist_ok=True)
            with open(os.path.join(self.folder, "linked/0123456789abcd.block"), "wb") as file:
                file.write(block)
            os.utime(os.path.join(self.folder, "linked/0123456789abcd.block"), (0, 0))
            if not os.path.islink(os.path.join(precious, "cd")):
                os.symlink("../linked", os.path.join(precious, "cd"))
            for name in ("site.laz", "site.copc.laz", "site.alidade"):
                self.query(self.server.address("good", name), "--cache-size", "1M", cache="precious")
            left = [name for name in names if os.path.exists(os.path.join(precious, name))]
            self.assertEqual(left, elsewhere if content is block else list(names))
            self.assertTrue(os.path.exists(os.path.join(self.folder, "linked/0123456789abcd.block")))

    def test_a_cache_that_others_may_write_to_is_an_error(self):
        for mode in (0o777, 0o770):
            os.makedirs(os.path.join(self.folder, "open"), exist_ok=True)
            os.chmod(os.path.join(self.folder, "open"), mode)
            self.assertIn("open: other users may write to the folder of the cache",
                          self.query(self.server.address("good", "site.las"), cache="open", succeeds=False))

    def test_a_pipe_in_a_cache_is_no_block(self):
        address, expected = self.server.address("good", "site.laz"), self.query("site.laz")
        self.query(address, cache="pipes")
        for block in self.blocks("pipes"):
            os.remove(block)
            os.mkfifo(block)
        self.assertEqual(self.query(address, cache="pipes"), expected)


if __name__ == "__main__":
    unittest.main()
