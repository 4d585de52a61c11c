"""What the description of process study says of its cases, made from the case files."""

import json
import re

NUMBERS = {"type": "array", "minItems": 1, "items": {"description": "A value.", "type": "number"}}
OF_A_SCHEMA = ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum")


def complete(source, cases):
    """The source of the description with schemas of `case` and `parameters` and all defaults."""
    schemas = {"case": case_schema(cases), "parameters": parameters_schema(cases)}
    inputs = {
        name: {**item, "schema": schemas.get(name) or item["schema"]}
        for name, item in source["inputs"].items()
    }
    return {**source, "inputs": inputs}


def case_schema(cases):
    return {
        "description": "Name of a case.",
        "type": "string",
        "enum": list(cases),
        "oneOf": [one_case(name, case) for name, case in cases.items()],
    }


def one_case(name, case):
    """A case with what it is and its defaults."""
    values = {parameter: schema["default"] for parameter, schema in case["parameters"].items()}
    about = (
        f"{case['equation']}. {paper(case)}, {case['where']}. Defaults: cells "
        f"{text(case['cells'])}; operator {text(case['operator'])}; parameters {text(values)}."
    )
    return {"title": case["title"], "description": about, "type": "string", "enum": [name]}


def text(value):
    return json.dumps(value, separators=(", ", ": "))


def paper(case):
    """Authors and year out of the source."""
    return case["source"].split(", ")[0] + " et al. " + re.search(r"[0-9]{4}", case["source"])[0]


def parameters_schema(cases):
    """Every parameter of any case; which of them a case has no schema can say."""
    found = {}
    for name, case in cases.items():
        for parameter, schema in case["parameters"].items():
            found.setdefault(parameter, {})[name] = schema
    return {
        "description": "Parameters by name; each case has some of them.",
        "type": "object",
        "additionalProperties": False,
        "properties": {name: parameter_schema(uses) for name, uses in sorted(found.items())},
    }


def parameter_schema(uses):
    """Schema of one parameter out of those of the cases that have it."""
    first = next(iter(uses.values()))
    about = f"{first['description']} Of {', '.join(uses)}."
    if first["type"] == "array":
        return {"description": about, "type": "array", "items": first["items"]}
    one = {"description": "A number.", "type": first["type"]}
    for key in OF_A_SCHEMA:
        if all(schema.get(key) == first.get(key) for schema in uses.values()) and key in first:
            one[key] = first[key]
    if first["type"] == "integer":
        return {**one, "description": about}
    return {"description": about, "anyOf": [one, NUMBERS]}
