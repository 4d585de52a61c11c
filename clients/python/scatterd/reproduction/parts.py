"""What the reproduction is made of: questions to the service, tables, and items of the papers."""

from __future__ import annotations

import csv
import json
import math
import pathlib
from dataclasses import dataclass, field
from typing import Any, Callable, Sequence

from ..client import Client


@dataclass(frozen=True)
class Ask:
    """A question: a study, or what lies behind one of its rows.

    kind: "study" for the study itself, "field" for the result of its first request, "diagnose" for
    what process diagnose says of the cloud of that request.
    """

    case: str
    cells: tuple[int, ...]
    operator: tuple = ()
    parameters: tuple = ()
    kind: str = "study"

    def run(self, client: Client) -> Any:
        """The answer."""
        operator, parameters = dict(self.operator), thawed(self.parameters)
        inputs = (self.case, list(self.cells) or None)
        options = {"operator": operator or None, "parameters": parameters or None}
        if self.kind == "study":
            return client.study(*inputs, **options)
        request = client.study(*inputs, **options, outputs=["requests"]).requests[0]
        if self.kind == "diagnose":
            cloud, used = (request["inputs"][name] for name in ("cloud", "operator"))
            return client.diagnose(cloud, operator=used)
        process = "apply" if "field" in request["inputs"] else "solve"
        return client.post(process, {"inputs": request["inputs"]})


def thawed(pairs: tuple) -> dict:
    return {name: list(value) if isinstance(value, tuple) else value for name, value in pairs}


def ask(case: str, cells: Sequence[int] = (), kind: str = "study", operator: dict | None = None,
        **parameters: Any) -> Ask:
    """A question; equal ones are asked once."""
    frozen = {k: tuple(v) if isinstance(v, (list, tuple)) else v for k, v in parameters.items()}
    return Ask(case, tuple(cells), tuple(sorted((operator or {}).items())),
               tuple(sorted(frozen.items())), kind)


@dataclass
class Table:
    """Numbers with names. `formats` are by column, "%.4g" where there is none."""

    id: str
    title: str
    columns: list[str]
    rows: list[list]
    formats: dict[str, str] = field(default_factory=dict)
    shown: bool = True  #: on the page; else in the files only

    def texts(self) -> list[list[str]]:
        """The cells as they are shown."""
        return [[self.text(name, value) for name, value in zip(self.columns, row)]
                for row in self.rows]

    def text(self, name: str, value: Any) -> str:
        if value is None or isinstance(value, float) and not math.isfinite(value):
            return ""
        if isinstance(value, str):
            return value
        return self.formats.get(name, "%.4g") % value

    def write(self, folder: pathlib.Path) -> None:
        """ID.csv and ID.json."""
        with open(folder / f"{self.id}.csv", "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(self.columns)
            writer.writerows([known(value, "") for value in row] for row in self.rows)
        rows = [dict(zip(self.columns, (known(value, None) for value in row)))
                for row in self.rows]
        text = json.dumps({"title": self.title, "rows": rows}, indent=1, default=float)
        (folder / f"{self.id}.json").write_text(text + "\n", encoding="utf-8")


def known(value: Any, otherwise: Any) -> Any:
    """A value, or `otherwise` where there is none."""
    missing = value is None or isinstance(value, float) and not math.isfinite(value)
    return otherwise if missing else value


@dataclass
class Item:
    """A table or figure of a paper.

    asks: questions by name; tables and draw get their answers by the same names.
    sample: questions whose answers give some rows of every table that the page shows, in a moment:
        the tests ask them to see that the documentation is not stale. None if it shows no table.
    """

    id: str
    title: str
    text: str
    asks: dict[str, Ask]
    tables: Callable[[dict], list[Table]]
    draw: Callable[[Any, dict], None] | None = None
    size: tuple[float, float] = (9.0, 4.2)
    sample: dict[str, Ask] | None = None


def quick(*arguments: Any, **more: Any) -> Item:
    """An item that takes a moment: the sample is all of it."""
    item = Item(*arguments, **more)
    item.sample = item.asks
    return item
