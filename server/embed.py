#!/usr/bin/env python3
"""Writes a C file that holds documents as the table of document.h.

    embed.py documents OUTPUT.c DIRECTORY [FILE...]
    embed.py study_documents OUTPUT.c FILE...
    embed.py um_bridge_documents OUTPUT.c FILE...

The first takes every .json and .html file below DIRECTORY by its path within it, and each FILE by its name.
Of processes.json, shortened lists processes-1.json, processes-2.json, ... are added for
GET /processes?limit=N, so that the daemon need not take JSON apart. The others take JSON files by
their names without suffix.
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


def minified(text):
    return json.dumps(json.loads(text), separators=(",", ":")).encode()


def literal(data):
    """A C string literal. Octal escapes, always of three digits, swallow nothing that follows."""
    special = {ord('"'): '\\"', ord("\\"): "\\\\", ord("?"): "\\?"}
    lines = []
    for start in range(0, len(data), 80):
        part = data[start:start + 80]
        lines.append('"' + "".join(
            special.get(b) or (chr(b) if 32 <= b < 127 else f"\\{b:03o}") for b in part) + '"')
    return "\n    ".join(lines) or '""'


def table(name, found):
    """The C file: a table `name` of documents, and how many there are."""
    rows = [f'    {{"{key}",\n    {literal(data)},\n    {len(data)}}},\n'
            for key, data in sorted(found.items())]
    count = f"{name.removesuffix('s')}_count"
    return (f'#include "document.h"\n\nconst document {name}[] = {{\n' + "".join(rows) +
            f"}};\n\nconst size_t {count} = sizeof {name} / sizeof *{name};\n")


def main():
    name, out, *files = sys.argv[1:]
    files = [pathlib.Path(file) for file in files]
    if name == "documents":
        found = gather(files[0], files[1:])
    else:
        found = {path.stem: minified(path.read_bytes()) for path in files}
    pathlib.Path(out).write_text(table(name, found))


if __name__ == "__main__":
    main()
