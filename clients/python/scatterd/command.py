"""Command line: scatterd-client PROCESS request.json."""

from __future__ import annotations

import argparse
import json
import pathlib
import sys
from typing import Any, Iterator

import numpy

from .client import DEFAULT_URL, Client
from .errors import ScatterdError
from .plotting import plot
from .flow import Flow
from .result import Result
from .saving import WRITERS, leaves, save
from .study import Study

PROCESSES = {
    "solve": "solve a convection-diffusion-reaction problem",
    "apply": "apply the particle operators to a field",
    "diagnose": "tell what a cloud does to the operators",
    "study": "run a published test problem on several meshes",
    "flow": "incompressible flow on moving particles",
    "echo": "get back what is sent",
}


def main(arguments: list[str] | None = None) -> int:
    """Runs the command; 0 if all went well, 1 if the service or a file did not do."""
    options = parser().parse_args(arguments)
    try:
        return options.run(options)
    except (ScatterdError, OSError, ValueError) as error:
        print(f"scatterd-client: {error}", file=sys.stderr)
        return 1


def parser() -> argparse.ArgumentParser:
    shared = argparse.ArgumentParser(add_help=False)
    shared.add_argument("--url", help=f"address (default $SCATTERD_URL, else {DEFAULT_URL})")
    shared.add_argument("--token", help="bearer token, if the service wants one")
    shared.add_argument("--timeout", type=float, default=600, help="seconds to wait (default 600)")
    shared.add_argument("--format", choices=("cbor", "json"), help="format on the wire")
    top = argparse.ArgumentParser(
        prog="scatterd-client",
        description="Partial differential equations on particle clouds, by a scatterd.",
    )
    commands = top.add_subparsers(metavar="COMMAND", required=True)
    for name, text in PROCESSES.items():
        command = commands.add_parser(name, help=text, parents=[shared])
        command.add_argument("request", help='file with {"inputs": {...}}; - for standard input')
        command.add_argument("--output", metavar="FILE", help="write results: .json, .npz, .csv, .vtp")
        if name != "echo":
            command.add_argument("--plot", metavar="FILE", help="draw it (.png, .pdf, .svg)")
            command.add_argument("--field", help="output to draw")
        command.set_defaults(run=run_process, process=name, plot=None, field=None)
    both = commands.add_parser(
        "reproduce", help="make all tables and figures of two papers", parents=[shared]
    )
    both.add_argument("--output", metavar="FOLDER", required=True, help="where to write them")
    both.add_argument("--only", metavar="TEXT", help="those only whose name holds this text")
    both.add_argument("--at-a-time", type=int, default=2, help="questions at a time (default 2)")
    both.set_defaults(run=run_reproduce)
    listing = commands.add_parser("processes", help="list the processes", parents=[shared])
    listing.set_defaults(run=run_processes)
    return top


def client(options: argparse.Namespace) -> Client:
    return Client(options.url, options.token, options.timeout, options.format)


def run_processes(options: argparse.Namespace) -> int:
    with client(options) as service:
        listed = service.processes()
    for process in listed:
        print(f"{process['id']:10s} {process.get('title', '')}")
    return 0


def run_reproduce(options: argparse.Namespace) -> int:
    from .reproduction import ITEMS, Bar, reproduce

    items = [item for item in ITEMS if (options.only or "") in item.id]
    if not items:
        raise ValueError(f"nothing is named {options.only!r}; there are "
                         + ", ".join(item.id for item in ITEMS))
    with client(options) as service:
        page = reproduce(service, options.output, items=items, workers=options.at_a_time,
                         progress=Bar())
    print(page)
    return 0


def run_process(options: argparse.Namespace) -> int:
    if options.output and pathlib.Path(options.output).suffix not in WRITERS:
        raise ValueError(f"output {options.output!r} needs a name in {' or '.join(WRITERS)}")
    request = read_request(options.request)
    with client(options) as service:
        result = service.post(options.process, request, KINDS.get(options.process, Result))
    if options.output:
        save(result, options.output)
    if options.plot and isinstance(result, Study):
        result.plot(options.field or "l2", file=options.plot)
    elif options.plot:
        plot(result, options.field, file=options.plot)
    for line in summary(result):
        print(line)
    return 0


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


KINDS = {"study": Study, "flow": Flow}


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
