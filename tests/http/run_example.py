#!/usr/bin/env python3
"""Runs a command against a daemon of its own: run_example.py PROGRAM [ARGUMENTS]; its exit status
is that of the command, which finds the daemon's address in SCATTERD_URL."""

import os
import subprocess
import sys

sys.dont_write_bytecode = True
from daemon import Daemon  # noqa: E402

daemon = Daemon(stub=False)
try:
    daemon.wait_ready()
    address = {"SCATTERD_URL": f"http://{daemon.address}", "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, *sys.argv[1:]]
    done = subprocess.run(command, env={**os.environ, **address}, check=False)
finally:
    daemon.stop()
sys.exit(done.returncode)
