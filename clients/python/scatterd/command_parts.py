"""What the commands share: their client, requests in files, results shown and written."""

from __future__ import annotations

import argparse
import json
import pathlib
import sys
from typing import Any, Iterator

import numpy

from .client import Client
from .plotting import plot
from .result import Result
from .saving import WRITERS, leaves, save
from .study import Study


def add_output(command: argparse.ArgumentParser, with_plot: bool = True) -> None:
    """Options of what `show` does with a result."""
    command.add_argument("--output", metavar="FILE",
                         help="write results: .json, .npz, .csv, .vtp")
    if with_plot:
        command.add_argument("--plot", metavar="FILE", help="draw it (.png, .pdf, .svg)")
        command.add_argument("--field", help="output to draw")
    command.set_defaults(plot=None, field=None)


def client(options: argparse.Namespace) -> Client:
    """The client of the options that all commands share."""
    return Client(options.url, options.token, options.timeout, options.format, ca=options.ca)


def check_output(name: str | None) -> None:
    """Complains of a file that could not be written before anything is computed."""
    if name and pathlib.Path(name).suffix not in WRITERS:
        raise ValueError(f"output {name!r} needs a name in {' or '.join(WRITERS)}")


def show(result: Result, options: argparse.Namespace) -> None:
    """Writes and draws a result as the options say, and prints its summary."""
    if options.output:
        save(result, options.output)
    if options.plot and isinstance(result, Study):
        result.plot(options.field or "l2", file=options.plot)
    elif options.plot:
        plot(result, options.field, file=options.plot)
    for line in summary(result):
        print(line)


def read_request(name: str) -> dict:
    """The request in a file, or on standard input."""
    text = sys.stdin.read() if name == "-" else pathlib.Path(name).read_text(encoding="utf-8")
    try:
        request = json.loads(text)
    except json.JSONDecodeError as error:
        raise ValueError(f"{name}: no JSON: {error}") from None
    if not isinstance(request, dict):
        raise ValueError(f'{name}: needs an object {{"inputs": {{...}}}}')
    return request


def summary(result: Result) -> Iterator[str]:
    """A line per output: arrays by shape and range, numbers as they are."""
    for name, value in leaves(result):
        if isinstance(value, numpy.ndarray) and value.size > 6:
            shape = " x ".join(map(str, value.shape))
            low, high = numpy.nanmin(value), numpy.nanmax(value)
            yield f"{name:36s} {shape} numbers from {low:.6g} to {high:.6g}"
        else:
            yield f"{name:36s} {shown(value)}"


def shown(value: Any) -> str:
    if isinstance(value, numpy.ndarray):
        return " ".join(f"{number:.6g}" for number in value.ravel())
    return f"{value:.6g}" if isinstance(value, float) else str(value)
