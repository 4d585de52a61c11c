"""Random damage to execute requests, first to what they say, then to the bytes that say it.

    make(seed, 17)                the 17th request of a seed, always the same
    python3 mutation.py SEED 17   its body, to standard output

Requests are the good examples of schemas/examples; JSON and CBOR come from the Python client's
encoder, so that CBOR has typed arrays. Of the requests 60 % are damaged in their structure (half of
these gently), 30 % in their bytes, the rest in both.
"""

import copy
import json
import pathlib
import random
import re
import sys
from collections import namedtuple

import numpy

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "clients/python"))
from scatterd import wire  # noqa: E402  (found by the line above)

Request = namedtuple("Request", "process format body")

NUMBERS = [0, -0.0, 1, -1, 2, 3, 0.5, 1e-9, 5e-324, -1e-300, 1e16, 1e308, -1.7976931348623157e308,
           499, 2**31 - 1, 2**31, -2**31, 2**32, 2**53 + 1, 2**63 - 1, -2**63, 2**64 - 1, 2**64,
           -2**64 - 1, 10**30, float("inf"), float("-inf"), float("nan")]
TEXTS = ["", " ", "x", "x + y*z - t", "1/0", "sqrt(-1)", "x^y^x^y", "((((", ")", "x,y", "sin(",
         "sin()", "if(", "x ? 1 : ", "exp(x)^1e9", "a = 1", "x == y", "1e", "1e999", "_pi",
         "\0", "\"", "\\", "é", "\U0001d54f", "%s%n", "/", "~1", "x" * 300, "-" * 300 + "x",
         "(" * 300 + "x" + ")" * 300, "sin(" * 300 + "x" + ")" * 300]
NAMES = """value boundary interior left right top front dirichlet neumann robin mps ps ips ipsn lsmps
    center rational bell spiky gaussian none exact cosine published local reference kernel kernel/r2
    umfpack klu direct auto forward-euler backward-euler crank-nicolson bdf2 raw document x y z t
    cloud velocity diffusivity source reaction operator solver initial time normal coefficient
    solution norms diagnostics history report gradient laplacian spacing groups normals""".split()
ODD = [None, True, False, [], {}, [[]], [{}], {"": 0}, {"value": {}}, {"href": "/data/1"}, [1], [0, 1],
       [[0, 0], [1, 0], [0, 1], [1, 1]], [[1, 2], [3]], [1, "x"], [[[0.5]]], ["x", "y"], [0] * 400]
JSON_TOKENS = re.compile(rb'"[^"]*"|[-+.\w]+|[\[\]{},:]')
JSON_NUMBERS = [b"-0", b"1e400", b"-1e400", b"1e-400", b"00", b"01", b"1.", b".5", b"+1", b"0x10",
                b"NaN", b"-Infinity", b"1e", b"9" * 400, b"0." + b"0" * 400 + b"1", b"null"]


class Twin(str):
    """A key that is equal to no other, not even of the same letters: members that come twice."""
    __hash__ = object.__hash__

    def __eq__(self, other):
        return self is other


def example(path):
    """(process, document). Without what a mutation makes a time-out: the pause of echo, and the
    number of clouds of a study."""
    document = json.loads(path.read_text(encoding="utf-8"))
    document.get("inputs", {}).pop("pause", None)
    document.get("inputs", {}).get("parameters", {}).pop("seeds", None)
    document.get("outputs", {}).pop("pause", None)
    return path.name.split(".")[0], document


EXAMPLES = [example(path) for path in sorted((ROOT / "schemas/examples").glob("*.ok-*.json"))]


# ---- Structure ----

def places(node):
    """Every (container, key) of a document, from the outside in."""
    keys = node.keys() if isinstance(node, dict) else range(len(node))
    for key in list(keys):
        yield node, key
        if isinstance(node[key], (dict, list)):
            yield from places(node[key])


def odd(source):
    """Any value, often one that is wrong anywhere."""
    kind = source.randrange(4)
    if kind == 3:  # a part of another request
        other = copy.deepcopy(source.choice(EXAMPLES)[1])
        container, key = source.choice(list(places(other)))
        return container[key]
    return copy.deepcopy(source.choice((NUMBERS, TEXTS + NAMES, ODD)[kind]))


def drop(source, container, key):
    del container[key]


def retype(source, container, key):
    container[key] = odd(source)


def twin(source, container, key):
    """Once more the same member, or the same item many times."""
    if isinstance(container, dict):
        container[Twin(key)] = source.choice([container[key], odd(source)])
    else:
        container[key:key] = [container[key]] * source.choice([1, 2, 300])


def nest(source, container, key):
    """Deeper, up to beyond the limit of depth."""
    for _ in range(source.choice([1, 1, 2, 3, 60, 200])):
        container[key] = source.choice([[container[key]], {"value": container[key]}])


def rename(source, container, key):
    if isinstance(container, dict):
        container[source.choice(TEXTS + NAMES)] = container.pop(key)
    else:
        container.reverse()


def extreme(source, container, key):
    """Another number, or another text in place of a text."""
    container[key] = source.choice(TEXTS if isinstance(container[key], str) else NUMBERS)


def nudge(source, container, key):
    """All numbers of a value a little different, some of them much."""
    found = [(container, key)]
    if isinstance(container[key], (dict, list)):
        found = list(places(container[key]))
    for inner, name in found:
        value = inner[name]
        if type(value) in (int, float) and source.random() < 0.5:
            inner[name] = source.choice([value + 1, -value, float(value) * source.uniform(0.5, 1.5),
                                         float(value) * 10.0 ** source.randrange(-9, 10)])


def choose(source, container, key):
    """Another name of those that mean something."""
    if isinstance(container[key], str):
        container[key] = source.choice(NAMES)
    else:
        nudge(source, container, key)


def garble(source, container, key):
    """A text, such as an expression, with something in it, doubled or cut."""
    text = container[key] if isinstance(container[key], str) else "x*y + sin(x)"
    at = source.randrange(len(text) + 1)
    container[key] = source.choice([text[:at] + source.choice(TEXTS) + text[at:], text[at:] + text,
                                    text[:at], text + "," + text, "(" + text + ")^2"])


GENTLE = [nudge, nudge, nudge, choose, drop]  # often still good: these are solved
STRUCTURE = [drop, retype, twin, nest, rename, extreme, garble, choose, nudge]


def damage_structure(source, document, kinds):
    for _ in range(source.choice([1, 1, 1, 2, 3])):
        found = list(places(document))
        if found:
            source.choice(kinds)(source, *source.choice(found))


# ---- Bytes ----

def flip(source, body, at, end):
    body[at] ^= 1 << source.randrange(8)


def overwrite(source, body, at, end):
    body[at] = source.choice([0, 0xFF, 0x7F, 0x80, 0x1B, 0x9F, 0xBF, 0xD8, source.randrange(256)])


def insert(source, body, at, end):
    body[at:at] = source.randbytes(source.choice([1, 1, 2, 9]))


def delete(source, body, at, end):
    del body[at:end]


def duplicate(source, body, at, end):
    body[at:at] = body[at:end]


def truncate(source, body, at, end):
    del body[at:]


def swap_tokens(source, body, at, end):
    tokens = [match.span() for match in JSON_TOKENS.finditer(body)]
    if len(tokens) < 2:
        return
    (a, b), (c, d) = sorted(source.sample(tokens, 2))
    body[a:d] = body[c:d] + body[b:c] + body[a:b]


def replace_number(source, body, at, end):
    numbers = [m.span() for m in JSON_TOKENS.finditer(body) if m.group()[:1] in b"-0123456789"]
    if numbers:
        a, b = source.choice(numbers)
        body[a:b] = source.choice(JSON_NUMBERS)


BYTES = {"cbor": [flip, overwrite, insert, delete, duplicate, truncate],
         "json": [flip, overwrite, insert, delete, duplicate, truncate, swap_tokens,
                  replace_number, replace_number]}


def damage_bytes(source, body, kinds):
    for _ in range(source.choice([1, 1, 1, 2, 4])):
        if not body:
            return
        at = source.randrange(len(body))
        source.choice(kinds)(source, body, at, at + source.randrange(1, 40))


# ---- Requests ----

def typed(source, node):
    """The document with some of its arrays of numbers as numpy arrays, which become typed ones."""
    if isinstance(node, dict):
        return {key: typed(source, value) for key, value in node.items()}
    if not isinstance(node, list) or source.random() < 0.3:
        return node
    array = wire.number_array(node)
    if array is None or array.size == 0:
        return [typed(source, item) for item in node]
    return array.astype(source.choice([array.dtype, "<f8", "<f4", "<i4"]), casting="unsafe")


def encode(source, document, form):
    if form == "json":
        return wire.to_json(document)
    with numpy.errstate(all="ignore"):
        return wire.to_cbor(typed(source, document))


def make(seed, number):
    """The request of this number."""
    source = random.Random(f"{seed}/{number}")
    process, document = copy.deepcopy(source.choice(EXAMPLES))
    form = source.choice(["json", "cbor"])
    what = source.random()
    if what < 0.7:
        damage_structure(source, document, GENTLE if what < 0.3 else STRUCTURE)
    body = bytearray(encode(source, document, form))
    if what > 0.6:
        damage_bytes(source, body, BYTES[form])
    return Request(process, form, bytes(body))


if __name__ == "__main__":
    sys.stdout.buffer.write(make(int(sys.argv[1]), int(sys.argv[2])).body)
