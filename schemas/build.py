#!/usr/bin/env python3
"""Makes the documents that the daemon serves out of the schema files beside this script.

    build.py [--version V] OUTPUT_DIRECTORY

writes landing.json, conformance.json, processes.json, processes/<id>.json, openapi.json and
api.html. Absolute links begin with {B}, which the daemon replaces by its own address. The schema
files refer to each other by {"$ref": "cloud.json"}; process descriptions have these resolved.
Needs the standard library only. Tests import it for load(), inline(), request_schema() and
result_schema().
"""

import argparse
import json
import pathlib

import page
import study

HERE = pathlib.Path(__file__).resolve().parent
RELATION = "http://www.opengis.net/def/rel/ogc/1.0/"
CONFORMANCE = "http://www.opengis.net/spec/ogcapi-processes-1/1.0/conf/"
CLASSES = ["core", "json", "oas30", "ogc-process-description", "job-list", "dismiss", "callback"]
PROCESSES = ["solve", "apply", "diagnose", "study", "flow", "echo", "batch"]
CONTROL = ["sync-execute", "async-execute", "dismiss"]
CASES = [
    *("laplace", "smooth", "gartland", "smith-hutton", "skew", "three-point"),
    *("sine-1d", "sine-2d", "sine-3d", "diffusion-1d", "diffusion-2d", "diffusion-3d"),
    *("cavity", "step"),
]
JSON = "application/json"
CBOR = "application/cbor"
NPY = "application/x-npy"
CSV = "text/csv"
VTP = "application/vnd.vtk.vtp+xml"
MULTIPART = "multipart/related"
AT_POINTS = {"scalar-array.json", "vector-array.json", "count-array.json"}
PROBLEM = "application/problem+json"
OPENAPI = "application/vnd.oai.openapi+json;version=3.0"
HTML = "text/html"
NDJSON = "application/x-ndjson"
EVENTS = "text/event-stream"
PAGE = {"description": "The same for reading.", "type": "string"}
TITLE = "scatterd"
ABOUT = "Partial differential equations solved on scattered particle clouds, over HTTP."


# --- Schemas -----------------------------------------------------------------------------------


def load(name):
    """The schema file of that name, such as cloud.json, as it stands."""
    return json.loads((HERE / name).read_text(encoding="utf-8"))


def schema_names():
    """Names of all schema files."""
    return sorted(path.name for path in HERE.glob("*.json"))


def process(name):
    """Source of a process description; that of study is completed from its cases."""
    source = load(f"processes/{name}.json")
    return study.complete(source, cases()) if name == "study" else source


def cases():
    """The cases of study by name."""
    return {name: load(f"cases/{name}.json") for name in CASES}


def inline(schema):
    """The schema with every $ref replaced by what it refers to, and without $schema."""
    if isinstance(schema, list):
        return [inline(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    if "$ref" in schema:
        return inline(load(schema["$ref"]))
    whole = {key: inline(value) for key, value in schema.items() if key != "$schema"}
    return merged(whole)


def merged(schema):
    """{"description": .., "allOf": [one]} is how a reference gets a description of its own."""
    if len(schema.get("allOf", [])) != 1:
        return schema
    own = {key: value for key, value in schema.items() if key != "allOf"}
    return {**schema["allOf"][0], **own}


def refer(schema):
    """The schema with every $ref turned to the components of an OpenAPI document."""
    if isinstance(schema, list):
        return [refer(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    if "$ref" in schema:
        return component(schema["$ref"].removesuffix(".json"))
    return {key: refer(value) for key, value in schema.items() if key != "$schema"}


def component(name):
    return {"$ref": f"#/components/schemas/{name}"}


def object_schema(properties, required, description):
    schema = {"type": "object", "description": description, "additionalProperties": False}
    if required:
        schema["required"] = required
    return {**schema, "properties": properties}


def names_required(members):
    return [name for name, member in members.items() if member.get("required")]


def is_object(schema):
    """Whether values of this schema are objects, which a result document puts under "value"."""
    return inline(schema).get("type") == "object"


def input_schema(schema):
    """An input bare, or as the qualified value of OGC API - Processes."""
    return {"anyOf": [schema, qualified(schema), {"$ref": "reference.json"}]}


def qualified(schema):
    members = {
        "value": schema,
        "mediaType": {"description": "Media type of the value.", "type": "string"},
        "encoding": {"description": "Encoding of the value.", "type": "string"},
        "schema": {"description": "Schema the value follows."},
    }
    return object_schema(members, ["value"], "The value with what qualifies it.")


def request_schema(name):
    """Schema of the body of an execute request, with references between files."""
    source = process(name)
    inputs = {key: input_schema(item["schema"]) for key, item in source["inputs"].items()}
    outputs = {key: {"$ref": "output-request.json"} for key in source["outputs"]}
    response = {
        "description": "document: all outputs in one object; raw: one output bare.",
        "type": "string",
        "enum": ["document", "raw"],
        "default": "document",
    }
    members = {
        "inputs": object_schema(inputs, names_required(source["inputs"]), "Inputs by name."),
        "outputs": object_schema(outputs, [], "Outputs wanted; left out: all there are."),
        "response": response,
        "subscriber": {"$ref": "subscriber.json"},
    }
    about = f"Execute request of {name}; members not named here are passed over."
    return {"type": "object", "description": about, "required": ["inputs"], "properties": members}


def result_schema(name):
    """Schema of the result document of a process, with references between files."""
    outputs = process(name)["outputs"]
    return {
        "type": "object",
        "description": f"Results of {name}: those wanted, objects under `value`.",
        "properties": {key: output_schema(item["schema"]) for key, item in outputs.items()},
    }


def output_schema(schema):
    """An output in a result document: by value, or as the request asked for it."""
    if is_object(schema):
        schema = {
            "type": "object",
            "description": "The object under `value`.",
            "required": ["value"],
            "properties": {"value": schema},
        }
    return {"anyOf": [schema, {"$ref": "encoded.json"}, {"$ref": "reference.json"}]}


# --- Process descriptions ----------------------------------------------------------------------


def link(path, rel, media, title):
    return {"href": "{B}" + path, "rel": rel, "type": media, "title": title}


def summary(name, version):
    source = process(name)
    return {
        "id": name,
        "title": source["title"],
        "description": source["description"],
        "version": version,
        "keywords": source["keywords"],
        "jobControlOptions": source.get("control", CONTROL),
        "outputTransmission": source.get("transmission", ["value", "reference"]),
        "links": [
            link(f"/processes/{name}", "self", JSON, "Description of this process"),
            link(f"/processes/{name}/execution", RELATION + "execute", JSON, "Run this process"),
        ],
    }


def description(name, version):
    source = process(name)
    whole = summary(name, version)
    links = whole.pop("links") + [link("/processes", "up", JSON, "All processes")]
    inputs = {key: described_input(item) for key, item in source["inputs"].items()}
    outputs = {key: described_output(item) for key, item in source["outputs"].items()}
    return {**whole, "inputs": inputs, "outputs": outputs, "links": links}


def described(item):
    return {
        "title": item["title"],
        "description": item["description"],
        "schema": inline(item["schema"]),
    }


def forms(schema):
    """The media types other than JSON and CBOR that one output can be had in."""
    if schema.get("$ref") in AT_POINTS:
        return [NPY, CSV, VTP]
    is_numbers = schema.get("items", {}).get("type") in ("number", "integer")
    return [NPY, CSV] if is_numbers else []


def described_output(item):
    whole = described(item)
    more = [{"description": f"The same as {media}.", "type": "string", "format": "binary",
             "contentMediaType": media} for media in forms(item["schema"])]
    return {**whole, "schema": {"oneOf": [whole["schema"], *more]} if more else whole["schema"]}


def described_input(item):
    return {**described(item), "minOccurs": 1 if item.get("required") else 0, "maxOccurs": 1}


def process_list(version):
    return {
        "processes": [summary(name, version) for name in PROCESSES],
        "links": [link("/processes", "self", JSON, "This list")],
    }


def landing():
    return {
        "title": TITLE,
        "description": ABOUT,
        "links": [
            link("/", "self", JSON, "This page"),
            link("/api", "service-desc", OPENAPI, "The interface, as OpenAPI"),
            link("/api", "service-doc", "text/html", "The interface, for reading"),
            link("/conformance", "conformance", JSON, "Conformance classes"),
            link("/conformance", RELATION + "conformance", JSON, "Conformance classes"),
            link("/processes", RELATION + "processes", JSON, "The processes"),
            link("/jobs", RELATION + "job-list", JSON, "The jobs"),
        ],
    }


def conformance():
    return {"conformsTo": [CONFORMANCE + name for name in CLASSES]}


# --- OpenAPI -----------------------------------------------------------------------------------

FAILURES = {
    "400": "The request or one of its values is wrong; `errors` points to the culprits.",
    "404": "There is no such resource.",
    "406": "None of the media types or codings accepted can be served.",
    "408": "The request did not arrive in time.",
    "409": "Something stands in the way: other bytes, or a job that needs it.",
    "410": "The job was dismissed.",
    "411": "There is no body.",
    "413": "The body is larger than the limit.",
    "414": "The address is too long.",
    "415": "The media type or content coding of the body is unknown.",
    "422": "The problem is well formed but cannot be solved, or not within the memory of a worker.",
    "429": "Too many jobs wait; Retry-After says when to come back.",
    "431": "The header is too large.",
    "500": "The worker failed.",
    "501": "The transfer coding of the body is unknown.",
    "503": "No worker is free or memory is short; Retry-After says when to come back.",
    "504": "The time limit was reached.",
    "507": "There is no room for the body.",
}
OF_EVERY_REQUEST = ("400", "408", "414", "431", "503")
OF_EXECUTION = ("404", "406", "411", "413", "415", "422", "429", "500", "501", "504", "507")
ABOUT_PATHS = (
    " HEAD works wherever GET does; OPTIONS tells the methods of a path. A method that a path does "
    "not know is answered 405 with Allow, any other path 404. Every failure is a problem document "
    "(RFC 9457), also readable as application/json."
)


def body(schema, *media):
    return {name: {"schema": PAGE if name == HTML else schema} for name in media}


def answer(text, schema, *media):
    return {"description": text, "content": body(schema, *media)}


def failures(*statuses):
    return {status: {"$ref": f"#/components/responses/{status}"} for status in statuses}


def get(identifier, tag, text, schema, *statuses, media=(JSON,), parameters=()):
    """A GET operation: its identifier, subject, sentence, schema and failures."""
    failed = failures(*OF_EVERY_REQUEST, *statuses)
    operation = {
        "operationId": identifier,
        "tags": [tag],
        "summary": text,
        "responses": {"200": answer(text, schema, *media), **failed},
    }
    if parameters:
        operation["parameters"] = list(parameters)
    return {"get": operation, "head": head_of(operation), "options": options(identifier, tag)}


def head_of(operation):
    """HEAD: a GET whose answer has no body."""
    found = {"description": operation["responses"]["200"]["description"]}
    return {
        **operation,
        "operationId": operation["operationId"] + "Head",
        "summary": "The header of GET alone.",
        "responses": {**operation["responses"], "200": found},
    }


def options(identifier, tag):
    """OPTIONS: the methods of a path, for web pages of other origins."""
    return {
        "operationId": identifier + "Options",
        "tags": [tag],
        "summary": "The methods of this path.",
        "responses": {"204": {"description": "Allow names them."}, **failures(*OF_EVERY_REQUEST)},
    }


def parameter_limit():
    return {
        "name": "limit",
        "in": "query",
        "description": "How many processes to list at most (count); left out: all.",
        "required": False,
        "schema": {"type": "integer", "minimum": 1, "maximum": 10000},
    }


def parameter_process():
    return {
        "name": "processID",
        "in": "path",
        "description": "Name of the process.",
        "required": True,
        "schema": {"type": "string", "enum": PROCESSES},
    }


def query(name, text, schema):
    return {"name": name, "in": "query", "description": text, "required": False, "schema": schema}


def field(name, text):
    """A field of the request's header."""
    text_schema = {"type": "string"}
    return {"name": name, "in": "header", "description": text, "required": False,
            "schema": text_schema}


def path_part(name, text):
    text_schema = {"type": "string"}
    return {"name": name, "in": "path", "description": text, "required": True,
            "schema": text_schema}


def list_of(*names):
    return {"type": "array", "items": {"type": "string", **({"enum": list(names)} if names else {})}}


def job_filters():
    count = {"type": "integer", "minimum": 0}
    states = ("accepted", "running", "successful", "failed", "dismissed")
    found = [
        query("limit", "Entries of a page (count).",
              {"type": "integer", "minimum": 1, "maximum": 10000, "default": 10}),
        query("offset", "Entries before the page (count).", {**count, "default": 0}),
        query("type", "Kinds of jobs, with commas.", list_of("process")),
        query("processID", "Processes, with commas.", list_of()),
        query("status", "States, with commas.", list_of(*states)),
        query("datetime", "When they were accepted: a time of RFC 3339, or two with / between, one "
              "of which may be `..`.", {"type": "string"}),
        query("minDuration", "Least time from start to end (s).", count),
        query("maxDuration", "Most time from start to end (s).", count),
        query("parent", "The requests of this batch in place of all other jobs.",
              {"type": "string"}),
    ]
    return [{**one, "style": "form", "explode": False} if one["schema"]["type"] == "array" else one
            for one in found]


def dismissal():
    return {
        "operationId": "dismiss",
        "tags": ["jobs"],
        "summary": "Stop a job, or drop its results.",
        "responses": {
            "200": answer("Its last status.", component("status-info"), JSON),
            **failures(*OF_EVERY_REQUEST, "404", "410", "500", "507"),
        },
    }


def job_paths():
    """What is under /jobs."""
    value = {"description": "Results, in the form that was asked for."}
    known = field("If-None-Match", "An ETag: 304 if nothing has changed since.")
    wait = field("Prefer", "wait=N: the answer may come up to N seconds later, when the job is over "
                 "or, with If-None-Match, has changed.")
    of_job = {"parameters": [path_part("jobID", "Name of the job.")]}
    of_output = {"parameters": [*of_job["parameters"], path_part(
        "output", "Name of the output; of a batch: number of the request, from 0.")]}
    status = get("status", "jobs", "How far a job is.", component("status-info"), "404", "406",
                 "500", parameters=[wait, known])
    status["get"]["responses"]["304"] = status["head"]["responses"]["304"] = {
        "description": "Nothing has changed."}
    gone = ("404", "406", "410", "422", "500", "504", "507")
    every_form = (JSON, CBOR, VTP, CSV, MULTIPART, NDJSON)
    results = get("results", "jobs", "The results of a successful job, or why it failed.", value,
                  *gone, media=every_form)
    output = get("result", "jobs", "One output of a successful job.", value, *gone,
                 media=(JSON, CBOR, NPY, VTP, CSV), parameters=[RANGE])
    output["get"]["responses"].update(PARTS)
    results["get"]["responses"]["204"] = {"description": NO_VALUES}
    events = get("events", "jobs", "What happens to a job, as it happens.",
                 {"type": "string", "description": "Server-sent events status, progress, phase."},
                 "404", "406", media=(EVENTS,), parameters=[
                     field("Last-Event-ID", "The last event known: those after it are sent.")])
    events["get"]["responses"]["204"] = events["head"]["responses"]["204"] = {
        "description": "The job is over and the client knows."}
    every = get("jobs", "jobs", "The jobs, the newest first.", component("job-list"), "406", "500",
                parameters=job_filters())
    return {
        "/jobs": every,
        "/jobs/{jobID}": {**of_job, **status, "delete": dismissal()},
        "/jobs/{jobID}/results": {**of_job, **results},
        "/jobs/{jobID}/results/{output}": {**of_output, **output},
        "/jobs/{jobID}/events": {**of_job, **events},
    }


NO_VALUES = "response raw, all outputs by reference: Link fields tell where they are."
RANGE = field("Range", "bytes=FIRST-LAST: a part of the bytes.")
PARTS = {
    "206": {"description": "The part that Range asked for."},
    "416": {"description": "Range lies outside of what there is."},
}


def upload():
    """POST /data."""
    known = answer("It was there before; it stays longer now.", component("data-object"), JSON)
    made = answer("It is kept.", component("data-object"), JSON)
    made["headers"] = {"Location": {"description": "Where it is.", "schema": {"type": "string"}}}
    anything = {"description": "A cloud, or an array of numbers."}
    failed = failures(*OF_EVERY_REQUEST, "406", "409", "411", "413", "415", "422", "500", "501",
                      "504", "507")
    operation = {
        "operationId": "upload",
        "tags": ["data"],
        "summary": "Keep a cloud or an array, to be used in many requests.",
        "description": "Content-addressed: the same bytes are one object. It expires (data-seconds) "
        "unless it is uploaded again, or a job that waits or runs refers to it.",
        "requestBody": {"required": True, "content": body(anything, JSON, CBOR, NPY, CSV)},
        "responses": {"200": known, "201": made, **failed},
    }
    return {"post": operation, "options": options("upload", "data")}


def data_paths():
    """What is under /data."""
    anything = {"description": "The bytes as they were uploaded."}
    of_object = {"parameters": [path_part("id", "SHA-256 of the bytes, hexadecimal.")]}
    one = get("data", "data", "An object.", anything, "404", "406", "500",
              media=(JSON, CBOR, NPY, CSV),
              parameters=[RANGE, field("If-Range", "An ETag: the part only if it is this."),
                          field("If-None-Match", "An ETag: 304 if it is this.")])
    one["get"]["responses"].update(PARTS)
    for method in ("get", "head"):
        one[method]["responses"]["304"] = {"description": "It is what the client has."}
    removal = {
        "operationId": "remove",
        "tags": ["data"],
        "summary": "Forget an object.",
        "responses": {"204": {"description": "It is gone."},
                      **failures(*OF_EVERY_REQUEST, "404", "409", "500", "507")},
    }
    return {"/data": upload(), "/data/{id}": {**of_object, **one, "delete": removal}}


def callbacks():
    def called(text, schema):
        operation = {
            "summary": text,
            "requestBody": {"content": body(schema, JSON)},
            "responses": {"2XX": {"description": "Understood."}},
        }
        return {"post": operation}

    status = component("status-info")
    results = {"anyOf": [component(f"{name}-result") for name in PROCESSES]}
    where = "{$request.body#/subscriber/%s}"
    return {
        "success": {where % "successUri": called("The results.", results)},
        "inProgress": {where % "inProgressUri": called("The job runs.", status)},
        "failed": {where % "failedUri": called("The job failed.", status)},
    }


def created():
    text = {"type": "string"}
    found = answer("A job was made of it.", component("status-info"), JSON)
    found["headers"] = {
        "Location": {"description": "Address of the job.", "schema": text},
        "Preference-Applied": {"description": "What was done of Prefer.", "schema": text},
    }
    return found


def execution():
    """The POST operation that runs a process."""
    requests = {"anyOf": [component(f"{name}-request") for name in PROCESSES]}
    results = {"anyOf": [component(f"{name}-result") for name in PROCESSES]}
    failed = failures(*OF_EVERY_REQUEST, *OF_EXECUTION)
    operation = {
        "operationId": "execute",
        "tags": ["execution"],
        "summary": "Run a process, and wait for its results or not.",
        "description": "Bodies are JSON or CBOR (typed arrays of RFC 8746) by Content-Type and "
        "Accept, plain, gzip or zstd by Content-Encoding and Accept-Encoding. `response` raw with "
        "one output gives its bare value, of an array also as .npy; with several multipart/related if "
        "asked for. Values per point come as CSV and VTP too. With `Prefer: respond-async` the request becomes a job; a "
        "batch always does.",
        "parameters": [
            field("Prefer", "respond-async: make it a job; wait=N: answer with the results if they "
                  "are there within N seconds; return=minimal or representation; priority=0 to 9 "
                  "(5): 9 goes first."),
            field("Idempotency-Key", "A job is made once for each key, however often it is asked "
                  "for."),
            field("Cache-Control", "no-cache: the job is not to be answered with the stored "
                  "result of an equal request."),
        ],
        "callbacks": callbacks(),
        "requestBody": {"required": True, "content": body(requests, JSON, CBOR)},
        "responses": {
            "200": answer("The results.", results, JSON, CBOR, NPY, VTP, CSV, MULTIPART),
            "201": created(),
            "204": {"description": NO_VALUES},
            **failed,
        },
    }
    return {"post": operation, "options": options("execute", "execution")}


def paths():
    health = component("health")
    landed = component("landing")
    home = get("landing", "service", "Landing page.", landed, "406", media=(JSON, HTML))
    document = {"description": "This document.", "type": "object"}
    api = get("api", "service", "This document.", document, "406", media=(OPENAPI, JSON, HTML))
    one = get(
        "description",
        "processes",
        "One process with its inputs and outputs.",
        component("process-description"),
        "404",
        "406",
    )
    every = get(
        "processes",
        "processes",
        "The processes.",
        component("process-list"),
        "406",
        parameters=[parameter_limit()],
    )
    conforms = component("conformance")
    of_process = {"parameters": [parameter_process()]}
    return {
        "/": home,
        "/api": api,
        "/conformance": get("conformance", "service", "Conformance classes.", conforms, "406"),
        "/processes": every,
        "/processes/{processID}": {**of_process, **one},
        "/processes/{processID}/execution": {**of_process, **execution()},
        **job_paths(),
        **data_paths(),
        "/healthz": get("health", "state", "Whether the daemon lives.", health),
        "/readyz": get("ready", "state", "Whether requests are answered.", health),
    }


def components():
    schemas = {name.removesuffix(".json"): refer(load(name)) for name in schema_names()}
    for name in PROCESSES:
        schemas[f"{name}-request"] = refer(request_schema(name))
        schemas[f"{name}-result"] = refer(result_schema(name))
    problem = component("problem")
    responses = {code: answer(text, problem, PROBLEM, JSON) for code, text in FAILURES.items()}
    for status in ("429", "503"):
        responses[status]["headers"] = {
            "Retry-After": {"description": "Time to wait (s).", "schema": {"type": "integer"}}
        }
    return {"schemas": dict(sorted(schemas.items())), "responses": responses}


def openapi(version):
    return {
        "openapi": "3.0.3",
        "info": {
            "title": TITLE,
            "description": ABOUT + ABOUT_PATHS,
            "version": version,
            "license": {
                "name": "GPL-2.0-or-later",
                "url": "https://www.gnu.org/licenses/old-licenses/gpl-2.0.html",
            },
        },
        "servers": [{"url": "{B}"}],
        "tags": [
            {"name": "service", "description": "What this service is."},
            {"name": "processes", "description": "What it can do."},
            {"name": "execution", "description": "Doing it."},
            {"name": "jobs", "description": "Doing it later."},
            {"name": "data", "description": "What requests have in common."},
            {"name": "state", "description": "How it does."},
        ],
        "paths": paths(),
        "components": components(),
    }


# --- Documents ---------------------------------------------------------------------------------


def documents(version):
    """Every document by its file name."""
    found = {
        "landing.json": landing(),
        "conformance.json": conformance(),
        "processes.json": process_list(version),
        "openapi.json": openapi(version),
    }
    for name in PROCESSES:
        found[f"processes/{name}.json"] = description(name, version)
    return found


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description="Make the documents that scatterd serves.")
    parser.add_argument("--version", default="0.0.0", help="version of scatterd")
    parser.add_argument("directory", type=pathlib.Path, help="where to write them")
    options = parser.parse_args()
    made = documents(options.version)
    for name, document in made.items():
        text = json.dumps(document, ensure_ascii=False, separators=(",", ":"))
        write(options.directory / name, text + "\n")
    described = [made[f"processes/{name}.json"] for name in PROCESSES]
    write(options.directory / "api.html", page.page(made["openapi.json"], described))


if __name__ == "__main__":
    main()
