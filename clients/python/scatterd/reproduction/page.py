"""The page that sets papers and service side by side: blocks, and how they look in Markdown (for the
documentation) and HTML (for the folder of a reproduction)."""

from __future__ import annotations

import html
from typing import Iterable, NamedTuple

from .misprints import MISPRINTS
from .parts import Item, Table

PAPERS = {
    "h11": "Huang, Sheu, Ishikawa and Yamaguchi 2011, *Development of a particle interaction kernel "
    "for convection-diffusion scalar transport equation*, Numerical Heat Transfer B 60, 96-115",
    "h16": "Hwang, Ng and Sheu 2016, *An improved particle smoothing procedure for Laplacian operator "
    "in a randomly scattered cloud*, Numerical Heat Transfer B 70, 111-135",
}
ABOUT = (
    "Every table and figure of two papers on particle methods, as `scatterd-client reproduce` makes "
    "them: each number is an answer of process `study`. Norms are over the interior points, "
    "`linf_all` over all; rates are by the spacing. Clouds are made from seeds, so a second run gives "
    "the same numbers. Figures 20 to 23 of the second paper are flows, which process `study` does "
    "not make."
)


class Block(NamedTuple):
    """A piece of the page: heading1 .. heading3, text, table (a Table), figure (file and title),
    files (names)."""

    kind: str
    content: object


def blocks(made: Iterable[tuple[Item, list[Table]]], figures: bool) -> Iterable[Block]:
    """The whole page out of the items and their tables."""
    made = list(made)
    yield Block("heading1", "Two papers, reproduced")
    yield Block("text", ABOUT)
    yield Block("heading2", "Where the papers are misprinted or wrong")
    yield Block("table", misprints())
    for key, paper in PAPERS.items():
        yield Block("heading2", paper)
        for item, tables in made:
            if item.id.startswith(key):
                yield from of_item(item, tables, figures)


def misprints() -> Table:
    columns = ["paper", "place", "it says", "right is"]
    return Table("misprints", "", columns, [list(row) for row in MISPRINTS])


def of_item(item: Item, tables: list[Table], figures: bool) -> Iterable[Block]:
    shown = [table for table in tables if table.shown]
    if shown and item.sample is None:
        raise ValueError(f"{item.id} shows a table but has no sample for the tests")
    if not shown and not (figures and item.draw):
        return
    yield Block("heading3", item.title)
    if item.text:
        yield Block("text", item.text)
    if figures and item.draw:
        yield Block("figure", (f"figures/{item.id}.png", item.title))
    for table in shown:
        if table.title:
            yield Block("text", table.title + ":")
        yield Block("table", table)
    if figures and tables:
        yield Block("files", [f"tables/{table.id}.{kind}" for table in tables
                              for kind in ("csv", "json")])


# --- Markdown ----------------------------------------------------------------------------------


def markdown(page: Iterable[Block]) -> str:
    return "\n\n".join(MARKDOWN[block.kind](block.content) for block in page) + "\n"


def markdown_table(table: Table) -> str:
    def line(cells):
        return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"
    head = [f"<!-- {table.id} -->", line(table.columns), "|" + "---|" * len(table.columns)]
    return "\n".join([*head, *(line(row) for row in table.texts())])


MARKDOWN = {
    "heading1": "# {}".format,
    "heading2": "## {}".format,
    "heading3": "### {}".format,
    "text": str,
    "table": markdown_table,
    "figure": lambda figure: f"![{figure[1]}]({figure[0]})",
    "files": lambda names: "Data: " + ", ".join(f"[{name}]({name})" for name in names),
}


# --- HTML --------------------------------------------------------------------------------------

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 75rem; margin: 2rem auto; padding: 0 1rem;
       color: #1b1f24; background: #fff; }
h2 { margin-top: 3rem; border-bottom: 1px solid #d0d7de; } h3 { margin-top: 2.5rem; }
table { border-collapse: collapse; font-size: 0.85em; display: block; overflow-x: auto; }
td, th { text-align: left; padding: 0.2rem 0.8rem 0.2rem 0; vertical-align: top;
         border-bottom: 1px solid #eaeef2; font-variant-numeric: tabular-nums; }
code { font: 0.9em ui-monospace, monospace; background: #f3f4f6; padding: 0.1em 0.3em; }
img { max-width: 100%; } p { max-width: 60rem; }
"""


def rich(text: str) -> str:
    """Text with `code` and *emphasis*."""
    marked = html.escape(text)
    for mark, tag in (("`", "code"), ("*", "em")):
        pieces = marked.split(mark)
        if len(pieces) % 2 == 1:
            marked = "".join(piece if k % 2 == 0 else f"<{tag}>{piece}</{tag}>"
                             for k, piece in enumerate(pieces))
    return marked


def html_table(table: Table) -> str:
    def line(cells, tag):
        return "<tr>" + "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells) + "</tr>"
    rows = "\n".join(line(row, "td") for row in table.texts())
    return f'<table id="{table.id}">{line(table.columns, "th")}\n{rows}</table>'


HTML = {
    "heading1": lambda text: f"<h1>{rich(text)}</h1>",
    "heading2": lambda text: f"<h2>{rich(text)}</h2>",
    "heading3": lambda text: f"<h3>{rich(text)}</h3>",
    "text": lambda text: f"<p>{rich(text)}</p>",
    "table": html_table,
    "figure": lambda figure: f'<img src="{figure[0]}" alt="{html.escape(figure[1])}">',
    "files": lambda names: "<p>Data: " + ", ".join(
        f'<a href="{name}">{name}</a>' for name in names) + "</p>",
}


def html_page(page: Iterable[Block]) -> str:
    body = "\n".join(HTML[block.kind](block.content) for block in page)
    return (f'<!doctype html><html lang="en"><head><meta charset="utf-8">'
            f"<title>Two papers, reproduced</title><style>{STYLE}</style></head><body>\n{body}\n"
            "</body></html>\n")
