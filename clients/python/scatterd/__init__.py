"""Client of scatterd: partial differential equations on particle clouds, numpy in and out.

    import scatterd

    client = scatterd.Client("http://127.0.0.1:8480")
    result = client.solve(
        cloud=scatterd.lattice([0, 0], [1, 1], 32, jitter=0.3),
        diffusivity=1,
        source="2*pi^2*sin(pi*x)*sin(pi*y)",
        boundary=[scatterd.dirichlet("boundary", 0)],
    )
    print(result.solution.max())
    scatterd.plot(result, file="solution.png")

`client.submit` runs the same as a job; `scatterd.aio` is the client for asyncio.
"""

from .client import Client
from .errors import Culprit, ScatterdError, UnreachableError
from .flow import Flow
from .job import Job
from .lattice import lattice_points
from .plotting import plot
from .problem import cloud, dirichlet, lattice, neumann, robin
from .result import Record, Result
from .retry import Retry
from .sse import Event
from .study import Study

__version__ = "0.1.0"
__all__ = [
    "Client",
    "Culprit",
    "Event",
    "Flow",
    "Job",
    "Record",
    "Result",
    "Retry",
    "ScatterdError",
    "Study",
    "UnreachableError",
    "cloud",
    "dirichlet",
    "lattice",
    "lattice_points",
    "neumann",
    "plot",
    "robin",
]
