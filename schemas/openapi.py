"""The OpenAPI document: every path with its operations, parameters, headers and statuses.

One table, `paths()`, in the order of the daemon's own (`scatterd --print-routes`); what is the same
everywhere (HEAD beside GET, OPTIONS, failures of every request, headers of every answer) is added
by `complete`. Test: http.openapi, against the running daemon, both ways.
"""

JSON = "application/json"
CBOR = "application/cbor"
PROBLEM = "application/problem+json"
OPENAPI = "application/vnd.oai.openapi+json;version=3.0"
HTML = "text/html"
TEXT = "text/plain"
EVENTS = "text/event-stream"
LINES = "application/x-ndjson"
RESULTS = (JSON, CBOR, "application/x-npy", "text/csv", "application/vnd.vtk.vtp+xml")
PARTS = "multipart/related"
ASSETS = ("text/javascript", "text/css", "image/svg+xml")
OF_ASSETS = ("ETag", "Cache-Control", "Content-Encoding", "X-Content-Type-Options")
OF_PAGES = ("Content-Security-Policy", "Referrer-Policy")
BINARY = {
    "description": "The same in another form.",
    "type": "string",
    "format": "binary",
}
PAGE = {"description": "The same for reading.", "type": "string"}

FAILURES = {
    "400": "The request or one of its values is wrong; `errors` points to the culprits.",
    "401": "There is no token with the request, or not a good one; WWW-Authenticate says how to send "
    "it.",
    "403": "A web page of another origin sent this.",
    "404": "There is no such resource, it is somebody else's, or its results are not there yet.",
    "406": "None of the media types or codings accepted can be served.",
    "408": "The request did not arrive in time.",
    "409": "The same bytes are kept as another media type; or a job needs the data.",
    "410": "The job was dismissed.",
    "411": "There is no body.",
    "413": "The body is larger than the limit.",
    "414": "The address is too long.",
    "415": "The media type or content coding of the body is unknown.",
    "416": "The range is beyond the end.",
    "421": "This service is not called by the name in Host.",
    "422": "The problem is well formed but cannot be solved, or not within the memory of a worker; "
    "or an Idempotency-Key belongs to another request.",
    "429": "Too many jobs wait already, or more than the token may have or ask for; Retry-After says "
    "when to come back.",
    "431": "The header is too large.",
    "500": "The worker or the store failed.",
    "501": "The transfer coding of the body is unknown.",
    "503": "No worker is free or memory is short; Retry-After says when to come back.",
    "504": "The time limit was reached.",
    "507": "There is no room for the body or the job.",
}
# What HTTP itself may be answered, whatever the path.
OF_EVERY_REQUEST = ("400", "401", "408", "413", "414", "421", "429", "431", "501", "503", "507")
OF_EVERY_CHANGE = ("403",)
OF_TOKENS = ("401", "429")
OF_WORKERS = ("422", "500", "504")
# The headers that failures have besides those of every answer.
WAITED = ("Preference-Applied", "Content-Location")
HEADERS_OF = {"401": ["WWW-Authenticate"], "404": ["Retry-After"], "429": ["Retry-After"], "503": ["Retry-After"],
              "415": ["Accept", "Accept-Encoding"], "416": ["Content-Range", "ETag",
                                                             "Cache-Control", "Accept-Ranges",
                                                             "X-Content-Type-Options"],
              "406": ["ETag"], "422": WAITED, "500": WAITED, "504": WAITED}

ABOUT = (
    " HEAD works wherever GET does; OPTIONS tells the methods of a path. A method that a path does "
    "not know is answered 405 with Allow, any other path 404. Every failure is a problem document "
    "(RFC 9457), also readable as application/json; under the paths of UM-Bridge it is an error in "
    "its form. Where the operator wants it so, all but /healthz and /readyz need a token, as bearer "
    "token or as the password of its name; jobs and data are then there for the token that made them, "
    "for all others they do not exist."
)

TAGS = {
    "service": "What this service is.",
    "processes": "What it can do.",
    "execution": "Doing it.",
    "jobs": "Doing it later: OGC API - Processes.",
    "data": "Clouds and arrays, uploaded once for many requests.",
    "um-bridge": "Solves as models for uncertainty quantification: UM-Bridge 1.0.",
    "state": "How it does.",
}

HEADERS = {
    "X-Request-Id": "Name of this request in the log: the client's, or ours.",
    "Vary": "Fields of the request that the answer depends on.",
    "Access-Control-Allow-Origin": "The origin, if it is among those configured.",
    "Access-Control-Expose-Headers": "Fields that scripts may read.",
    "Access-Control-Allow-Methods": "Methods of this path.",
    "Access-Control-Allow-Headers": "Fields that scripts may send.",
    "Access-Control-Max-Age": "For how long this may be kept (s).",
    "Allow": "Methods of this path.",
    "Retry-After": "Time to wait before the next try (s).",
    "Accept": "Media types that a body may have.",
    "Accept-Encoding": "Codings that a body may have.",
    "Location": "Address of what was made.",
    "WWW-Authenticate": "How a token is sent: Bearer, Basic.",
    "Accept-Ranges": "bytes: parts can be had.",
    "Content-Range": "Which part this is, of how much.",
    "Content-Location": "Address at which the results stay.",
    "Preference-Applied": "Which preferences were followed.",
    "ETag": "Tag of this state, for If-None-Match.",
    "Cache-Control": "How long the answer is good.",
    "Content-Encoding": "Coding of the body: gzip or zstd.",
    "Link": "Addresses of the outputs.",
    "Content-Security-Policy": "What the page may load.",
    "Referrer-Policy": "What the page tells others of itself.",
    "X-Content-Type-Options": "That the media type is meant.",
}
ALWAYS = ("X-Request-Id", "Vary", "Access-Control-Allow-Origin", "Access-Control-Expose-Headers")


# --- Parts -------------------------------------------------------------------------------------


def component(name):
    return {"$ref": f"#/components/schemas/{name}"}


def parameter(place, name, description, schema, required=False):
    return {
        "name": name,
        "in": place,
        "description": description,
        "required": required,
        "schema": schema,
    }


def text(**more):
    return {"type": "string", **more}


def integer(low, high=None):
    return {"type": "integer", "minimum": low, **({} if high is None else {"maximum": high})}


def parameters(processes, job_processes):
    """Every parameter by the name it has among the components."""
    states = "accepted, running, successful, failed, dismissed"
    return {
        "processID": parameter("path", "processID", "Name of the process.",
                               text(enum=processes), True),
        "jobID": parameter("path", "jobID", "Name of the job.", text(minLength=1), True),
        "output": parameter("path", "output", "Name of an output; of a batch, number of a request.",
                            text(minLength=1), True),
        "asset": parameter("path", "asset", "Name of the file.", text(minLength=1), True),
        "limit": parameter("query", "limit", "How many to list at most (count).",
                           integer(1, 10000)),
        "offset": parameter("query", "offset", "How many to pass over (count).", integer(0)),
        "type": parameter("query", "type", "Kinds of jobs, with commas between or given once for "
                          "each; all are process.",
                          text()),
        "processIDs": parameter("query", "processID",
                                "Processes of the jobs, with commas between or given once for "
                                f"each: {job_processes}.",
                                text(minLength=1)),
        "status": parameter("query", "status", "States, with commas between or given once for each: "
                            f"{states}.", text()),
        "datetime": parameter("query", "datetime", "When the jobs were created: a time of RFC 3339 "
                              "or two with / between, one of which may be `..`.", text()),
        "minDuration": parameter("query", "minDuration", "Least run time (s).", integer(0)),
        "maxDuration": parameter("query", "maxDuration", "Longest run time (s).", integer(0)),
        "parent": parameter("query", "parent", "Only the requests of this batch.", text()),
        "Prefer": parameter("header", "Prefer", "RFC 7240: respond-async, wait=SECONDS, "
                            "return=minimal or representation, priority=0 to 9; what is unknown "
                            "is passed over.", text()),
        "Accept-Encoding": parameter("header", "Accept-Encoding",
                                     "gzip or zstd, if the answer may be compressed.", text()),
        "Content-Encoding": parameter("header", "Content-Encoding",
                                      "Coding of the body: gzip, zstd or identity.", text()),
        "Idempotency-Key": parameter("header", "Idempotency-Key", "A name for this request: sent "
                                     "again, it gives the same job.",
                                     text(minLength=1, maxLength=127)),
        "Cache-Control": parameter("header", "Cache-Control", "no-cache: the job is run even if an "
                                   "equal one has an answer.", text()),
        "If-None-Match": parameter("header", "If-None-Match",
                                   "ETag of what is known: 304 while it is so.", text()),
        "Last-Event-ID": parameter("header", "Last-Event-ID",
                                   "The last event that is known: the stream goes on behind it.",
                                   text()),
        "dataID": parameter("path", "dataID", "Name of the data: the digest of their bytes.",
                            text(minLength=1), True),
        "Range": parameter("header", "Range", "One part of the bytes: bytes=FIRST-LAST.", text()),
        "If-Range": parameter("header", "If-Range", "ETag: the part only if it is still that.",
                              text()),
        "X-Request-Id": parameter("header", "X-Request-Id", "A name for this request in the log: 1 "
                                  "to 64 letters, digits, `.`, `_` or `-`.", text()),
        "Origin": parameter("header", "Origin", "Of a script: where its page is from.", text()),
    }


def use(*names):
    return [{"$ref": f"#/components/parameters/{name}"} for name in names]


def headers(*names):
    return {name: {"$ref": f"#/components/headers/{name}"} for name in names}


def body(schema, *media):
    special = {HTML: PAGE, TEXT: PAGE, EVENTS: PAGE, LINES: PAGE}
    whole = {JSON, CBOR, PROBLEM, OPENAPI}
    return {
        name: {"schema": schema if name in whole else special.get(name, BINARY)} for name in media
    }


def answer(words, schema=None, *media, fields=()):
    found = {"description": words}
    if fields:
        found["headers"] = headers(*fields)
    if schema is not None:
        found["content"] = body(schema, *(media or (JSON,)))
    return found


def failures(*statuses, form=""):
    return {status: {"$ref": f"#/components/responses/{form}{status}"} for status in statuses}


def operation(identifier, tag, summary, answers, failed=(), takes=(), sends=None, calls=None,
              about=None):
    made = {"operationId": identifier, "tags": [tag], "summary": summary}
    if about:
        made["description"] = about
    if takes:
        made["parameters"] = use(*takes)
    if sends:
        made["requestBody"] = {"required": True, "content": sends}
    if calls:
        made["callbacks"] = calls
    return {**made, "responses": {**answers, **failures(*failed)}}


def get(identifier, tag, summary, schema, *failed, media=(JSON,), takes=(), fields=()):
    """A GET that has one kind of answer."""
    return {
        "get": operation(identifier, tag, summary,
                         {"200": answer(summary, schema, *media, fields=fields)}, failed, takes)
    }


# --- Paths -------------------------------------------------------------------------------------


def execution(processes):
    """The POST operation that runs a process."""
    requests = {"anyOf": [component(f"{name}-execution") for name in processes]}
    status = component("status-info")
    return {
        "post": operation(
            "execute",
            "execution",
            "Run a process: now, or later as a job.",
            {
                "200": answer("The results.", results(processes), *RESULTS, PARTS, fields=[
                    "Content-Encoding", "Accept-Ranges", *WAITED]),
                "201": answer("A job, stored.", status, fields=["Location", "Preference-Applied"]),
                "204": answer("All outputs stand elsewhere.",
                              fields=["Link", *WAITED]),
            },
            ["404", "406", "411", "415", *OF_WORKERS],
            ["Prefer", "Accept-Encoding", "Content-Encoding", "Idempotency-Key", "Cache-Control"],
            body(requests, JSON, CBOR),
            callbacks(processes),
            "Bodies are JSON or CBOR (typed arrays of RFC 8746) by Content-Type and Accept, plain, "
            "gzip or zstd by Content-Encoding and Accept-Encoding. `response` raw with one output "
            "gives its bare value, also as .npy, CSV or VTP; with several, multipart/related if it "
            "is accepted. `Prefer: respond-async` makes a job of it; with `wait` as well its "
            "results come at once if they are there in time.",
        )
    }


def callbacks(processes):
    """Whom a job calls, if its request names a subscriber."""
    def called(words, schema):
        return {"post": {
            "operationId": "called" + "".join(word.title() for word in words[:-1].split()),
            "summary": words,
            "requestBody": {"required": True, "content": body(schema, JSON)},
            "responses": {"2XX": {"description": "Understood."},
                          "4XX": {"description": "Not wanted."}},
        }}

    status, where = component("status-info"), "{$request.body#/subscriber/%s}"
    documents = {"anyOf": [component(f"{name}-results") for name in processes]}
    return {
        "success": {where % "successUri": called("The results.", documents)},
        "inProgress": {where % "inProgressUri": called("The job runs.", status)},
        "failed": {where % "failedUri": called("The job failed.", status)},
    }


def results(processes):
    """A result document, or with response raw the bare value of an output."""
    documents = [component(f"{name}-results") for name in processes]
    bare = [{"description": "A bare output.", "type": kind}
            for kind in ("number", "string", "boolean")]
    array = {"description": "A bare output.", "type": "array", "items": {}}
    return {"anyOf": [*documents, *bare, array]}


def jobs(processes):
    """The paths of jobs."""
    status, found = component("status-info"), ["404", "500"]
    of_job, ready = {"parameters": use("jobID")}, results(processes)
    fields = ["Content-Encoding", "Accept-Ranges"]
    rendered = {
        "200": answer("The results.", ready, *RESULTS, PARTS, fields=fields),
        "206": answer("A part of the bytes.", ready, *RESULTS, PARTS,
                      fields=[*fields, "Content-Range"]),
        "204": answer("All outputs stand elsewhere.", fields=["Link"]),
    }
    failed = ["404", "406", "410", "416", *OF_WORKERS]
    wanted = ["Accept-Encoding", "Range", "If-Range"]
    return {
        "/jobs": get("jobs", "jobs", "Jobs, the newest first.", component("job-list"), "406", "500",
                     takes=["limit", "offset", "type", "processIDs", "status", "datetime",
                            "minDuration", "maxDuration", "parent"]),
        "/jobs/{jobID}": {
            **of_job,
            "get": operation(
                "job", "jobs", "How far a job is.",
                {"200": answer("Its state.", status,
                               fields=["ETag", "Cache-Control", "Preference-Applied"]),
                 "304": answer("It is as it was.",
                               fields=["ETag", "Cache-Control", "Preference-Applied"])},
                [*found, "406"], ["Prefer", "If-None-Match"],
                about="With `Prefer: wait` the answer comes when the job is over, with "
                "If-None-Match as well when its state is another, or when the time is."),
            "delete": operation("dismiss", "jobs", "Stop a job, or drop its results.",
                                {"200": answer("What is left of it.", status)},
                                [*found, "410"]),
        },
        "/jobs/{jobID}/events": {
            **of_job,
            "get": operation(
                "events", "jobs", "What happens to a job, as it happens.",
                {"200": answer("Server-sent events: `status` with the whole state, `progress` and "
                               "`phase`.", {}, EVENTS, fields=["Cache-Control"]),
                 "204": answer("It is over, and the last event is known.")},
                [*found, "406"], ["Last-Event-ID"]),
        },
        "/jobs/{jobID}/results": {
            **of_job,
            "get": operation(
                "results", "jobs", "The results of a job.",
                {**rendered, "200": answer(
                    "The results; of a batch those of each request, as lines in the order in which "
                    "they end.", ready, *RESULTS, PARTS, LINES, fields=fields)},
                failed, wanted,
                about="Of a failed job: the problem that it failed of, with its status."),
        },
        "/jobs/{jobID}/results/{output}": {
            "parameters": use("jobID", "output"),
            "get": operation("output", "jobs", "One output of a job.",
                             {"200": rendered["200"], "206": rendered["206"]}, failed, wanted),
        },
    }


def data():
    """The paths of data."""
    kinds = (JSON, CBOR, "application/x-npy", "text/csv")
    known = ["ETag", "Cache-Control", "Accept-Ranges", "X-Content-Type-Options"]
    kept = component("data-object")
    return {
        "/data": {"post": operation(
            "upload", "data", "Keep a cloud, an array or any value, for use as {\"href\"}.",
            {"200": answer("It is here already.", kept, fields=["Location"]),
             "201": answer("It is kept.", kept, fields=["Location"])},
            ["406", "409", "411", "415", *OF_WORKERS], ["Content-Encoding"],
            body({}, *kinds))},
        "/data/{dataID}": {
            "parameters": use("dataID"),
            "get": operation(
                "data", "data", "The bytes.",
                {"200": answer("All of them.", {}, *kinds, fields=known),
                 "206": answer("A part.", {}, *kinds, fields=[*known, "Content-Range"]),
                 "304": answer("They are known.", fields=known)},
                ["404", "406", "416", "500"], ["If-None-Match", "Range", "If-Range"]),
            "delete": operation("dropData", "data", "Forget them.",
                                {"204": answer("They are forgotten.")}, ["404", "409", "500"]),
        },
    }


MODEL_ERRORS = {
    "400": "ModelNotFound, UnsupportedFeature or InvalidInput, looked at in that order.",
    "500": "InvalidOutput: the solve failed.",
}


def model(identifier, summary, sends, gives):
    """A POST of UM-Bridge."""
    good = {"200": answer(summary, component(gives))} if gives else {}
    made = operation(identifier, "um-bridge", summary, good)
    # UM-Bridge requires no Content-Type: whatever it says, the body is read as JSON.
    made["requestBody"] = {"required": True, "content": {"*/*": {"schema": component(sends)}}}
    for status, words in MODEL_ERRORS.items():
        made["responses"][status] = answer(words, component("um-bridge-error"))
    return {"post": made}


def models():
    """The paths of UM-Bridge."""
    return {
        "/Info": get("modelServer", "um-bridge", "The models.", component("um-bridge-info")),
        "/ModelInfo": model("modelInfo", "What a model can do.", "um-bridge-name",
                            "um-bridge-model"),
        "/InputSizes": model("inputSizes", "Lengths of the input vectors.", "um-bridge-sizes",
                             "um-bridge-input-sizes"),
        "/OutputSizes": model("outputSizes", "Lengths of the output vectors.", "um-bridge-sizes",
                              "um-bridge-output-sizes"),
        "/Evaluate": model("evaluate", "The output vectors.", "um-bridge-evaluate",
                           "um-bridge-vectors"),
        "/Gradient": model("gradient", "J^T sens, by an adjoint solve.", "um-bridge-gradient",
                           "um-bridge-vector"),
        "/ApplyJacobian": model("applyJacobian", "J vec, by a tangent solve.",
                                "um-bridge-jacobian", "um-bridge-vector"),
        "/ApplyHessian": model("applyHessian", "Not supported by any model.", "um-bridge-name",
                               None),
    }


def for_everybody(item):
    """A path that needs no token."""
    item["get"]["security"] = []
    return item


def paths(processes):
    health, state = component("health"), "state"
    document = {"description": "This document.", "type": "object"}
    of_process = {"parameters": use("processID")}
    described = get("description", "processes", "One process with its inputs and outputs.",
                    component("process-description"), "404", "406")
    return {
        "/": {"get": operation(
            "landing", "service", "Landing page; for a browser the dashboard.",
            {"200": answer("The page.", component("landing"), JSON, HTML,
                           fields=[*OF_ASSETS, *OF_PAGES]),
             "304": answer("It is as it was.", fields=[*OF_ASSETS, *OF_PAGES])},
            ["406"], ["Accept-Encoding", "If-None-Match"])},
        "/assets/{asset}": {
            "parameters": use("asset"),
            "get": operation("asset", "service", "A file of the dashboard.",
                             {"200": answer("The file.", {}, *ASSETS, fields=OF_ASSETS),
                              "304": answer("It is as it was.", fields=OF_ASSETS)},
                             ["404"], ["Accept-Encoding", "If-None-Match"]),
        },
        "/api": get("api", "service", "This document.", document, "406",
                    media=(OPENAPI, JSON, HTML), fields=["X-Content-Type-Options", *OF_PAGES]),
        "/conformance": get("conformance", "service", "Conformance classes.",
                            component("conformance"), "406"),
        "/processes": get("processes", "processes", "The processes.", component("process-list"),
                          "406", takes=["limit"]),
        "/processes/{processID}": {**of_process, **described},
        "/processes/{processID}/execution": {**of_process, **execution(processes)},
        **jobs(processes),
        **data(),
        **models(),
        "/healthz": for_everybody(get("health", state, "Whether the daemon lives.", health)),
        "/readyz": for_everybody(get("ready", state, "Whether requests are answered: workers are up, "
                                     "queues have room, the store can be written.", health)),
        "/metrics": get("metrics", state, "Counters for Prometheus, text format 0.0.4.", {},
                        media=(TEXT,)),
    }


# --- What is the same everywhere ---------------------------------------------------------------


def head_of(made):
    """HEAD: a GET whose answer has no body, and no part of one."""
    answers = {status: {key: value for key, value in found.items() if key != "content"}
               for status, found in made["responses"].items() if status not in ("206", "416")}
    return {
        **made,
        "operationId": made["operationId"] + "Head",
        "summary": "The header of GET alone.",
        "responses": answers,
    }


def options_of(first):
    """OPTIONS: the methods of a path, for web pages of other origins."""
    told = ["Allow", "Access-Control-Allow-Methods", "Access-Control-Allow-Headers",
            "Access-Control-Max-Age"]
    return operation(first["operationId"] + "Options", first["tags"][0],
                     "The methods of this path.",
                     {"204": answer("Allow names them.", fields=told)}) | {"security": []}


def complete(item):
    """A path with HEAD and OPTIONS, and what every operation takes and answers."""
    methods = [item[name] for name in ("get", "post", "delete") if name in item]
    if "get" in item:
        item["head"] = head_of(item["get"])
    item["options"] = options_of(methods[0])
    for name in ("post", "delete"):
        if name in item:
            item[name]["responses"] |= failures(*OF_EVERY_CHANGE, form=form_of(item[name]))
    for name in ("get", "head", "post", "delete", "options"):
        if name in item:
            finish(item[name])
    return item


def form_of(made):
    """Prefix of the failures of an operation."""
    return "model-" if "um-bridge" in made["tags"] else ""


def failures_of(made):
    """Which failures an operation has whatever it does."""
    is_open = made.get("security") == []
    return [status for status in OF_EVERY_REQUEST if not (is_open and status in OF_TOKENS)]


def finish(made):
    made["parameters"] = [*made.get("parameters", []), *use("X-Request-Id", "Origin")]
    for status, found in failures(*failures_of(made), form=form_of(made)).items():
        made["responses"].setdefault(status, found)
    for found in made["responses"].values():
        if "$ref" not in found:
            found["headers"] = {**headers(*ALWAYS), **found.get("headers", {})}
    made["responses"] = dict(sorted(made["responses"].items()))


def responses():
    """The failures, which all operations share."""
    def fields(status):
        return [*ALWAYS, *HEADERS_OF.get(status, [])]

    problem, error = component("problem"), component("um-bridge-error")
    return {
        **{status: answer(words, problem, PROBLEM, JSON, fields=fields(status))
           for status, words in FAILURES.items()},
        **{f"model-{status}": answer(FAILURES[status], error, fields=fields(status))
           for status in (*OF_EVERY_REQUEST, *OF_EVERY_CHANGE)},
    }


def document(version, title, about, schemas, processes):
    """The whole document; `schemas` are its components, made of files by build.py."""
    listed = ", ".join(processes)
    return {
        "openapi": "3.0.3",
        "info": {
            "title": title,
            "description": about + ABOUT,
            "version": version,
            "license": {
                "name": "GPL-2.0-or-later",
                "url": "https://www.gnu.org/licenses/old-licenses/gpl-2.0.html",
            },
        },
        "servers": [{"url": "{B}"}],
        "security": [{"bearer": []}, {"basic": []}, {}],
        "tags": [{"name": name, "description": words} for name, words in TAGS.items()],
        "paths": {path: complete(item) for path, item in paths(processes).items()},
        "components": {
            "schemas": dict(sorted(schemas.items())),
            "parameters": parameters(processes, listed),
            "headers": {name: {"description": words, "schema": text()}
                        for name, words in HEADERS.items()},
            "responses": responses(),
            "securitySchemes": {
                "bearer": {"type": "http", "scheme": "bearer",
                           "description": "The secret of a token."},
                "basic": {"type": "http", "scheme": "basic",
                          "description": "The name of a token and its secret."},
            },
        },
    }
