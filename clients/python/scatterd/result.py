"""Results: outputs by name, as items or as attributes, arrays as numpy."""

from __future__ import annotations

from typing import Any

from .wire import to_numpy


class Record(dict):
    """An object of a result: record["l2"] and record.l2 are the same.

    A member wins over a method of the same name: `values` of the process echo is its output.
    """

    def __getattribute__(self, name: str) -> Any:
        if not name.startswith("_") and name in self:
            return self[name]
        return super().__getattribute__(name)

    def __getattr__(self, name: str) -> Any:
        known = ", ".join(self) or "nothing"
        raise AttributeError(f"there is no {name!r} here, only {known}")

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self]


def record(value: Any) -> Any:
    """A value with its objects as records, at every depth."""
    if isinstance(value, dict):
        return Record((key, record(member)) for key, member in value.items())
    if isinstance(value, list):
        return [record(item) for item in value]
    return value


class Result(Record):
    """Outputs of a process by name.

    `result.solution` is an array [n], `result.norms.l2` a number; `result.plot()` draws the result.
    `request_inputs` holds what was asked, for plots.
    """

    request_inputs: dict

    def __init__(self, document: dict, inputs: dict | None = None):
        outputs = {name: to_numpy(bare(value)) for name, value in document.items()}
        super().__init__(record(outputs))
        object.__setattr__(self, "request_inputs", inputs or {})

    def save(self, file: str, output: str | None = None) -> None:
        """Writes the result as a file: .vtp for ParaView and .csv (points and what has a value at
        them), .npz (all arrays), .json (everything).

        Args:
            file: its name; the ending tells the form.
            output: this output only; .npy needs it.
        """
        from .saving import save

        save(self, file, output)

    def __repr__(self) -> str:
        return f"<Result {', '.join(brief(name, value) for name, value in self.items())}>"

    def plot(self, field: Any = None, **options: Any) -> Any:
        """Draws a field on its cloud and returns the axes: `scatterd.plot(self, field, ...)`."""
        from .plotting import plot  # which needs this module

        return plot(self, field, **options)


def bare(value: Any) -> Any:
    """An object output stands under "value" in a result document."""
    return value["value"] if isinstance(value, dict) and set(value) == {"value"} else value


def brief(name: str, value: Any) -> str:
    shape = getattr(value, "shape", None)
    return name if shape is None else f"{name}[{']['.join(map(str, shape))}]"
