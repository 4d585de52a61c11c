#!/usr/bin/env python3
"""Writes a C file that holds documents as the table of document.h.

    embed.py OUTPUT.c DIRECTORY [FILE...]

takes every .json and .html file below DIRECTORY by its path within it, and each FILE by its name.
Of processes.json, shortened lists processes-1.json, processes-2.json, ... are added for
GET /processes?limit=N, so that the daemon need not take JSON apart.
"""

import json
import pathlib
import sys


def shortened(text):
    """Names and texts of the lists with only the first 1, 2, ... processes."""
    listing = json.loads(text)
    for n in range(1, len(listing["processes"])):
        less = dict(listing, processes=listing["processes"][:n])
        yield f"processes-{n}.json", json.dumps(less, separators=(",", ":")).encode()


def gather(directory, files):
    """All documents, as a dictionary from name to bytes."""
    found = {}
    for path in sorted(directory.rglob("*")):
        if path.suffix in (".json", ".html"):
            found[path.relative_to(directory).as_posix()] = path.read_bytes()
    for path in files:
        found[path.name] = path.read_bytes()
    found.update(shortened(found["processes.json"]))
    return found


def literal(data):
    """A C string literal. Octal escapes, always of three digits, swallow nothing that follows."""
    special = {ord('"'): '\\"', ord("\\"): "\\\\", ord("?"): "\\?"}
    lines = []
    for start in range(0, len(data), 80):
        part = data[start:start + 80]
        lines.append('"' + "".join(
            special.get(b) or (chr(b) if 32 <= b < 127 else f"\\{b:03o}") for b in part) + '"')
    return "\n    ".join(lines) or '""'


def main():
    out, directory, *files = map(pathlib.Path, sys.argv[1:])
    rows = [f'    {{"{name}",\n    {literal(data)},\n    {len(data)}}},\n'
            for name, data in sorted(gather(directory, files).items())]
    out.write_text('#include "document.h"\n\nconst document documents[] = {\n' + "".join(rows) +
                   "};\n\nconst size_t document_count = sizeof documents / sizeof *documents;\n")


if __name__ == "__main__":
    main()
