"""Faults on order: the other end of fault_shim.c.

    faults = Faults()
    server = daemon.Daemon(directory=faults.directory, environment=faults.environment)
    faults.fail("write", errno.ENOSPC)             # from now on
    faults.fail("sync", errno.EIO, after=3, times=1)   # the fourth one
    faults.fail("memfd", errno.EMFILE, where="workers")
    faults.set_clock(7200)
    faults.kill_in("factor", times=2)
    faults.hold(1 << 20)                # an fsync of a file of that size waits: held() of them
    faults.let_go(1)                    # one of those; clear() lets all go
    faults.clear()

The kinds: write read sync rename open truncate unlink (of files in the data directory), memfd map
fork pair accept watch, and memory (malloc and its like). Without an errno (0) a write or read does half of what it should.
"""

import mmap
import os
import re
import struct
import subprocess
import tempfile

import daemon

KINDS = ("write", "read", "sync", "rename", "open", "truncate", "unlink", "memfd", "map", "fork",
         "pair", "accept", "watch", "memory")
ORDER = struct.Struct("=qqqq")
WHERE = {"front": 0, "workers": 1}
CLOCK = 2 * len(KINDS) * ORDER.size
HOLD = CLOCK + 8 + 8 + 32
SIZE = HOLD + 3 * 8


def sanitizer(program):
    """The runtime that must be loaded before anything that is preloaded; "" without one."""
    found = subprocess.run(["ldd", program], capture_output=True, text=True, check=True)
    match = re.search(r"libasan\S* => (\S+)", found.stdout)
    return match.group(1) if match else ""


class Faults:
    """A directory for a daemon, and what is to fail there."""

    def __init__(self, stub=True, directory=None, memory=False):
        """`memory`: that can fail, too."""
        self.directory = directory or tempfile.mkdtemp(prefix="daemon-test-")
        self.file, path = tempfile.mkstemp(prefix="faults-")
        os.truncate(path, SIZE)
        self.page = mmap.mmap(self.file, SIZE)
        self.path = path
        preload = [sanitizer(daemon.program(stub)), os.environ["SCATTERD_FAULT_SHIM"]]
        self.environment = {"SCATTERD_FAULTS": path, "SCATTERD_FAULTS_BELOW": self.directory}
        if memory:  # AddressSanitizer has a malloc of its own: the shim's must come before it
            preload.reverse()
            options = os.environ.get("ASAN_OPTIONS", "")
            self.environment["ASAN_OPTIONS"] = options + ":verify_asan_link_order=0"
        self.environment["LD_PRELOAD"] = " ".join(preload).strip()

    def _place(self, kind, where):
        return (WHERE[where] * len(KINDS) + KINDS.index(kind)) * ORDER.size

    def fail(self, kind, error, after=0, times=-1, where="front"):
        """After `after` more calls `times` of them fail with this errno; -1: until clear()."""
        place = self._place(kind, where)
        ORDER.pack_into(self.page, place, after, 0, error, 0)
        struct.pack_into("=q", self.page, place + 8, times)  # last: it begins with this

    def hits(self, kind, where="front"):
        """How many calls have failed since they were ordered to."""
        return ORDER.unpack_from(self.page, self._place(kind, where))[3]

    def set_clock(self, seconds):
        """The daemon's time of day is that much ahead of ours."""
        struct.pack_into("=d", self.page, CLOCK, seconds)

    def kill_in(self, phase, times=1):
        """So many workers die where they begin this phase; "fetch", "keep", "checkpoint": once they
        have asked for that; "reply": just before it."""
        struct.pack_into("=q", self.page, CLOCK + 8, 0)
        struct.pack_into("=32s", self.page, CLOCK + 16, phase.encode())
        struct.pack_into("=q", self.page, CLOCK + 8, times)  # last: it begins with this

    def kills_left(self):
        return struct.unpack_from("=q", self.page, CLOCK + 8)[0]

    def hold(self, size):
        """The front's fsyncs of files of at least so many bytes wait from now on."""
        struct.pack_into("=qq", self.page, HOLD + 8, 0, 0)
        struct.pack_into("=q", self.page, HOLD, size)

    def held(self):
        """How many have begun to wait."""
        return struct.unpack_from("=q", self.page, HOLD + 8)[0]

    def let_go(self, count):
        """So many, from the first on, wait no more."""
        struct.pack_into("=q", self.page, HOLD + 16, count)

    def clear(self):
        """Nothing fails or waits any more; the clock stays."""
        struct.pack_into("=q", self.page, HOLD, 0)
        for kind in KINDS:
            for where in WHERE:
                struct.pack_into("=q", self.page, self._place(kind, where) + 8, 0)
        self.kill_in("", 0)

    def close(self):
        os.close(self.file)
        os.unlink(self.path)


