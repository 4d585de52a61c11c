#!/usr/bin/env python3
"""Runs a command against a daemon of its own: run_example.py PROGRAM [ARGUMENTS]; its exit status
is that of the command, which finds the daemon's address in SCATTERD_URL."""

import os
import subprocess
import sys

sys.dont_write_bytecode = True
from daemon import Daemon  # noqa: E402

with Daemon() as daemon:
    environment = {**os.environ, "SCATTERD_URL": daemon.url, "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run([sys.executable, *sys.argv[1:]], env=environment, check=False)
    sys.exit(done.returncode)
