"""Asks everything, and writes the folder."""

from __future__ import annotations

import pathlib
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import replace
from typing import Any, Callable, Iterable

from ..bar import Bar
from ..client import Client
from . import draw, huang, hwang, page
from .parts import Ask, Item, Table

ITEMS: list[Item] = [*huang.ITEMS, *hwang.ITEMS]
Progress = Callable[[float, str], None]


def reproduce(
    client: Client,
    folder: str | pathlib.Path,
    *,
    items: Iterable[Item] | None = None,
    workers: int = 2,
    progress: Progress | None = None,
) -> pathlib.Path:
    """Makes all tables and figures of both papers.

    Args:
        client: of the service that is asked.
        folder: where to write index.html, reproduction.md, tables/ID.csv, tables/ID.json and
            figures/ID.png.
        items: which tables and figures; by default all (`ITEMS`).
        workers: questions at a time.
        progress: is told which share of the work is done (0 to 1, by a rough measure of the cost),
            and what goes on.

    Returns:
        The page, index.html.
    """
    folder, chosen = pathlib.Path(folder), list(ITEMS if items is None else items)
    for name in ("tables", "figures"):
        (folder / name).mkdir(parents=True, exist_ok=True)
    steps = Steps(sum(map(cost, questions(chosen))) + len(chosen) * DRAWING, progress)
    answers = ask_all(client, chosen, workers, steps)
    made = []
    for item in chosen:
        steps.begin(item.title)
        made.append((item, write_item(item, answers, folder)))
        steps.done(DRAWING)
    (folder / "reproduction.md").write_text(document(made), encoding="utf-8")
    index = folder / "index.html"
    index.write_text(page.html_page(page.blocks(made, figures=True)), encoding="utf-8")
    return index


def document(made: list[tuple[Item, list[Table]]]) -> str:
    """The page as it stands in the documentation: tables only."""
    return page.markdown(page.blocks(made, figures=False))


def sampled(client: Client, items: Iterable[Item], workers: int = 2) -> list[Table]:
    """Tables of the samples of some items, without writing anything."""
    chosen = [replace(item, asks=item.sample) for item in items if item.sample is not None]
    answers = ask_all(client, chosen, workers, Steps(0, None))
    return [table for item in chosen for table in item.tables(found(item, answers))]


def questions(items: list[Item]) -> list[Ask]:
    """Every question once, costly ones first."""
    asked = {question: None for item in items for question in item.asks.values()}
    return sorted(asked, key=cost, reverse=True)


DRAWING = 0.4  # seconds per item


def cost(question: Ask) -> float:
    """A rough measure of the work (seconds of one processor): points, clouds, runs and steps."""
    name, given = question.case, dict(question.parameters)
    dim = int(name[-2]) if name[-2:-1].isdigit() else 2
    in_time = name.startswith("diffusion")
    clouds = given.get("seeds", 1) if in_time or name.startswith("sine") else 1
    numbers = given.get("diffusion_number", (1,)) if in_time else (1,)
    runs = clouds * len(given["alpha"] if isinstance(given.get("alpha"), tuple) else (1,))
    steps = sum(1 / number for number in numbers)
    each = 4e-9 * dim if in_time else 4e-6
    return 0.01 + each * runs * steps * sum(n ** (dim + 2 * in_time) for n in question.cells)


def ask_all(client: Client, items: list[Item], workers: int, steps: "Steps") -> dict[Ask, Any]:
    """The answers to all questions; `workers` are asked at a time."""
    answers: dict[Ask, Any] = {}
    steps.begin("asking")
    with ThreadPoolExecutor(workers) as pool:
        waiting = {pool.submit(answer, client, question): question
                   for question in questions(items)}
        try:
            for future in as_completed(waiting):
                answers[waiting[future]] = future.result()
                steps.done(cost(waiting[future]), waiting[future].case)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return answers


def answer(client: Client, question: Ask) -> Any:
    try:
        return question.run(client)
    finally:
        client.close()  # a thread of the pool has its own connection


def found(item: Item, answers: dict[Ask, Any]) -> dict[str, Any]:
    return {name: answers[question] for name, question in item.asks.items()}


def write_item(item: Item, answers: dict[Ask, Any], folder: pathlib.Path) -> list[Table]:
    """The files of one item; its tables."""
    mine = found(item, answers)
    made = item.tables(mine)
    for table in made:
        table.write(folder / "tables")
    if item.draw:
        figure = draw.new(item.size)
        item.draw(figure, mine)
        figure.savefig(folder / "figures" / f"{item.id}.png", dpi=130, bbox_inches="tight", pad_inches=0.25)
    return made


class Steps:
    """How far it has come."""

    def __init__(self, total: float, progress: Progress | None):
        self.total, self.finished, self.progress = total, 0.0, progress

    def begin(self, what: str) -> None:
        if self.progress:
            self.progress(min(self.finished / self.total, 1.0), what)

    def done(self, work: float, what: str = "") -> None:
        self.finished += work
        self.begin(what)
