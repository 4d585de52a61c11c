"""Thousands of damaged requests to a real daemon: each is answered by a result or by a problem that
says what is wrong, and in the end the daemon is as it was: same workers, no more memory, no more
descriptors.

SCATTERD_MUTATIONS (10000) and SCATTERD_SEED (random, printed) repeat a run; request number K of a
seed is always the same: `python3 mutation.py SEED K`. SCATTERD_CONNECTIONS (3) are open at a time;
once a minute a long run says how far it is.
"""

import collections
import json
import os
import random
import sys
import threading
import time
import unittest

import daemon
import mutation

MUTATIONS = int(os.environ.get("SCATTERD_MUTATIONS") or 10000)
SEED = int(os.environ.get("SCATTERD_SEED") or random.randrange(1 << 32))
CONNECTIONS = int(os.environ.get("SCATTERD_CONNECTIONS") or 3)
REPORT = 60                   # seconds from one word of a long run to the next
WARM_UP = MUTATIONS // 5      # requests until memory and descriptors should have settled
GROWTH = 3 << 20              # bytes a process may grow after that: under 1 KB per request
PASSES = 3                    # times that the same requests may grow it by more
MEDIA = {"json": "application/json", "cbor": "application/cbor"}
PROBLEM = "application/problem+json"


def refuse_constant(name):
    raise ValueError(f"{name} in JSON")


def wrong_with_problem(reply):
    """What is wrong with a problem document; "" if nothing."""
    if reply.type != PROBLEM:
        return f"a problem as {reply.type}"
    problem = json.loads(reply.body, parse_constant=refuse_constant)
    errors = problem.get("errors", [])
    said = [problem.get("type"), problem.get("title"), problem.get("detail")]
    said += [error["detail"] for error in errors]
    if problem.get("status") != reply.status:
        return "another status in the problem"
    if not all(isinstance(text, str) and text for text in said):
        return "something left unsaid"
    if reply.status == 400 and not errors:
        return "400 without errors"
    if not all(error["pointer"] == "" or error["pointer"].startswith("/") for error in errors):
        return "a pointer that is none"
    return ""


def wrong_with_result(reply, request):
    """What is wrong with a result, apart from its numbers; "" if nothing."""
    if reply.status == 201:  # a batch is accepted as a job, whose status is JSON
        return "" if json.loads(reply.body)["status"] == "accepted" else "a job that is not accepted"
    if reply.type == MEDIA["cbor"] and request.format == "cbor":
        mutation.wire.from_cbor(reply.body)
    elif reply.type == MEDIA["json"] and request.format == "json":
        json.loads(reply.body, parse_constant=refuse_constant)
    elif reply.status != 204 and not reply.type.startswith("text/csv"):
        return f"a result as {reply.type}"
    return ""


def wrong_with(reply, request):
    try:
        if 200 <= reply.status < 300:
            return wrong_with_result(reply, request)
        if 400 <= reply.status < 500 and reply.status != 429:
            return wrong_with_problem(reply)
    except Exception as error:  # whatever a decoder finds
        return f"{type(error).__name__}: {error}"
    return "a status that is neither result nor the client's fault"


class Sender(threading.Thread):
    """Sends every CONNECTIONS-th request over a connection of its own."""

    def __init__(self, running, numbers):
        super().__init__()
        self.running, self.numbers = running, numbers
        self.statuses, self.complaints = collections.Counter(), []

    def run(self):
        connection = self.running.connect(timeout=120)
        for number in self.numbers:
            request = mutation.make(SEED, number)
            media = MEDIA[request.format]
            try:
                connection.request("POST", f"/processes/{request.process}/execution", request.body,
                                   {"Content-Type": media, "Accept": f"{media}, {PROBLEM}"})
                response = connection.getresponse()
                reply = daemon.Reply(response)
                self.statuses[reply.status] += 1
                wrong = wrong_with(reply, request)
                if response.will_close:
                    wrong = wrong or "the connection is not kept"
            except OSError as error:
                reply, wrong = None, f"no answer: {error!r}"
                connection.close()
            if wrong:
                self.complaints.append((number, wrong, request, reply))
        connection.close()


def resident(pid):
    """Bytes of memory a process holds."""
    with open(f"/proc/{pid}/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE")


def described(complaint):
    number, wrong, request, reply = complaint
    got = f"{reply.status} {reply.type} {reply.body[:300]}" if reply else ""
    return (f"SCATTERD_SEED={SEED} request {number}: {wrong}\n"
            f"  {request.process} {request.format} {request.body[:1000]!r}\n  {got}")


class Mutation(daemon.Case):
    stub = False
    options = ["--workers", "2", "--recycle", "1000000", "--points", "500", "--steps", "100",
               "--seconds", "100", "--nodes", "5000"]

    def send(self, numbers):
        senders = [Sender(self.daemon, numbers[k::CONNECTIONS]) for k in range(CONNECTIONS)]
        for sender in senders:
            sender.start()
        while any(sender.is_alive() for sender in senders):
            self.say_how_far(senders)
        complaints = sorted((c for sender in senders for c in sender.complaints),
                            key=lambda c: c[0])
        self.assertEqual(len(complaints), 0, "\n".join(map(described, complaints[:10])))
        return sum((sender.statuses for sender in senders), collections.Counter())

    @staticmethod
    def say_how_far(senders):
        """Waits for the senders, or until the next word is due, and says it."""
        end = time.monotonic() + REPORT
        for sender in senders:
            sender.join(max(0, end - time.monotonic()))
        if time.monotonic() >= end:
            print(f"{sum(sum(sender.statuses.values()) for sender in senders)} requests, "
                  f"{sum(len(sender.complaints) for sender in senders)} complaints", flush=True)

    def processes(self):
        return [self.daemon.pid, *sorted(daemon.children(self.daemon.pid))]

    def settled(self):
        """Processes, their memory and descriptors, when the connections have gone."""
        pids = self.processes()
        daemon.wait_until(lambda: sum(what.startswith("socket:") for what in
                                      daemon.descriptors(self.daemon.pid).values()) == len(pids),
                          "the sockets of listener and workers")
        return pids, self.open_descriptors(pids), [resident(p) for p in pids]

    @staticmethod
    def open_descriptors(pids):
        """How many each process has, once they stay the same: a worker closes those of a request
        only after the reply has left."""
        seen = []

        def quiet():
            seen.append([len(daemon.descriptors(pid)) for pid in pids])
            time.sleep(0.05)
            return len(seen) >= 5 and all(counts == seen[-1] for counts in seen[-5:])

        daemon.wait_until(quiet, "descriptors to stay the same")
        return seen[-1]

    def growth(self, before, after):
        """Bytes by which a process grew at most; the processes must be the same, and have no more
        descriptors."""
        self.assertEqual(after[0], before[0], "processes")
        self.assertTrue(all(now <= then for now, then in zip(after[1], before[1])),
                        f"descriptors: {before[1]}, then {after[1]}")
        grown = [now - then for now, then in zip(after[2], before[2])]
        print(f"bytes grown by front, workers: {grown}", flush=True)
        return max(grown)

    def assert_no_leak(self, before, numbers):
        """What a large request leaves behind in pieces does not grow when the same requests come
        again; what leaks grows every time."""
        for _ in range(PASSES):
            self.send(numbers)
            after = self.settled()
            if self.growth(before, after) < GROWTH:
                return
            before = after
        self.fail(f"memory grows with every {len(numbers)} requests")

    def test_requests_without_number(self):
        print(f"http.mutation: SCATTERD_SEED={SEED} SCATTERD_MUTATIONS={MUTATIONS}", flush=True)
        first, rest = range(WARM_UP), range(WARM_UP, MUTATIONS)
        began = time.monotonic()
        statuses = self.send(first)
        before = self.settled()
        statuses += self.send(rest)
        after = self.settled()
        print(f"{dict(sorted(statuses.items()))} in {time.monotonic() - began:.1f} s", flush=True)
        self.assertEqual(sum(statuses.values()), MUTATIONS)
        self.assertNotIn("level=error", "\n".join(self.daemon.log))
        if MUTATIONS >= 1000:  # enough for every kind of damage
            self.assertGreater(statuses[200], MUTATIONS / 10)
            self.assertGreater(statuses[400], MUTATIONS / 4)
            self.assertGreater(statuses[422], MUTATIONS / 1000)
        large = self.growth(before, after) >= GROWTH
        if large and not daemon.is_sanitized():  # which looks for leaks itself
            self.assert_no_leak(after, rest)


if __name__ == "__main__":
    unittest.main()
