#!/usr/bin/env python3
"""http.reproduction: the tables of clients/python/reproduction.md are what the service gives, and the
command that makes them writes what it says. The costly tables are made by the command only; of these
the words are compared."""

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
ROUNDING = 1e-12  # below this, norms are rounding and need not agree
HOW = "make it anew: scatterd-client reproduce --output FOLDER, and copy its reproduction.md"


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


def agree(old, new):
    """Whether two cells say the same: to the last digit but one, and none below rounding."""
    try:
        a, b = float(old), float(new)
    except ValueError:
        return old == new
    return abs(a - b) <= 2e-3 * max(abs(a), abs(b)) or max(abs(a), abs(b)) < ROUNDING


class Documentation(unittest.TestCase):
    def compare(self, table, old):
        self.assertEqual(old[0], table.columns, f"{table.id}: {HOW}")
        new = table.texts()
        self.assertEqual(len(old) - 1, len(new), f"{table.id}: {HOW}")
        for row, line in zip(old[1:], new):
            for name, a, b in zip(table.columns, row, line):
                self.assertTrue(agree(a, b), f"{table.id}, {row[0]}, {name}: {a}, now {b}; {HOW}")

    def test_cheap_tables_are_not_stale(self):
        old = documented()
        with Client(url) as client:
            made = run.tables(client, [item for item in ITEMS if item.cheap])
        shown = [table for table in made if table.shown]
        self.assertGreaterEqual(len(shown), 9)
        for table in shown:
            with self.subTest(table.id):
                self.compare(table, old[table.id])

    def test_misprints_are_those_of_the_source(self):
        table = page.misprints()
        self.assertEqual(documented()["misprints"], [table.columns, *table.texts()])

    def test_words_are_those_of_the_source(self):
        titles = {item.title: item for item in ITEMS}
        headings = re.findall(r"(?m)^### (.*)$", TEXT)
        self.assertGreater(len(headings), 15)
        for title in headings:
            self.assertIn(title, titles, HOW)
            self.assertIn(titles[title].text, TEXT, HOW)
        self.assertIn(page.ABOUT, TEXT)

    def test_every_cheap_item_is_there(self):
        for item in ITEMS:
            if item.cheap:
                self.assertIn(f"### {item.title}\n", TEXT, HOW)


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
            self.assertIn("100%" if "%" in done.stderr else "]", done.stderr)
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
