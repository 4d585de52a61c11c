#!/usr/bin/env python3
"""http.reproduction: the tables of clients/python/reproduction.md are what the service gives, and the
command that makes them writes what it says. Of every table some rows are made anew, the costly rest
by the command only; numbers are compared to the digits printed, so that a compiler or a BLAS may
round as it likes."""

import csv
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path[:0] = [str(ROOT / "clients/python"), str(ROOT / "tests/http")]
from daemon import Daemon  # noqa: E402  (found by the line above)
from scatterd import Client  # noqa: E402
from scatterd.reproduction import ITEMS, page, run  # noqa: E402

TEXT = (ROOT / "clients/python/reproduction.md").read_text(encoding="utf-8")
HOW = "make it anew: scatterd-client reproduce --output FOLDER, and copy its reproduction.md"
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
LAST_PLACES = 2  # what machines may differ by: units of the last place printed
ROUNDING = 2e-14  # of a solution of size one
KEYS = {"h16-three-point": 2, "h16-statements": 1, "h16-time-statements": 1, "h11-figure-8": 2}


def setUpModule():
    global url
    daemon = Daemon(stub=False)
    unittest.addModuleCleanup(daemon.stop)
    daemon.wait_ready()
    url = f"http://{daemon.address}"


def documented():
    """Tables of the documentation by id: lists of lines of cells, the heading first."""
    found = {}
    for id, lines in re.findall(r"<!-- (\S+) -->\n((?:\|.*\n?)+)", TEXT):
        rows = [re.split(r"(?<!\\)\|", line)[1:-1] for line in lines.strip().split("\n")]
        cells = [[cell.strip().replace("\\|", "|") for cell in row] for row in rows]
        found[id] = [cells[0], *cells[2:]]
    return found


def last_place(text):
    """What a unit of the last digit of a number stands for."""
    mantissa, _, power = text.partition("e")
    return 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2]))


def agree(old, new):
    """Whether two cells say the same: words alike, numbers alike to the digits printed."""
    if NUMBER.sub("#", old) != NUMBER.sub("#", new):
        return False
    return all(abs(float(a) - float(b)) <= LAST_PLACES * max(last_place(a), last_place(b)) + ROUNDING
               for a, b in zip(NUMBER.findall(old), NUMBER.findall(new)))


def keys(id, columns):
    """How many columns name a row: those before the first with results, mesh, alpha, scheme ..."""
    return KEYS.get(id, 2 if columns[0] in ("alpha", "n_C") else 1)


def stale(old, columns, rows, id):
    """What a table of the documentation says otherwise than these rows of it, found anew."""
    if old[0] != columns:
        return [f"columns {old[0]}, now {columns}"]
    key = keys(id, columns)
    lines = {tuple(row[:key]): row for row in old[1:]}
    wrong = [f"no row {row[:key]}" for row in rows if tuple(row[:key]) not in lines]
    for row in rows:
        wrong += [f"{row[:key]}, {name}: {a}, now {b}"
                  for name, a, b in zip(columns, lines.get(tuple(row[:key]), row), row)
                  if not agree(a, b)]
    return wrong


class Documentation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with Client(url, timeout=240) as client:
            made = run.sampled(client, ITEMS)
        cls.found = [table for table in made if table.shown]
        cls.old = documented()

    def test_no_table_is_stale(self):
        for table in self.found:
            with self.subTest(table.id):
                self.assertGreater(len(table.rows), 0)
                wrong = stale(self.old[table.id], table.columns, table.texts(), table.id)
                self.assertEqual(wrong, [], HOW)

    def test_every_table_is_sampled(self):
        self.assertEqual({table.id for table in self.found} | {"misprints"}, set(self.old))
        self.assertGreaterEqual(len(self.found), 16)

    def test_a_changed_digit_is_seen(self):
        """Each number of each sampled row, changed by three units of its last place or by one per
        cent, makes the table stale."""
        changed = 0
        for table in self.found:
            rows, key = table.texts(), keys(table.id, table.columns)
            for k, row in enumerate(rows):
                for c in range(key, len(row)):
                    for number in NUMBER.finditer(row[c]):
                        step = max((LAST_PLACES + 1.5) * last_place(number[0]),
                                   0.01 * abs(float(number[0])))
                        if step < 10 * ROUNDING:
                            continue  # the errors of Table 2's center column are rounding
                        other = f"{float(number[0]) + step:.15e}"
                        cell = row[c][:number.start()] + other + row[c][number.end():]
                        lines = [*rows[:k], [*row[:c], cell, *row[c + 1:]], *rows[k + 1:]]
                        wrong = stale([table.columns, *lines], table.columns, rows, table.id)
                        self.assertEqual(len(wrong), 1, f"{table.id} {row[c]} {other}")
                        changed += 1
        self.assertGreater(changed, 500)

    def test_misprints_are_those_of_the_source(self):
        table = page.misprints()
        self.assertEqual(self.old["misprints"], [table.columns, *table.texts()])

    def test_words_are_those_of_the_source(self):
        titles = [item.title for item in ITEMS if item.sample is not None]
        self.assertEqual(re.findall(r"(?m)^### (.*)$", TEXT), titles, HOW)
        for item in ITEMS:
            if item.sample is not None:
                self.assertIn(item.text, TEXT, HOW)
        self.assertIn(page.ABOUT, TEXT)


class Command(unittest.TestCase):
    def reproduce(self, *arguments):
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "clients/python")}
        return subprocess.run(
            [sys.executable, "-B", "-m", "scatterd", "reproduce", "--url", url, *arguments],
            env=environment, capture_output=True, text=True, check=False)

    def test_files(self):
        with tempfile.TemporaryDirectory() as name:
            done = self.reproduce("--output", name, "--only", "h16-t", "--only", "h16-three-point")
            self.assertEqual(done.returncode, 0, done.stderr)
            folder = pathlib.Path(name)
            self.assertEqual(done.stdout.strip(), str(folder / "index.html"))
            self.assertIn(" 100% ", done.stderr)
            with open(folder / "tables/h16-three-point.csv", encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
            kept = json.loads((folder / "tables/h16-three-point.json").read_text())["rows"]
            self.assertEqual(len(rows), len(kept))
            self.assertEqual(float(rows[3]["IPS"]), kept[3]["IPS"])
            picture = (folder / "figures/h16-three-point.png").read_bytes()
            self.assertEqual(picture[:4], b"\x89PNG")
            html = (folder / "index.html").read_text(encoding="utf-8")
            self.assertIn('src="figures/h16-three-point.png"', html)
            self.assertIn("0.939250", html)
            self.assertIn("0.939250", (folder / "reproduction.md").read_text(encoding="utf-8"))

    def test_pictures_of_fields(self):
        for only in ("h11-figure-5", "h11-figure-6", "h16-figure-2", "h16-figure-11"):
            with self.subTest(only), tempfile.TemporaryDirectory() as folder:
                done = self.reproduce("--output", folder, "--only", only)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertTrue(pathlib.Path(folder, f"figures/{only}.png").exists())

    def test_what_there_is_not(self):
        done = self.reproduce("--output", "/nowhere", "--only", "h17")
        self.assertEqual(done.returncode, 1)
        self.assertIn("h16-three-point", done.stderr)


if __name__ == "__main__":
    unittest.main()
