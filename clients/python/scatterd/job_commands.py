"""Command line: submit, jobs, watch, cancel, results."""

from __future__ import annotations

import argparse
import sys
from typing import Any, Callable, Iterable

from .client import Client
from .command_parts import add_output, check_output, client, read_request, show
from .errors import ScatterdError
from .job import Job
from .sse import STATES


def add_job_commands(commands: Any, shared: argparse.ArgumentParser) -> None:
    """Adds them to the commands; `shared` has the options of all."""
    def add(name: str, run: Callable[[argparse.Namespace, Client], int], text: str) -> Any:
        def run_with_client(options: argparse.Namespace) -> int:
            with client(options) as service:
                return run(options, service)

        command = commands.add_parser(name, help=text, parents=[shared])
        command.set_defaults(run=run_with_client)
        return command

    command = add("submit", submit, "submit requests as jobs and print their ids")
    command.add_argument("files", nargs="+", metavar="FILE",
                         help='request, {"inputs": {...}}, perhaps with "process"')
    command.add_argument("--process", default="solve",
                         help="process of requests that name none (default solve)")
    command.add_argument("--priority", type=int, help="0 to 9, the highest goes first (default 5)")
    command.add_argument("--fresh", action="store_true",
                         help="compute even what was computed before")
    command.add_argument("--wait", action="store_true", help="watch them until they are over")

    command = add("jobs", list_jobs, "list the jobs, newest first")
    command.add_argument("--status", action="append", choices=STATES, help="only of this status")
    command.add_argument("--process", action="append", help="only of this process")
    command.add_argument("--since", metavar="TIME", help="only those created from then on")
    command.add_argument("--limit", type=int, default=20, help="so many at most (default 20)")

    for name, run, text in (("watch", watch, "show the progress of jobs until they are over"),
                            ("cancel", cancel, "stop jobs, or drop their results")):
        add(name, run, text).add_argument("ids", nargs="+", metavar="ID")

    command = add("results", results, "wait for the results of a job and show or write them")
    command.add_argument("id", metavar="ID")
    add_output(command)


def submit(options: argparse.Namespace, service: Client) -> int:
    """Prints a line per file: id of the job, name of the file."""
    made, refused = [], 0
    for file in options.files:
        try:
            request = read_request(file)
            process = request.pop("process", options.process)
            job = service.submit_request(process, request, priority=options.priority,
                                         fresh=options.fresh)
        except (ScatterdError, OSError, ValueError) as error:
            print(f"scatterd-client: {file}: {error}", file=sys.stderr)
            refused += 1
            continue
        made.append(job)
        print(job.id, file, flush=True)
    failed = watch_all(made) if options.wait else 0
    return 1 if refused or failed else 0


def list_jobs(options: argparse.Namespace, service: Client) -> int:
    print(f"{'id':32s} {'status':10s} {'%':>4s} {'process':8s} {'created':19s} message")
    for job in service.jobs(status=options.status, process=options.process, since=options.since,
                            limit=options.limit):
        info = job.info
        print(f"{job.id:32s} {info['status']:10s} {info.get('progress', 0):3d}% "
              f"{info.get('processID', ''):8s} {info.get('created', '')[:19]:19s} "
              f"{info.get('message', '')}")
    return 0


def watch(options: argparse.Namespace, service: Client) -> int:
    return 1 if watch_all(service.job(id) for id in options.ids) else 0


def watch_all(jobs: Iterable[Job]) -> int:
    """Watches them one after the other; how many were not successful."""
    return sum(watch_one(job) != "successful" for job in jobs)


def watch_one(job: Job) -> str:
    job.wait(progress=True)
    print(f"{job.id} {job.status}: {job.info.get('message', '')}")
    return job.status


def cancel(options: argparse.Namespace, service: Client) -> int:
    for id in options.ids:
        job = service.job(id).cancel()
        print(f"{job.id} {job.info['status']}")
    return 0


def results(options: argparse.Namespace, service: Client) -> int:
    check_output(options.output)
    found = service.job(options.id).result()
    for result in found if isinstance(found, list) else [found]:
        if isinstance(result, ScatterdError):
            print(f"failed: {result}")
        else:
            show(result, options)
    return 0
