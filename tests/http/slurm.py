"""A Slurm of one node in a temporary directory: munged, slurmctld and slurmd, started as root.

    with slurm.Cluster() as cluster:
        subprocess.run(["sinfo"], env=cluster.environment)

Nothing of the machine's own Slurm or munge is used or changed: sockets, keys, ports and files are
those of the directory, and cgroups are not touched.
"""

import os
import pathlib
import shutil
import signal
import socket
import subprocess
import tempfile
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "sinfo", "mpiexec")

CONF = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={directory}/munge.socket
CredType=cred/munge
StateSaveLocation={directory}/state
SlurmdSpoolDir={directory}/spool
SlurmctldPidFile={directory}/slurmctld.pid
SlurmdPidFile={directory}/slurmd.pid
SlurmctldLogFile={directory}/slurmctld.log
SlurmdLogFile={directory}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
SchedulerParameters=defer_batch,sched_interval=1,sched_min_interval=0
MpiDefault=none
ReturnToService=2
KillWait=1
InactiveLimit=0
MinJobAge={min_job_age}
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
NodeName=node0 NodeHostname={host} NodeAddr=127.0.0.1 Port={ports[1]} CPUs=4 State=UNKNOWN
PartitionName=all Nodes=node0 Default=YES MaxTime=INFINITE State=UP
"""


def find(name):
    return shutil.which(name, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")


def free_ports(count):
    """Free just now; somebody may take them before they are used."""
    sockets = [socket.socket() for _ in range(count)]
    try:
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]
    finally:
        for one in sockets:
            one.close()


class NotHere(Exception):
    """Why there can be no Slurm."""


class Cluster:
    def __init__(self, min_job_age=300):
        if os.getuid() != 0:
            raise NotHere("slurmd needs root")
        for name in PROGRAMS:
            if find(name) is None:
                raise NotHere(f"no {name} (Debian: slurm-wlm, munge, openmpi-bin)")
        self.directory = pathlib.Path(tempfile.mkdtemp(prefix="slurm-test-"))
        self.processes = []
        self.controller = None
        for name in ("state", "spool"):
            (self.directory / name).mkdir()
        host = socket.gethostname().split(".")[0]
        (self.directory / "slurm.conf").write_text(CONF.format(
            host=host, directory=self.directory, ports=free_ports(2), min_job_age=min_job_age))
        key = self.directory / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)
        self.environment = {"SLURM_CONF": str(self.directory / "slurm.conf")}
        try:
            self._start()
        except Exception:
            self.stop()
            raise

    def _start(self):
        place = self.directory
        self.munged = self._run("munged", "--foreground", "--force", f"--socket={place}/munge.socket",
                                f"--key-file={place}/munge.key", f"--pid-file={place}/munged.pid",
                                f"--log-file={place}/munged.log", f"--seed-file={place}/munged.seed",
                                "--num-threads=2")
        self._wait(lambda: (place / "munge.socket").exists(), "munged")
        self.start_controller()
        self._run("slurmd", "-D", "-N", "node0")
        self._wait(lambda: self.ask("sinfo", "--noheader", "--format=%T") == "idle", "an idle node")

    def start_controller(self):
        """Nothing if it runs."""
        if self.controller is None:
            self.controller = self._run("slurmctld", "-D")

    def stop_controller(self):
        """It knows all jobs when it is started again."""
        self.controller.terminate()
        self.controller.wait()
        self.processes.remove(self.controller)
        self.controller = None

    def _run(self, name, *options):
        log = open(self.directory / f"{name}.out", "ab")
        process = subprocess.Popen([find(name), *options], stdin=subprocess.DEVNULL, stdout=log,
                                   stderr=log, env={**os.environ, **self.environment})
        log.close()
        self.processes.append(process)
        return process

    def _wait(self, condition, what, seconds=60):
        end = time.monotonic() + seconds
        while not condition():
            for process in self.processes:
                if process.poll() is not None:
                    raise NotHere(f"{process.args[0]} ended: {self.logs()}")
            if time.monotonic() > end:
                raise NotHere(f"no {what} within {seconds} s: {self.logs()}")
            time.sleep(0.1)

    def logs(self):
        return "\n".join(f"{path.name}: {path.read_text(errors='replace')[-600:]}"
                         for path in sorted(self.directory.glob("*.out")))

    def ask(self, *words):
        done = subprocess.run(words, capture_output=True, text=True, check=False,
                              env={**os.environ, **self.environment})
        return done.stdout.strip() if done.returncode == 0 else None

    def jobs(self):
        """All jobs it knows: id to state and name."""
        text = self.ask("squeue", "--noheader", "--states=all", "--format=%i|%T|%j") or ""
        return {int(number): (state, name) for number, state, name in
                (line.split("|") for line in text.splitlines())}

    def stop(self):
        for process in reversed(self.processes):
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        shutil.rmtree(self.directory, ignore_errors=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.stop()
