"""The client: one method per process."""

from __future__ import annotations

import io
import os
from typing import Any, Mapping, Sequence
from urllib.parse import quote

import numpy
from numpy.typing import ArrayLike

from . import wire
from .answer import content, failure
from .flow import Flow
from .job import KINDS
from .jobs import Jobs, execute_request
from .problem import Field
from .result import Result
from .retry import Retry
from .study import Study
from .transport import Answer, Transport

DEFAULT_URL = "http://127.0.0.1:8480"


class Client(Jobs):
    """A connection to a scatterd.

    Args:
        url: http://HOST:PORT, https://HOST:PORT or unix:PATH; by default $SCATTERD_URL, else
            http://127.0.0.1:8480.
        token: sent as a bearer token, if the service wants one; by default $SCATTERD_TOKEN.
        timeout: seconds to wait for an answer.
        format: "cbor" or "json" on the wire; by default cbor where cbor2 is installed.
        retry: how often a busy or lost service is asked again.
        ca: file of certificates (PEM) to trust beside those of the system, for a service with one
            of its own; by default $SCATTERD_CA.

    Threads may share a client: each has its own connection, kept open between requests. Every
    method raises ScatterdError if the service refuses or fails, UnreachableError without one.
    """

    def __init__(
        self,
        url: str | None = None,
        token: str | None = None,
        timeout: float | None = 600.0,
        format: str | None = None,
        retry: Retry | None = None,
        ca: str | None = None,
    ):
        self.url = url or os.environ.get("SCATTERD_URL") or DEFAULT_URL
        self.format = format or wire.best_format()
        if self.format not in ("cbor", "json"):
            raise ValueError(f"format is {format!r}, needs 'cbor' or 'json'")
        token = token or os.environ.get("SCATTERD_TOKEN")
        self.headers = {"Authorization": f"Bearer {token}"} if token else {}
        self.transport = Transport(self.url, timeout, ca or os.environ.get("SCATTERD_CA"))
        self.retry = retry or Retry()

    def solve(
        self,
        cloud: Mapping,
        diffusivity: Field,
        *,
        velocity: Sequence | ArrayLike | None = None,
        source: Field | None = None,
        reaction: Field | None = None,
        boundary: Sequence[Mapping] | None = None,
        initial: Field | None = None,
        time: Mapping | None = None,
        exact: Field | None = None,
        parameters: Mapping[str, float] | None = None,
        operator: Mapping | None = None,
        solver: Mapping | None = None,
        outputs: Sequence[str] | None = None,
    ) -> Result:
        """Solves d phi/dt + u . grad phi = div(mu grad phi) + s - k phi on a cloud.

        Args:
            cloud: made by `cloud` or `lattice`; n points in d dimensions.
            diffusivity: mu >= 0 (length^2 / time). Fields are numbers, arrays [n] or expressions
                of x, y, z, t, pi and `parameters`.
            velocity: u (length / time), d numbers or expressions, or an array [n][d].
            source: s (phi / time).
            reaction: k (1 / time).
            boundary: entries made by `dirichlet`, `neumann`, `robin`; a later one wins.
            initial: phi at the start of a time-dependent problem.
            time: {"method", "start", "end", "step" or "diffusion_number", "save"}; without it the
                problem is steady.
            exact: field to compare with, for `result.norms`.
            parameters: numbers that expressions may name.
            operator: {"scheme", "degree", "kernel", "radius", ...}.
            solver: {"method", "tolerance", "max_iterations"}.
            outputs: names of the outputs wanted; by default all.

        Returns:
            solution [n], points [n][d], norms (with `exact`), diagnostics, history (with `time`),
            report.
        """
        return self.execute("solve", given(locals()), outputs)

    def apply(
        self,
        cloud: Mapping,
        field: Field,
        *,
        operator: Mapping | None = None,
        exact_gradient: Sequence | ArrayLike | None = None,
        exact_laplacian: Field | None = None,
        parameters: Mapping[str, float] | None = None,
        outputs: Sequence[str] | None = None,
    ) -> Result:
        """Applies the particle operators to a field.

        Returns:
            value [n] (smoothed), gradient [n][d], laplacian [n], norms (with an exact field),
            diagnostics, report.
        """
        return self.execute("apply", given(locals()), outputs)

    def diagnose(
        self,
        cloud: Mapping,
        *,
        operator: Mapping | None = None,
        outputs: Sequence[str] | None = None,
    ) -> Result:
        """Tells what a cloud does to the operators on it.

        Returns:
            neighbours [n], number_density [n], artificial_velocity [n][d],
            effective_diffusivity [n][d (d + 1) / 2], summary, report.
        """
        return self.execute("diagnose", given(locals()), outputs)

    def study(
        self,
        case: str,
        cells: Sequence[int] | None = None,
        *,
        operator: Mapping | None = None,
        parameters: Mapping[str, Any] | None = None,
        outputs: Sequence[str] | None = None,
    ) -> Study:
        """Runs a published test problem on several meshes.

        Args:
            case: laplace, smooth, gartland, smith-hutton, skew, three-point, sine-1d, sine-2d,
                sine-3d, diffusion-1d, diffusion-2d, diffusion-3d, cavity or step; `process("study")` describes
                them and their defaults.
            cells: cells per unit of length of each mesh.
            operator: members that differ from the operator of the case.
            parameters: those that differ from their defaults; one given as an array varies from
                row to row.

        Returns:
            table (rows: cells, points, norms, rates, seconds, paper, ...), reference, requests,
            report; `plot()` draws the convergence.
        """
        return self.execute("study", given(locals()), outputs, Study)

    def flow(
        self,
        case: str | None = None,
        *,
        domain: Mapping | None = None,
        cells: int | None = None,
        reynolds: float | None = None,
        viscosity: float | None = None,
        end: float | None = None,
        operator: Mapping | None = None,
        grading: Mapping | None = None,
        walls: str | None = None,
        scalar: Mapping | None = None,
        parameters: Mapping[str, float] | None = None,
        save: Sequence[float] | None = None,
        outputs: Sequence[str] | None = None,
        **others: Any,
    ) -> Flow:
        """Incompressible flow in two dimensions on moving particles.

        Args:
            case: cavity or step; or
            domain: {"fluid": boxes, "solid": boxes, "sides": [...], "spacing": h} with viscosity
                and end.
            cells: per side of the cavity, or over the height of the step's inlet.
            operator: scheme ps, ips, ipsn or lsmps.
            grading: {"clustering": 0.3} for a mesh that is finer at walls.
            walls: points or mirror.
            scalar: {"diffusivity": .., "initial": ..}, a scalar that rides along.
            save: times of snapshots.
            others: further inputs, which `process("flow")` describes.

        Returns:
            particles [n][2], velocity [n][2], wall_points, mesh, profiles, vortex, history,
            summary, report, and where there are such scalar, snapshots, reattachment;
            `save_series()` writes them for ParaView.
        """
        inputs = {key: value for key, value in locals().items() if key != "others"}
        return self.execute("flow", {**given(inputs), **others}, outputs, Flow)

    def echo(
        self,
        message: str,
        *,
        pause: float | None = None,
        values: Sequence[int] | None = None,
        blob: str | None = None,
        outputs: Sequence[str] | None = None,
    ) -> Result:
        """Gets back message, pause (s) and values: for trying out the service."""
        return self.execute("echo", given(locals()), outputs)

    def execute(
        self,
        process: str,
        inputs: Mapping[str, Any],
        outputs: Sequence[str] | None = None,
        kind: type[Any] | None = None,
    ) -> Any:
        """Runs any process with inputs by name; `outputs` names those wanted, `kind` is what the
        result is made: a Study, a Flow, else a Result."""
        return self.post(process, execute_request(inputs, outputs), kind)

    def post(self, process: str, request: Mapping[str, Any], kind: type[Any] | None = None) -> Any:
        """Posts a whole execute request: {"inputs": ..., "outputs": ...}."""
        kind = kind or KINDS.get(process, Result)
        body, headers = wire.encode(request, self.format)
        path = f"/processes/{quote(process, safe='')}/execution"
        document = self.document("POST", path, body, headers)
        return kind(document, dict(request.get("inputs", {})))

    def upload(self, value: Any) -> dict:
        """Keeps a cloud or an array at the service, to be used in many requests.

        Args:
            value: an array, or a cloud made by `cloud` or `lattice`.

        Returns:
            {"href": ...}, which stands for the value wherever an input may.
        """
        if isinstance(value, numpy.ndarray):
            room = io.BytesIO()
            numpy.save(room, value)
            body, headers = room.getvalue(), {"Content-Type": "application/x-npy"}
        else:
            body, headers = wire.encode(value, "json")
        headers.update(wire.accept("json"))
        return {"href": self.document("POST", "/data", body, headers)["href"]}

    def processes(self) -> list[dict]:
        """Summaries of the processes there are."""
        return self.get("/processes")["processes"]

    def process(self, process: str) -> dict:
        """Description of a process with the schemas of its inputs and outputs."""
        return self.get(f"/processes/{quote(process, safe='')}")

    def get(self, path: str) -> Any:
        """Any JSON document of the service."""
        return self.document("GET", path, None, wire.accept("json"))

    def document(self, method: str, path: str, body: bytes | None, headers: dict) -> Any:
        """The document in the answer to a request; a refusal is raised."""
        answer = self.ask(method, path, body, headers)
        if answer.status >= 300:
            raise failure(answer)
        return content(answer)

    def ask(self, method: str, path: str, body: bytes | None, headers: dict) -> Answer:
        """The answer to a request, which is repeated while the service is busy or away."""
        whole = {**headers, **self.headers}
        return self.retry.run(lambda: self.transport.request(method, path, body, whole))

    def close(self) -> None:
        """Closes the connection of this thread."""
        self.transport.close()

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def given(arguments: dict) -> dict:
    """Inputs among the arguments of a method: those that were given."""
    others = ("self", "outputs")
    return {k: v for k, v in arguments.items() if k not in others and v is not None}
