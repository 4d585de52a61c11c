#!/usr/bin/env python3
"""fault.named: entries_named.py HEADERS TESTS: every function that the headers declare is called in
one of the tests that let memory run out. Prints the table: function, tests."""

import pathlib
import re
import sys

headers, tests = map(pathlib.Path, sys.argv[1:3])
COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
TYPE = re.compile(r"\btypedef\b[^;{]*;")  # of functions: no entries
ENTRY = re.compile(r"\b(sct_[a-z0-9_]+)\(")

sources = {path.stem: path.read_text() for path in sorted(tests.glob("fault_*.c"))}
missing = 0
for header in sorted(headers.glob("*.h")):
    text = TYPE.sub("", COMMENT.sub("", header.read_text()))
    for name in dict.fromkeys(ENTRY.findall(text)):
        found = [stem for stem, source in sources.items() if re.search(rf"\b{name}\(", source)]
        print(f"{header.name} {name}: {' '.join(found) or 'MISSING'}")
        missing += not found
sys.exit(f"{missing} entries stand in no test of {tests}" if missing else 0)
