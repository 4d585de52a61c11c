"""Documents to bytes and back: CBOR where cbor2 is installed, else JSON. The only door to cbor2."""

from __future__ import annotations

import gzip
import json
from typing import Any

import numpy

from . import typed_array

try:
    import cbor2
except ImportError:
    cbor2 = None

JSON = "application/json"
CBOR = "application/cbor"
PROBLEM = "application/problem+json"
GZIP_FROM = 64 * 1024  #: bytes of JSON from which compression pays, even next door


def best_format() -> str:
    """"cbor" if cbor2 is installed, else "json"."""
    return "cbor" if cbor2 else "json"


def encode(document: Any, format: str) -> tuple[bytes, dict[str, str]]:
    """Bytes of a request and the header fields that describe them and the answer wanted."""
    if format == "cbor":
        return to_cbor(document), {"Content-Type": CBOR, **accept(format)}
    body = to_json(document)
    headers = {"Content-Type": JSON, **accept(format)}
    if len(body) >= GZIP_FROM:
        body = gzip.compress(body, compresslevel=1)
        headers["Content-Encoding"] = "gzip"
    return body, headers


def accept(format: str) -> dict[str, str]:
    """Header fields that ask for a document in a format."""
    if format == "cbor":
        return {"Accept": f"{CBOR}, {PROBLEM}"}
    return {"Accept": f"{JSON}, {PROBLEM}", "Accept-Encoding": "gzip"}


def decode(body: bytes, content_type: str, coding: str = "") -> Any:
    """The document in an answer; numbers in CBOR arrays come as numpy arrays."""
    if coding == "gzip":
        body = gzip.decompress(body)
    if content_type.partition(";")[0].strip() == CBOR:
        return from_cbor(body)
    return json.loads(body)


def to_json(document: Any) -> bytes:
    text = json.dumps(document, default=plain, ensure_ascii=False, separators=(",", ":"))
    return text.encode("utf-8")


def plain(value: Any) -> Any:
    """What json knows in place of what numpy knows."""
    if isinstance(value, (numpy.ndarray, numpy.generic)):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} cannot be sent: {value!r}")


def to_cbor(document: Any) -> bytes:
    if cbor2 is None:
        raise RuntimeError("format cbor needs the package cbor2 (Debian: python3-cbor2)")
    return cbor2.dumps(document, default=encode_numpy)


def encode_numpy(encoder: Any, value: Any) -> None:
    if isinstance(value, numpy.ndarray) and value.ndim > 0:
        encoder.encode(typed_array.encode(value, cbor2.CBORTag))
    else:
        encoder.encode(plain(value))


def from_cbor(body: bytes) -> Any:
    return cbor2.loads(body, tag_hook=decode_tag)


def decode_tag(_decoder: Any, tag: Any) -> Any:
    array = typed_array.decode(tag.tag, tag.value)
    return tag if array is None else array


def to_numpy(value: Any) -> Any:
    """Lists of numbers, also nested, become arrays; null among them becomes NaN."""
    if isinstance(value, dict):
        return {key: to_numpy(member) for key, member in value.items()}
    if not isinstance(value, list):
        return value
    array = number_array(value)
    return [to_numpy(item) for item in value] if array is None else array


def number_array(items: list) -> numpy.ndarray | None:
    """A list as an array, if it is a rectangular one of numbers."""
    try:
        array = numpy.array(items)
        if array.dtype == object:
            array = numpy.array(items, dtype=float)
    except (ValueError, TypeError):
        return None
    return array if array.dtype.kind in "iuf" else None


