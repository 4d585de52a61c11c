"""Makes seeds for fuzz targets: make_seeds.py SCHEMAS FOLDER fills FOLDER/TARGET.

answer      every example of schemas/examples, as JSON and as CBOR where the client can write it, in
            turn with every work and every wish; UM-Bridge requests
expression  every text in them that could be an expression
header      fields and queries of clients, one a file
http        whole requests: a line per route and field, and examples as bodies
render      results of every process
frames      what a worker says of a request it checked

Beside them FOLDER/TARGET.dict, words for those whose inputs are text.
"""

import itertools
import json
import pathlib
import random
import re
import struct
import sys

PROCESSES = "solve apply diagnose study flow echo batch".split()
BRIDGE = {"h": "Evaluate", "i": "Gradient", "j": "ApplyJacobian", "k": "InputSizes"}

FIELDS = [
    "respond-async", "respond-async, wait=10", "return=minimal; foo=\"a,b\", priority=9", "wait=1e9",
    "wait=\"5\", wait=7", "bytes=0-", "bytes=0-99", "bytes=-500", "bytes=10-5", "bytes=0-1,3-4",
    "bytes=18446744073709551615-18446744073709551616", "bytes=-0", "items=1-2",
    "application/json", "*/*;q=0.1, application/cbor;q=0.9", "text/*, multipart/related;q=0.123",
    "application/json;q=0, */*", "application/x-npy;v=\"1;2,\\\"3\"", "model/vnd.vtk", ",, ,",
    "gzip, zstd;q=0.5, identity;q=0", "*;q=0", "x-gzip", "gzip, gzip", "text/csv; charset=utf-8",
    "application/json; charset=latin1", "2026-11-22T17:50:09.5Z", "2026-11-22T18:50:09+01:00/..",
    "../2026-11-22", "2026-11-22/2026-11-21", "/", "2026-02-30t23:59:60-23:59", "localhost:8480",
    "[::1]:80", "127.0.0.1", "a b", "[::1", "/jobs?limit=5&status=running,failed",
    "http://h/%41?x=%zz", "/a%00", "*", "/%e2%82%ac", "https://h", "id-1_2.3",
]

QUERIES = ["limit=3&offset=2", "type=process,process", "processID=solve,echo", "status=accepted",
           "datetime=2026-11-22T00:00:00Z/..", "minDuration=1&maxDuration=5", "parent=x",
           "limit=0", "status=&&=&limit", "limit=%31", "offset=99999999999999999999"]

PATHS = ["/", "/assets/index.html", "/api", "/conformance", "/processes", "/processes?limit=2",
         "/processes/solve", "/jobs", "/jobs/JOB", "/jobs/JOB/events", "/jobs/JOB/results",
         "/jobs/JOB/results/message", "/jobs/1", "/Info", "/data/1", "/healthz", "/readyz", "/metrics"]

HEADERS = ["", "Accept: text/html", "Accept: application/json", "Accept: image/png",
           "Accept-Encoding: gzip, zstd", "Range: bytes=0-9", "Prefer: respond-async, wait=1",
           "If-None-Match: *", "Connection: close", "Origin: http://a", "X-Request-Id: a b",
           "Last-Event-ID: 5", "Expect: 100-continue"]


WORDS = """GET HEAD POST DELETE OPTIONS HTTP/1.0 Host Accept-Encoding Content-Type Content-Encoding
    Content-Length Transfer-Encoding chunked Prefer respond-async wait= return=minimal priority= Range
    bytes= If-Range If-None-Match If-Match Idempotency-Key Cache-Control no-cache Origin Connection
    close keep-alive Last-Event-ID Authorization Basic Bearer limit= offset= status= processID=
    datetime= minDuration= maxDuration= type= parent= successful running accepted failed dismissed
    execution results events jobs processes data charset=utf-8 header=present identity gzip zstd
    multipart/related application/x-npy text/csv application/cbor application/json ;q=0.5 */*
    2026-11-22T17:50:09Z""".split()


def write(folder, name, content):
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())


def texts(node):
    if isinstance(node, str):
        yield node
    elif isinstance(node, (dict, list)):
        for inner in node.values() if isinstance(node, dict) else node:
            yield from texts(inner)


def cbor(node):
    """The document as CBOR, of definite lengths and doubles."""
    def head(major, value):
        for code, form, most in ((24, ">B", 1 << 8), (25, ">H", 1 << 16), (26, ">I", 1 << 32)):
            if value < 24:
                return bytes([major << 5 | value])
            if value < most:
                return bytes([major << 5 | code]) + struct.pack(form, value)
        return bytes([major << 5 | 27]) + struct.pack(">Q", value)
    if node is None or isinstance(node, bool):
        return {None: b"\xf6", True: b"\xf5", False: b"\xf4"}[node]
    if isinstance(node, str):
        text = node.encode("utf-8", "replace")
        return head(3, len(text)) + text
    if isinstance(node, dict):
        return head(5, len(node)) + b"".join(cbor(k) + cbor(v) for k, v in node.items())
    if isinstance(node, list):
        if len(node) > 2 and all(type(value) is float for value in node):
            data = struct.pack(f"<{len(node)}d", *node)
            return b"\xd8\x56" + head(2, len(data)) + data
        return head(4, len(node)) + b"".join(map(cbor, node))
    if isinstance(node, int) and abs(node) < 1 << 63:
        return head(0, node) if node >= 0 else head(1, -1 - node)
    return b"\xfb" + struct.pack(">d", float(node))


def answers(examples, folder):
    turn = itertools.cycle(itertools.product("acd", "abcdefg"))
    for path in examples:
        body, letter = path.read_bytes(), "abcdefg"[PROCESSES.index(path.name.split(".")[0])]
        work, wish = next(turn)
        write(folder, path.stem, f"{letter}a{work}{wish}\n".encode() + body)
        try:
            packed = cbor(json.loads(body))
        except ValueError:
            continue
        work, wish = next(turn)
        write(folder, path.stem + ".cbor", f"{letter}b{work}{wish}\n".encode() + packed)
    write(folder, "data.csv", b"leaa\nx,y\n1,2\n3,4\n")
    write(folder, "data.npy", b"lfaa\n\x93NUMPY\x01\x00v\x00" +
          b"{'descr': '<f8', 'fortran_order': False, 'shape': (1,), }".ljust(117) + b"\n" + bytes(8))


def bridges(schemas, folder):
    """Requests about the default model, on fewer points."""
    config = json.loads((schemas / "um-bridge/default.json").read_text())
    config["cloud"]["lattice"]["cells"] = [6, 6]
    for letter, operation in BRIDGE.items():
        for number, given in enumerate(({}, config)):
            body = {"name": "solve", "input": [[0, 1], [1, 0.5]], "config": given}
            if letter in "ij":
                body |= {"inWrt": 0, "outWrt": 0, "sens": [1.0], "vec": [1.0]}
            write(folder, f"bridge-{operation}-{number}", f"{letter}aaa\n{json.dumps(body)}")


def expressions(examples, folder):
    found = set()
    for path in examples:
        try:
            found |= set(texts(json.loads(path.read_bytes())))
        except ValueError:
            pass
    more = ["x>0 ? 1 : -1", "min(x,y,z)", "a*exp(-k*t)^2", "1e-3*.5e+2", "x==y && x<=1 || !z",
            "tgamma(a)/lgamma(x)", "((x))", "x^y^2", "-x^2", "hypot(x,fmod(y,0.5))", "_pi", "1,2",
            "x=1", "sin", "sin()", "atan2(y,x)*copysign(1,a)"]
    wanted = [text for text in sorted(found) if re.search(r"[-+*/^(]|^[xyzt]$", text)] + more
    for number, text in enumerate(wanted):
        write(folder, f"{number:03}", chr(number % 3) + text)


def headers(folder):
    for number, text in enumerate(FIELDS + QUERIES):
        write(folder, f"{number:02}", text)


def request(method, target, fields, body=None):
    lines = [f"{method} {target} HTTP/1.1", "Host: here", *filter(None, fields)]
    if body is not None:
        lines.append(f"Content-Length: {len(body)}")
    return "\r\n".join(lines).encode() + b"\r\n\r\n" + (body or b"")


def requests(examples, folder):
    turn = itertools.cycle(HEADERS)
    targets = PATHS + ["/jobs?" + query for query in QUERIES]
    for number, target in enumerate(targets):
        for method in ("GET", "HEAD", "DELETE", "OPTIONS"):
            write(folder, f"{method}-{number:02}", request(method, target, [next(turn)]))
    for path in examples[::6]:
        target = f"/processes/{path.name.split('.')[0]}/execution"
        fields = ["Content-Type: application/json", next(turn)]
        write(folder, path.stem, request("POST", target, fields, path.read_bytes()))
    for operation in BRIDGE.values():
        write(folder, operation, request("POST", f"/{operation}", [], b'{"name":"solve"}'))
    write(folder, "data", request("POST", "/data", ["Content-Type: text/csv"], b"1,2\n3,4\n"))
    chunked = b"4\r\n{\"in\r\n9\r\nputs\":{}}\r\n0\r\n\r\n"
    write(folder, "chunked", request("POST", "/processes/echo/execution",
                                     ["Transfer-Encoding: chunked"]) + chunked)
    write(folder, "two", request("GET", "/jobs", []) + request("GET", "/api", ["Range: bytes=1-"]))


def results(folder):
    source = random.Random(1)
    for process, number in itertools.product(range(6), range(9)):
        shape = bytes([number, process, number % 2, 1 + number, number % 3, 255, 255])
        write(folder, f"{PROCESSES[process]}-{number}", shape + source.randbytes(60 * number))


def frames(folder):
    def frame(kind, data, process=b""):
        return struct.pack("<i64s4xqqq", kind, process, len(data), 7, 1000) + data
    uri, child = b"http://h/ok", b"\xa0"
    href, data = b"https://h/x.csv", b"/data/" + b"0" * 64
    write(folder, "none", b"\0")
    write(folder, "subscriber", frame(0, uri) + frame(1, uri) + frame(2, uri))
    write(folder, "references", frame(3, href) + frame(3, data))
    write(folder, "batch", frame(4, child, b"solve") * 5)


def keys(node):
    if isinstance(node, dict):
        yield from node
    if isinstance(node, (dict, list)):
        for inner in node.values() if isinstance(node, dict) else node:
            yield from keys(inner)


def dictionary(path, words):
    """Words as libFuzzer and AFL++ read them."""
    escaped = ("".join(c if c.isalnum() else f"\\x{ord(c):02x}" for c in word) for word in words)
    path.write_text("".join(f'"{word}"\n' for word in escaped))


def dictionaries(examples, folder):
    names = set()
    for path in examples:
        try:
            document = json.loads(path.read_bytes())
        except ValueError:
            continue
        names |= {word for word in itertools.chain(keys(document), texts(document))
                  if 1 < len(word) <= 24 and word.isascii() and word.isprintable()}
    names = sorted(names)
    dictionary(folder / "answer.dict", names)
    dictionary(folder / "header.dict", WORDS)
    dictionary(folder / "http.dict", WORDS + names)
    functions = "sin atan2 exp log1p sqrt pow min max hypot gamma step sign pi ? : && || == 1e-3"
    dictionary(folder / "expression.dict", functions.split() + ["x", "y", "z", "t", "a", "k"])


def main():
    schemas, folder = map(pathlib.Path, sys.argv[1:])
    examples = sorted((schemas / "examples").glob("*.json"))
    answers(examples, folder / "answer")
    bridges(schemas, folder / "answer")
    expressions(examples, folder / "expression")
    headers(folder / "header")
    requests(examples, folder / "http")
    results(folder / "render")
    frames(folder / "frames")
    dictionaries(examples, folder)


if __name__ == "__main__":
    main()
