"""Arrays of numbers in CBOR: typed arrays of RFC 8746, numpy on this side."""

from __future__ import annotations

from typing import Any

import numpy

#: tag of RFC 8746 section 2.1 -> type of the numbers in the byte string
TYPES = {
    64: "u1",
    65: ">u2",
    66: ">u4",
    67: ">u8",
    68: "u1",
    69: "<u2",
    70: "<u4",
    71: "<u8",
    72: "i1",
    73: ">i2",
    74: ">i4",
    75: ">i8",
    77: "<i2",
    78: "<i4",
    79: "<i8",
    80: ">f2",
    81: ">f4",
    82: ">f8",
    84: "<f2",
    85: "<f4",
    86: "<f8",
}
ROW_MAJOR = 40
COLUMN_MAJOR = 1040
#: little endian type -> tag; 68 (clamped bytes) is for reading only
TAGS = {numpy.dtype(name): tag for tag, name in TYPES.items() if tag != 68 and name[0] != ">"}


def encode(array: numpy.ndarray, tag: Any) -> Any:
    """The array as a tagged value, made by tag(number, content); a list if numbers have no tag."""
    little = array.astype(array.dtype.newbyteorder("<"), order="C", copy=False)
    number = TAGS.get(little.dtype)
    if number is None:
        return array.tolist()
    flat = tag(number, little.tobytes())
    return flat if array.ndim == 1 else tag(ROW_MAJOR, [list(array.shape), flat])


def decode(number: int, content: Any) -> Any:
    """The array under a tag; None if the tag is none of an array."""
    if number in TYPES:
        array = numpy.frombuffer(content, TYPES[number])
        return array.astype(array.dtype.newbyteorder("="), copy=False)
    if number in (ROW_MAJOR, COLUMN_MAJOR):
        shape, flat = content
        order = "C" if number == ROW_MAJOR else "F"
        return numpy.asarray(flat).reshape(tuple(shape), order=order)
    return None
