#!/usr/bin/env python3
"""Writes a C file that holds documents as the table of document.h, or files as that of asset.h.

    embed.py documents OUTPUT.c DIRECTORY [FILE...]
    embed.py study_documents OUTPUT.c FILE...
    embed.py um_bridge_documents OUTPUT.c FILE...
    embed.py assets OUTPUT.c [DIRECTORY]

The first takes every .json and .html file below DIRECTORY by its path within it, and each FILE by its name.
Of processes.json, shortened lists processes-1.json, processes-2.json, ... are added for
GET /processes?limit=N, so that the daemon need not take JSON apart. The next two take JSON files by
their names without suffix. The last takes the files of the built dashboard, index.html in DIRECTORY
and all in its folder assets, each plain and under gzip; without DIRECTORY, the table is empty.
"""

import gzip
import hashlib
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


TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
}


def asset(path):
    """A row of the table of assets."""
    data = path.read_bytes()
    packed = gzip.compress(data, 9, mtime=0)
    etag = hashlib.sha256(data).hexdigest()[:16]
    return (f'    {{"{path.name}", "{TYPES[path.suffix]}", "\\"{etag}\\"",\n'
            f"    {literal(data)},\n    {len(data)},\n    {literal(packed)},\n    {len(packed)}}},\n")


def asset_table(directories):
    """The C file of the dashboard. Its table has an empty row at the end, as C wants one at least."""
    rows = [asset(path) for directory in directories
            for path in (directory / "index.html", *sorted((directory / "assets").iterdir()))]
    return ('#include "asset.h"\n\nconst asset assets[] = {\n' + "".join(rows) + '    {"", "", "", "", 0, "", 0},\n};\n\n'
            f"const size_t asset_count = {len(rows)};\n")


def main():
    name, out, *files = sys.argv[1:]
    files = [pathlib.Path(file) for file in files]
    if name == "assets":
        pathlib.Path(out).write_text(asset_table(files))
        return
    if name == "documents":
        found = gather(files[0], files[1:])
    else:
        found = {path.stem: minified(path.read_bytes()) for path in files}
    pathlib.Path(out).write_text(table(name, found))


if __name__ == "__main__":
    main()
