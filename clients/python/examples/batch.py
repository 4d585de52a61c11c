#!/usr/bin/env python3
"""A parameter sweep as jobs: how warm the tip of a cooling fin stays.

Along a fin of length 1 heat flows from its hot root (phi = 1 at x = 0) to its insulated tip and is
lost on the way: lap phi = m^2 phi. The tip has phi = 1 / cosh(m). The cloud is uploaded once; every
m is a job of its own, and the results are taken as they come. Then one job is watched, and another
cancelled.
"""

import numpy
from common import run, scatterd

CLOUD = scatterd.lattice([0, 0], [1, 0.5], [64, 32], jitter=0.3, seed=6)
SWEEP = numpy.linspace(0.25, 4, 16)


def fin(cloud, m):
    """The request for one m."""
    return {
        "inputs": {
            "cloud": cloud,
            "parameters": {"m": m},
            "diffusivity": 1,
            "reaction": "m^2",
            "boundary": [
                scatterd.neumann("top", 0),
                scatterd.neumann("bottom", 0),
                scatterd.neumann("right", 0),
                scatterd.dirichlet("left", 1),
            ],
            "operator": {"scheme": "lsmps", "degree": 2},
        },
        "outputs": {"solution": {}, "points": {}},
    }


def tip(result):
    """Mean temperature at x = 1."""
    return result.solution[result.points[:, 0] == 1].mean()


def sweep(client, cloud):
    """Temperature of the tip for every m, in their order."""
    tips = numpy.empty(len(SWEEP))
    requests = (fin(cloud, float(m)) for m in SWEEP)
    for count, (number, result) in enumerate(client.as_completed(requests), 1):
        if isinstance(result, scatterd.ScatterdError):
            raise result
        tips[number] = tip(result)
        print(f"{count:2d} of {len(SWEEP)}: m = {SWEEP[number]:4.2f}, tip {tips[number]:.4f}")
    return tips


def watch_and_cancel(client, cloud):
    """One job with a progress bar, one that is stopped; how these ended."""
    watched = client.submit("solve", fin(cloud, 5.0)["inputs"]).wait(progress=True)
    stopped = client.submit("echo", {"message": "too long", "pause": 60}).cancel()
    return watched.status, stopped.status


def main(client, plot, checks):
    cloud = client.upload(CLOUD)
    tips, exact = sweep(client, cloud), 1 / numpy.cosh(SWEEP)
    checks.below("largest error of a tip", numpy.abs(tips - exact).max(), 2e-4)
    checks.below("largest increase with m", numpy.diff(tips).max(), 0)
    ended = watch_and_cancel(client, cloud)
    checks.below("jobs that ended otherwise", ended != ("successful", "dismissed"), 0)
    if plot:
        draw(plot, tips, exact)


def draw(plot, tips, exact):
    from matplotlib.figure import Figure

    axes = Figure(figsize=(6, 4)).subplots()
    axes.plot(SWEEP, exact, label="1 / cosh(m)")
    axes.plot(SWEEP, tips, "o", label="scatterd")
    axes.set(xlabel="m", ylabel="temperature of the tip", title="A cooling fin")
    axes.legend()
    axes.figure.savefig(plot, dpi=150, bbox_inches="tight")


if __name__ == "__main__":
    run(main, __doc__)
