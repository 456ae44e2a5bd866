# SPDX-License-Identifier: MIT
"""degenerate_test.py PROGRAM: every command ends on clouds of equal points and of invalid zeros, and stops when it is told to.

How long both take is measured by tests/bench/degenerate.py; here a command that looks at each of many equal points for each of them
runs out of its processor time."""

import os
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "bench"))
import degenerate

PROGRAM = os.path.abspath(sys.argv.pop(1))
MOST_PROCESSOR_SECONDS = 60
MOST_SECONDS_TO_STOP = 5.0  # of a busy machine; a second otherwise


class DegenerateTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder_object = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.folder_object.name)

    @classmethod
    def tearDownClass(cls):
        cls.folder_object.cleanup()

    @staticmethod
    def start(words, folder):
        limit = lambda: resource.setrlimit(resource.RLIMIT_CPU, (MOST_PROCESSOR_SECONDS, MOST_PROCESSOR_SECONDS + 5))
        return subprocess.Popen([PROGRAM, *words, "-q"], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, preexec_fn=limit)

    @staticmethod
    def stop(process, number):
        """Sends a signal once the program handles it; seconds to its end, and what it said."""
        while process.poll() is None:
            with open(f"/proc/{process.pid}/status", encoding="ascii") as status:
                caught = next((int(line.split()[1], 16) for line in status if line.startswith("SigCgt")), 0)
            if caught >> (number - 1) & 1:
                break
            time.sleep(0.01)
        process.send_signal(number)
        sent = time.monotonic()
        _, said = process.communicate()
        return time.monotonic() - sent, said

    def test_every_command_ends_on_degenerate_clouds(self):
        for cloud, folder in degenerate.make_clouds(PROGRAM, self.folder, ("equal", "two", "zeros", "far_zeros"), 4000).items():
            for name, words in degenerate.commands(degenerate.EYES[cloud]).items():
                with self.subTest(cloud=cloud, command=name):
                    degenerate.clear(folder)
                    with self.start(words, folder) as process:
                        _, said = process.communicate()
                    self.assertIn(process.returncode, (0, 1, 2), said)

    def test_every_command_stops_soon_when_it_is_interrupted(self):
        """Also between reading and writing, where most time goes."""
        for cloud, folder in degenerate.make_clouds(PROGRAM, self.folder, ("zeros",), 300000).items():
            for number, (name, words) in enumerate(degenerate.commands(degenerate.EYES[cloud]).items()):
                with self.subTest(command=name):
                    degenerate.clear(folder)
                    with self.start(words, folder) as process:
                        time.sleep(0.4 + 0.1 * (number % 5))
                        taken, said = self.stop(process, signal.SIGINT if number % 2 == 0 else signal.SIGTERM)
                    self.assertLess(taken, MOST_SECONDS_TO_STOP)
                    if process.returncode not in (0, 1):
                        self.assertEqual((process.returncode, said), (130, b"alidade: error: interrupted\n"))
                        self.assertEqual([path.name for path in folder.glob(".*")], [])

    def test_one_long_evaluation_of_a_condition_stops_soon(self):
        folder = degenerate.make_clouds(PROGRAM, self.folder, ("equal",), 8000)["equal"]
        endless = "(WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) SELECT max(i) FROM n) > x"
        for words in (("query", "cloud.las", "--point", "1,2,3", "--k", "1", "--where", endless),
                      ("convert", "cloud.las", "-o", "out.las", "--where", endless),
                      ("sql", "cloud.las", "SELECT id FROM points WHERE " + endless)):
            for number in (signal.SIGINT, signal.SIGTERM):
                with self.subTest(command=words[0], signal=number):
                    with self.start(words, folder) as process:
                        time.sleep(0.7)
                        taken, said = self.stop(process, number)
                    self.assertLess(taken, MOST_SECONDS_TO_STOP)
                    self.assertEqual((process.returncode, said), (130, b"alidade: error: interrupted\n"))


if __name__ == "__main__":
    unittest.main()
