"""What the examples share: their command line, the connection, and checks against bounds."""

import argparse
import os
import pathlib
import sys

try:
    import scatterd
except ImportError:  # not installed: take the package beside us
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
    import scatterd


def options(description):
    """--url and --plot of an example."""
    default = os.environ.get("SCATTERD_URL", "http://127.0.0.1:8480")
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--url", default=default, help=f"address of a scatterd (now {default})")
    parser.add_argument("--plot", metavar="FILE", help="draw the solution (.png, .pdf, .svg)")
    return parser.parse_args()


class Checks:
    """Bounds that an example must keep; `exit` tells whether it did."""

    def __init__(self):
        self.broken = 0

    def below(self, what, value, bound):
        """Prints a number and whether it is below its bound."""
        good = value <= bound  # false for NaN
        self.broken += not good
        print(f"{what:58s} {value:10.3e} {'<=' if good else '> '} {bound:.1e}", flush=True)

    def exit(self):
        print("all within their bounds" if not self.broken else f"{self.broken} bounds broken")
        sys.exit(1 if self.broken else 0)


def run(main, description):
    """Runs main(client, plot file or None, checks) with readable errors."""
    chosen, checks = options(description), Checks()
    try:
        with scatterd.Client(chosen.url) as client:
            main(client, chosen.plot, checks)
    except scatterd.ScatterdError as error:
        sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {error}")
    checks.exit()
