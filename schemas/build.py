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

import openapi
import page
import study
from openapi import JSON, OPENAPI

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
NPY = "application/x-npy"
CSV = "text/csv"
VTP = "application/vnd.vtk.vtp+xml"
AT_POINTS = {"scalar-array.json", "vector-array.json", "count-array.json"}
# Keywords of the files that OpenAPI 3.0 does not have; the second is one of OGC API - Processes.
UNKNOWN_TO_OPENAPI = ("$schema", "contentMediaType")
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
        return openapi.component(schema["$ref"].removesuffix(".json"))
    return {key: refer(value) for key, value in schema.items() if key not in UNKNOWN_TO_OPENAPI}


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
    """An input bare, as the qualified value of OGC API - Processes, or by reference."""
    others = [{"$ref": "reference.json"}, {"$ref": "encoded.json"}]
    return {"anyOf": [schema, qualified(schema), *others]}


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


def components():
    """The schemas of the OpenAPI document, by name."""
    schemas = {name.removesuffix(".json"): refer(load(name)) for name in schema_names()}
    made = {f"{name}-execution": refer(request_schema(name)) for name in PROCESSES}
    made |= {f"{name}-results": refer(result_schema(name)) for name in PROCESSES}
    if schemas.keys() & made.keys():
        raise ValueError(f"files that have the name of a component: {schemas.keys() & made.keys()}")
    schemas.update(made)
    config = schemas["um-bridge-config"]
    inputs = {key: item["schema"] for key, item in process("solve")["inputs"].items()}
    config["properties"] = {**refer(inputs), **config["properties"]}
    config["additionalProperties"] = False
    return schemas


# --- Documents ---------------------------------------------------------------------------------


def documents(version):
    """Every document by its file name."""
    found = {
        "landing.json": landing(),
        "conformance.json": conformance(),
        "processes.json": process_list(version),
        "openapi.json": openapi.document(version, TITLE, ABOUT, components(), PROCESSES),
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
