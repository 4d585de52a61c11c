"""Results as files: .vtp (ParaView), .csv, .npz, .json; one output as .npy."""

from __future__ import annotations

import json
import pathlib
import struct
from typing import TYPE_CHECKING, Any, Callable, Iterator

import numpy

from .plotting import points_of
from .wire import plain

if TYPE_CHECKING:
    from .result import Result

TENSORS = {1: ["xx"], 2: ["xx", "yy", "xy"], 3: ["xx", "yy", "zz", "xy", "xz", "yz"]}
TENSOR = "effective_diffusivity"
PLACES = ("points", "particles")


def save(result: "Result", file: str, output: str | None = None) -> None:
    """Writes a result in the form that the name's ending tells."""
    path = pathlib.Path(file)
    if path.suffix not in WRITERS:
        raise ValueError(f"{file!r}: needs a name in {', '.join(WRITERS)}")
    if output is not None and output not in result:
        raise ValueError(f"there is no output {output!r}, only {', '.join(result)}")
    WRITERS[path.suffix](path, result if output is None else {output: result[output]}, result)


def fields(outputs: dict, count: int) -> Iterator[tuple[str, numpy.ndarray]]:
    """Outputs with a value per point, [n][k] each."""
    for name, value in outputs.items():
        is_field = isinstance(value, numpy.ndarray) and name not in PLACES and len(value) == count
        if is_field and value.dtype.kind in "fiu":
            yield name, value.reshape(count, -1)


def components(name: str, columns: int, dim: int) -> list[str]:
    """What the columns of a field are called."""
    if name == TENSOR:
        return TENSORS[dim]
    if columns == 1:
        return [""]
    return list("xyz"[:dim]) if columns == dim else [str(k) for k in range(columns)]


def coordinates(result: "Result") -> numpy.ndarray:
    points = numpy.asarray(points_of(result), dtype=float)
    return points.reshape(len(points), -1)


def write_csv(path: pathlib.Path, outputs: dict, result: "Result") -> None:
    points = coordinates(result)
    dim = points.shape[1]
    names, columns = list("xyz"[:dim]), [points]
    for name, value in fields(outputs, len(points)):
        parts = components(name, value.shape[1], dim)
        names += [f"{name}_{part}" if part else name for part in parts]
        columns.append(value)
    rows = [",".join(names)]
    rows += [",".join(map(repr, row)) for row in numpy.hstack(columns).tolist()]
    path.write_bytes(("\r\n".join(rows) + "\r\n").encode())


class Appended:
    """Arrays behind the XML of a VTK file, and the elements that announce them."""

    def __init__(self) -> None:
        self.data: list[bytes] = []
        self.size = 0

    def element(self, name: str, array: numpy.ndarray, kind: str) -> str:
        raw = numpy.ascontiguousarray(array, {"Float64": "<f8", "Int32": "<i4"}[kind]).tobytes()
        offset = self.size
        self.data += [struct.pack("<Q", len(raw)), raw]
        self.size += 8 + len(raw)
        width = array.shape[1] if array.ndim == 2 else 1
        return (f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{width}" '
                f'format="appended" offset="{offset}"/>\n')


def three(array: numpy.ndarray) -> numpy.ndarray:
    """Vectors as VTK wants them."""
    return numpy.pad(array.astype(float), ((0, 0), (0, 3 - array.shape[1])))


def write_vtp(path: pathlib.Path, outputs: dict, result: "Result") -> None:
    points = coordinates(result)
    n, dim = points.shape
    arrays = Appended()
    index = numpy.arange(n)
    where = arrays.element("Points", three(points), "Float64")
    verts = arrays.element("connectivity", index, "Int32")
    verts += arrays.element("offsets", index + 1, "Int32")
    data = ""
    for name, value in fields(outputs, n):
        is_vector = name != TENSOR and value.shape[1] == dim > 1
        data += arrays.element(name, three(value) if is_vector else value, "Float64")
    head = (f'<?xml version="1.0"?>\n<VTKFile type="PolyData" version="1.0" '
            f'byte_order="LittleEndian" header_type="UInt64">\n<PolyData>\n'
            f'<Piece NumberOfPoints="{n}" NumberOfVerts="{n}" NumberOfLines="0" '
            f'NumberOfStrips="0" NumberOfPolys="0">\n<Points>\n{where}</Points>\n'
            f"<Verts>\n{verts}</Verts>\n<PointData>\n{data}</PointData>\n</Piece>\n</PolyData>\n"
            f'<AppendedData encoding="raw">\n_')
    with path.open("wb") as file:
        file.write(head.encode())
        file.writelines(arrays.data)
        file.write(b"\n</AppendedData>\n</VTKFile>\n")


def leaves(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Values within a result by dotted name."""
    if not isinstance(value, dict):
        yield name, value
        return
    for key, member in value.items():
        yield from leaves(member, f"{name}.{key}" if name else key)


def write_npz(path: pathlib.Path, outputs: dict, result: "Result") -> None:
    arrays = {key: numpy.asarray(value) for key, value in leaves(outputs)}
    numpy.savez_compressed(path, **arrays)


def write_npy(path: pathlib.Path, outputs: dict, result: "Result") -> None:
    arrays = [value for value in outputs.values() if isinstance(value, numpy.ndarray)]
    if len(outputs) != 1 or len(arrays) != 1:
        raise ValueError(f"{path.name!r} holds one array: name its output")
    numpy.save(path, arrays[0])


def write_json(path: pathlib.Path, outputs: dict, result: "Result") -> None:
    text = json.dumps(dict(outputs), default=plain, ensure_ascii=False)
    path.write_text(text + "\n", encoding="utf-8")


Writer = Callable[[pathlib.Path, dict, "Result"], None]
WRITERS: dict[str, Writer] = {".vtp": write_vtp, ".csv": write_csv, ".npz": write_npz,
                              ".npy": write_npy, ".json": write_json}
