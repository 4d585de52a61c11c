#!/usr/bin/env python3
"""Schema files, the documents made from them and the examples, against each other. No daemon."""

import json
import pathlib
import re
import sys
import unittest

from jsonschema import Draft4Validator

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "schemas"))
import build  # noqa: E402  (found by the line above)
import openapi  # noqa: E402
import page  # noqa: E402

DRAFT = "http://json-schema.org/draft-04/schema#"
# What OpenAPI 3.0 knows of a schema object and JSON Schema draft 4 reads alike; and the one
# keyword OGC API - Processes adds for strings that hold a document.
KEYWORDS = set(
    "title description type properties required additionalProperties items minItems maxItems "
    "minLength minimum maximum exclusiveMinimum exclusiveMaximum enum default format oneOf anyOf "
    "allOf not contentMediaType".split()
)
DOCUMENTS = build.documents("1.2.3")
SCHEMA_OF = {
    "landing.json": "landing.json",
    "conformance.json": "conformance.json",
    "processes.json": "process-list.json",
}


def examples(kind):
    """(process, file name, document) of every example that is `ok` or `bad`."""
    for path in sorted((ROOT / "schemas/examples").glob(f"*.{kind}-*.json")):
        yield path.name.split(".")[0], path.name, json.loads(path.read_text(encoding="utf-8"))


def subschemas(schema, place=""):
    """Every schema within a schema, with its place."""
    yield place, schema
    for name, member in schema.get("properties", {}).items():
        yield from subschemas(member, f"{place}/{name}")
    for key in ("items", "additionalProperties"):
        if isinstance(schema.get(key), dict):
            yield from subschemas(schema[key], f"{place}/{key}")
    for key in ("oneOf", "anyOf", "allOf"):
        for k, choice in enumerate(schema.get(key, [])):
            yield from subschemas(choice, f"{place}/{key}/{k}")


def validator(schema):
    return Draft4Validator(build.inline(schema))


def complaints(schema, document):
    return [error.message for error in validator(schema).iter_errors(document)]


def members(value):
    """Names of all members of all objects within a value."""
    if isinstance(value, list):
        return set().union(*(members(item) for item in value))
    if isinstance(value, dict):
        return set(value).union(*(members(item) for item in value.values()))
    return set()


def input_members(process):
    """Names of all members that the inputs of a process may hold."""
    found = set(build.process(process)["inputs"])
    for item in build.process(process)["inputs"].values():
        for _, schema in subschemas(build.inline(item["schema"])):
            found.update(schema.get("properties", {}))
    return found


def is_closed(schema):
    """Whether an object schema says of every member whether it may be there."""
    choices = schema.get("oneOf", [])
    return "additionalProperties" in schema or (choices and all(map(is_closed, choices)))


class Files(unittest.TestCase):
    def test_every_file_is_a_schema_with_title_and_description(self):
        for name in build.schema_names():
            with self.subTest(name):
                schema = build.load(name)
                Draft4Validator.check_schema(schema)
                self.assertEqual(schema["$schema"], DRAFT)
                self.assertTrue(schema["title"] and schema["description"])

    def test_every_place_keeps_to_the_common_keywords_and_is_described(self):
        for name in build.schema_names():
            for place, schema in subschemas(build.load(name)):
                with self.subTest(name + place):
                    extra = set(schema) - KEYWORDS - {"$schema"}
                    self.assertIn(extra, (set(), {"$ref"}))
                    if not extra and not re.search(r"/anyOf/\d$|/items$", place):
                        self.assertIn("description", schema)

    def test_every_default_keeps_its_own_schema(self):
        for name in build.schema_names():
            for place, schema in subschemas(build.inline(build.load(name))):
                if "default" in schema:
                    with self.subTest(name + place):
                        self.assertEqual(complaints(schema, schema["default"]), [])

    def test_every_file_is_used_and_listed_for_the_build(self):
        listed = (ROOT / "schemas/CMakeLists.txt").read_text(encoding="utf-8").split()
        for name in build.schema_names():
            with self.subTest(name):
                self.assertIn(name, listed)

    def test_inputs_are_closed(self):
        for name in build.PROCESSES:
            for place, schema in subschemas(build.inline(build.request_schema(name))):
                if place.startswith("/inputs") and schema.get("type") == "object":
                    with self.subTest(name + place):
                        self.assertTrue(is_closed(schema))


class Documents(unittest.TestCase):
    def test_descriptions_refer_to_nothing(self):
        for name in build.PROCESSES:
            self.assertNotIn("$ref", json.dumps(DOCUMENTS[f"processes/{name}.json"]))

    def test_descriptions_keep_to_the_keywords(self):
        for name in build.PROCESSES:
            described = DOCUMENTS[f"processes/{name}.json"]
            for put in (described["inputs"] | described["outputs"]).values():
                for place, schema in subschemas(put["schema"]):
                    with self.subTest(name + place):
                        self.assertLessEqual(set(schema), KEYWORDS)
                        Draft4Validator.check_schema(schema)

    def test_documents_keep_their_own_schemas(self):
        names = SCHEMA_OF | {
            f"processes/{name}.json": "process-description.json" for name in build.PROCESSES
        }
        for document, schema in names.items():
            with self.subTest(document):
                self.assertEqual(complaints(build.load(schema), DOCUMENTS[document]), [])

    def test_echo_is_what_the_conformance_suite_wants(self):
        echo = DOCUMENTS["processes/echo.json"]
        self.assertEqual(list(echo["inputs"]), ["message", "pause", "values", "blob"])
        self.assertEqual(list(echo["outputs"]), ["message", "pause", "values"])
        occurs = [put["minOccurs"] for put in echo["inputs"].values()]
        self.assertEqual(occurs, [1, 0, 0, 0])
        self.assertEqual(echo["inputs"]["blob"]["schema"]["contentMediaType"], "text/csv")
        self.assertEqual(echo["inputs"]["pause"]["schema"]["maximum"], 60)

    def test_openapi_references_resolve(self):
        openapi = DOCUMENTS["openapi.json"]
        for reference in set(re.findall(r'"\$ref": "#/([^"]*)"', json.dumps(openapi))):
            with self.subTest(reference):
                node = openapi
                for key in reference.split("/"):
                    node = node[key]

    def test_openapi_components_are_all_reached(self):
        openapi = DOCUMENTS["openapi.json"]
        used = set(re.findall(r'"#/components/schemas/([^"]*)"', json.dumps(openapi)))
        self.assertEqual(set(openapi["components"]["schemas"]) - used, set())

    def test_links_are_absolute_and_typed(self):
        for name in ("landing.json", "processes.json", "processes/solve.json"):
            for link in re.findall(r'\{"href": "[^}]*\}?[^}]*\}', json.dumps(DOCUMENTS[name])):
                link = json.loads(link)
                with self.subTest(link["href"]):
                    self.assertTrue(link["href"].startswith("{B}/"))
                    self.assertTrue(link["rel"] and link["type"])


    def test_page_shows_every_input_output_and_status(self):
        described = [DOCUMENTS[f"processes/{name}.json"] for name in build.PROCESSES]
        text = page.page(DOCUMENTS["openapi.json"], described)
        for process in described:
            for name in process["inputs"] | process["outputs"]:
                self.assertIn(f"<code>{name}</code>", text)
        for status in openapi.FAILURES:
            self.assertIn(f"<td>{status}</td>", text)


class Examples(unittest.TestCase):
    def test_there_are_enough(self):
        self.assertGreaterEqual(len(list(examples("ok"))), 25)
        self.assertGreaterEqual(len(list(examples("bad"))), 40)

    def test_good_ones_are_valid(self):
        for process, name, document in examples("ok"):
            with self.subTest(name):
                self.assertEqual(complaints(build.request_schema(process), document), [])

    def test_bad_ones_are_invalid_unless_no_schema_can_tell(self):
        for process, name, case in examples("bad"):
            if "request" not in case:
                continue
            with self.subTest(name):
                valid = not complaints(build.request_schema(process), case["request"])
                self.assertEqual(valid, case.get("schema") == "accepts")

    def test_bad_ones_say_why_and_where(self):
        for _, name, case in examples("bad"):
            with self.subTest(name):
                self.assertLessEqual(
                    set(case), {"why", "status", "pointer", "schema", "text", "request"}
                )
                self.assertTrue(case["why"])
                self.assertEqual("text" in case, "request" not in case)
                self.assertRegex(case["pointer"], r"^(/[^/]+)*$")

    def test_every_member_is_used_and_misused(self):
        used = set().union(*(members(document) for _, _, document in examples("ok")))
        misused = set()
        for _, _, case in examples("bad"):
            misused.update(case["pointer"].split("/"))
        for name in build.PROCESSES:
            known = input_members(name)
            self.assertEqual(known - used, set())
            self.assertEqual(known - misused, set())
            if name != "batch":  # whose one output there is no choosing
                self.assertEqual(set(build.process(name)["outputs"]) - used, set())


if __name__ == "__main__":
    unittest.main()
