"""Command line: scatterd-client PROCESS request.json; jobs are in job_commands."""

from __future__ import annotations

import argparse
import sys

from .client import DEFAULT_URL
from .command_parts import add_output, check_output, client, read_request, show
from .errors import ScatterdError
from .job_commands import add_job_commands

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
    shared.add_argument("--token", help="bearer token, if the service wants one (default "
                        "$SCATTERD_TOKEN, which other users of this machine cannot see)")
    shared.add_argument("--ca", metavar="FILE", help="certificates to trust beside those of the "
                        "system (default $SCATTERD_CA)")
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
        add_output(command, with_plot=name != "echo")
        command.set_defaults(run=run_process, process=name)
    add_job_commands(commands, shared)
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
    check_output(options.output)
    request = read_request(options.request)
    with client(options) as service:
        result = service.post(options.process, request)
    show(result, options)
    return 0
