"""Results of process flow: particles with their velocity, fields on the mesh, how all of it came."""

from __future__ import annotations

import pathlib

import numpy

from .result import Result
from .saving import write_vtp


class Flow(Result):
    """Outputs of process flow: particles, velocity, mesh, profiles, vortex, history, ..."""

    def clouds(self) -> list[tuple[float, Result]]:
        """Times and particles of the snapshots, each a result with points, velocity and, if there
        is one, scalar; the end of the run where no times were to be saved."""
        shots = self.get("snapshots")
        if shots is None:
            shots = [{"t": self["history"]["t"][-1], **self}]
        found = []
        for shot in shots:
            fields = {"points": shot["particles"], "velocity": shot["velocity"]}
            if "scalar" in shot:
                fields["scalar"] = shot["scalar"]
            found.append((float(shot["t"]), Result(fields)))
        return found

    def cloud(self, snapshot: int | None = None) -> dict:
        """Particles of a snapshot (None: of the end) and the points on the walls as an input
        `cloud` of diagnose or apply; particles come first."""
        particles = self["particles"] if snapshot is None else self["snapshots"][snapshot]["particles"]
        return {"points": numpy.vstack([particles, self["wall_points"]])}

    def save_series(self, file: str) -> list[pathlib.Path]:
        """Writes the snapshots as NAME_0000.vtp, ... and NAME.pvd, which ParaView opens as a series
        in time; returns the files."""
        path = pathlib.Path(file).with_suffix(".pvd")
        files, rows = [], []
        for k, (time, shot) in enumerate(self.clouds()):
            one = path.with_name(f"{path.stem}_{k:04d}.vtp")
            write_vtp(one, shot, shot)
            files.append(one)
            rows.append(f'<DataSet timestep="{time!r}" part="0" file="{one.name}"/>\n')
        path.write_text('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n'
                        f'<Collection>\n{"".join(rows)}</Collection>\n</VTKFile>\n',
                        encoding="utf-8")
        return [path, *files]
