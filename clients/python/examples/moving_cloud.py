#!/usr/bin/env python3
"""What the cloud of a flow does to the operators on it: ps against ips, on particles that moved.

A lid-driven cavity at Reynolds number 100 is run with ips on a uniform and on a graded mesh. Its
snapshots are posted to `diagnose` and `apply` as they are. On them the Laplacian of ps contains a
convection with the artificial velocity that `diagnose` tells: multiplied by the viscosity it is a
velocity that is added to that of the fluid. ips has none. On the uniform cloud it is noise, and
averages out from snapshot to snapshot; on the graded one it does not, and that is what spoils flows.
"""

import pathlib
import tempfile

import numpy
from common import run, scatterd

CELLS, REYNOLDS = 20, 100
TIMES = list(range(5, 16))


def laplacian(client, cloud, field, scheme):
    """Of a field at the points of a cloud."""
    return client.apply(cloud=cloud, field=field, operator={"scheme": scheme},
                        outputs=["laplacian"]).laplacian


def noise_and_drift(client, flow):
    """Artificial velocities of ps, seen as Laplacians of the coordinates x and y, over the speed of
    the lid: root mean square, and that of the means over time in 5 x 5 boxes; and the same of ips."""
    box_sum, box_count, squares, ips_most = numpy.zeros((25, 2)), numpy.zeros(25), [], 0.0
    for k in range(len(TIMES)):
        cloud = {**flow.cloud(k), "spacing": 1 / CELLS}
        n = len(flow.snapshots[k].particles)
        inner = numpy.all(abs(cloud["points"][:n] - 0.5) < 0.5 - 2.5 / CELLS, axis=1)
        places = cloud["points"][:n][inner]
        ps, ips = ([laplacian(client, cloud, axis, scheme)[:n][inner] for axis in ("x", "y")]
                   for scheme in ("ps", "ips"))
        ips_most = max(ips_most, numpy.abs(ips).max())
        drift = numpy.transpose(ps) / REYNOLDS
        squares.append(numpy.mean(drift**2))
        box = (5 * places).astype(int) @ [1, 5]
        numpy.add.at(box_sum, box, drift)
        numpy.add.at(box_count, box, 1)
    mean = box_sum / box_count[:, None]
    steady = numpy.average(numpy.mean(mean**2, axis=1), weights=box_count)
    return numpy.sqrt(numpy.mean(squares)), numpy.sqrt(steady), ips_most / REYNOLDS


def main(client, plot, checks):
    flows = {}
    for name, grading in (("uniform", 0), ("graded", 0.3)):
        flow = flows[name] = client.flow(
            "cavity", cells=CELLS, reynolds=REYNOLDS, end=TIMES[-1], save=TIMES,
            operator={"scheme": "ips"}, grading={"clustering": grading},
        )
        noise, drift, ips = noise_and_drift(client, flow)
        print(f"{name}: ps adds velocities of {noise:.4f} (root mean square), {drift:.4f} of them "
              f"steady, to a flow of 1; ips {ips:.1e}")
        checks.below(f"{name}: largest artificial velocity of ips", ips, 1e-9)
        checks.below(f"{name}: circulation less the reference", abs(flow.vortex.circulation - 0.1035), 4e-3)
        flows[name, "drift"] = drift
    checks.below("uniform over graded: what does not average out",
                 flows["uniform", "drift"] / flows["graded", "drift"], 0.5)
    cloud = {**flows["graded"].cloud(), "spacing": 1 / CELLS}
    told = client.diagnose(cloud=cloud, operator={"scheme": "ps"}).artificial_velocity
    seen = laplacian(client, cloud, "x", "ps")
    checks.below("what diagnose tells less what apply sees", numpy.abs(told[:, 0] - seen).max(), 1e-9)
    with tempfile.TemporaryDirectory() as folder:
        files = flows["uniform"].save_series(str(pathlib.Path(folder) / "cavity.pvd"))
        checks.below("files for ParaView that are missing", len(TIMES) + 1 - len(files), 0)
    if plot:
        scatterd.plot(flows["graded"], numpy.hypot(*flows["graded"].velocity.T), file=plot,
                      title="Cavity, particles at t = 15: speed")


if __name__ == "__main__":
    run(main, __doc__)
