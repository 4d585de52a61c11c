"""What a daemon was asked for, and what became of it: nothing that it accepted may be lost. For the
worker of stub_answer.c, whose results are the requests.

    accepted = {}
    accounting.work(server, accepted)
    failures = accounting.account(server, accepted, may_fail=True)
"""

import itertools

import daemon

LARGE = 20000 * " "  # above what stands in the store itself
REFUSALS = (500, 503, 507)
count = itertools.count()


def submit(server, accepted, body, refusals=REFUSALS):
    """What was accepted goes into the dictionary; what was not has been refused properly."""
    reply = server.request("POST", daemon.EXECUTE, body,
                           {"Content-Type": "application/json", "Prefer": "respond-async"})
    assert reply.status in (201, *refusals), (reply.status, reply.body)
    if reply.status == 201:
        accepted[reply.json["jobID"]] = body
        return reply.json["jobID"]
    return None


def ended(server, job):
    return server.request("GET", f"/jobs/{job}", headers={"Prefer": "wait=30"})


def account(server, accepted, may_fail, refusals=REFUSALS):
    """Every accepted job has its result; or, where it may, has failed with a reason."""
    failures = 0
    for job, body in accepted.items():
        info = daemon.wait_until(
            lambda: (lambda r: r.status == 200 and r.json["status"] not in ("accepted", "running")
                     and r.json)(ended(server, job)), f"the end of {job}")
        reply = server.request("GET", f"/jobs/{job}/results")
        if info["status"] == "failed":
            assert may_fail and reply.status in refusals, (info, reply.status, reply.body)
            failures += 1
        else:
            assert (info["status"], reply.status) == ("successful", 200), (info, reply.body)
            assert reply.body.decode() == body, (job, reply.body[:50])
    return failures


def work(server, accepted, refusals=REFUSALS):
    """Everything that touches the disk; true if all of it went well."""
    k = next(count)
    good = submit(server, accepted, f"small {k}", refusals) is not None
    job = submit(server, accepted, f"large {k}" + LARGE, refusals)
    good &= job is not None
    if job:
        good &= ended(server, job).status == 200
    upload = server.request("POST", "/data", f"[{k}, 1, 2]", {"Content-Type": "application/json"})
    assert upload.status in (200, 201, *refusals), upload.body
    spooled = server.request("POST", daemon.EXECUTE, f"spooled {k}" + 100000 * " ",
                             {"Content-Type": "application/json"})
    assert spooled.status in (200, *refusals), spooled.body
    gone = submit(server, {}, f"gone {k}" + LARGE, refusals)
    if gone:
        dismissed = server.request("DELETE", f"/jobs/{gone}")
        assert dismissed.status in (200, *refusals), dismissed.body
        good &= dismissed.status == 200
    return good and upload.status in (200, 201) and spooled.status == 200 and gone is not None
