"""The interface as a page for reading, made from the OpenAPI document and the descriptions."""

import html
import json

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 56rem; margin: 2rem auto; padding: 0 1rem;
       color: #1b1f24; background: #fff; }
h1, h2, h3 { line-height: 1.2; } h2 { margin-top: 3rem; border-bottom: 1px solid #d0d7de; }
code { font: 0.9em ui-monospace, monospace; background: #f3f4f6; padding: 0.1em 0.3em; }
dl { margin: 0.3rem 0 0.3rem 1rem; } dt { margin-top: 0.5rem; } dd { margin-left: 1.5rem; }
.kind { color: #57606a; } table { border-collapse: collapse; }
td, th { text-align: left; padding: 0.3rem 1rem 0.3rem 0; vertical-align: top; }
@media (prefers-color-scheme: dark) { body { color: #e6edf3; background: #0d1117; }
  h2 { border-color: #30363d; } code { background: #161b22; } .kind { color: #9198a1; } }
"""


def text(value):
    return html.escape(str(value))


def code(value):
    return f"<code>{text(value)}</code>"


def bounds(schema):
    """ "> 0, <= 1" and the like, "" without any."""
    parts = []
    if "minimum" in schema:
        parts.append((">" if schema.get("exclusiveMinimum") else ">=") + f" {schema['minimum']}")
    if "maximum" in schema:
        parts.append(("<" if schema.get("exclusiveMaximum") else "<=") + f" {schema['maximum']}")
    return ", ".join(parts)


def length(schema):
    """ "1 to 3 items" and the like."""
    low, high = schema.get("minItems", 0), schema.get("maxItems")
    if high is not None:
        return f"{low} to {high} items"
    return f"at least {low}" if low else ""


def kind(schema):
    """Type, range, choices and default of a schema in one line of HTML."""
    words = [text(schema.get("type", "")), text(bounds(schema)), text(length(schema))]
    if "enum" in schema:
        words.append("one of " + " ".join(code(json.dumps(choice)) for choice in schema["enum"]))
    if "default" in schema:
        words.append("default " + code(json.dumps(schema["default"])))
    return f'<span class="kind">{", ".join(word for word in words if word)}</span>'


def alternatives(schema):
    return schema.get("oneOf") or schema.get("anyOf") or []


def members(schema):
    """What a schema holds, as a nested list: members of objects, alternatives, items."""
    parts = [
        term(name, member, name in schema.get("required", ()))
        for name, member in schema.get("properties", {}).items()
    ]
    parts += [term("either", choice, False) for choice in alternatives(schema)]
    if isinstance(schema.get("additionalProperties"), dict):
        parts.append(term("any name", schema["additionalProperties"], False))
    if "items" in schema:
        parts.append(term("items", schema["items"], False))
    return f"<dl>{''.join(parts)}</dl>" if parts else ""


def term(name, schema, required):
    mark = " <b>required</b>" if required else ""
    about = text(schema.get("description", ""))
    return f"<dt>{code(name)} {kind(schema)}{mark}</dt><dd>{about}{members(schema)}</dd>"


def puts(title, items):
    """Inputs or outputs of a process."""
    rows = []
    for name, item in items.items():
        mark = " <b>required</b>" if item.get("minOccurs") else ""
        head = f"<dt>{code(name)} {kind(item['schema'])}{mark}</dt>"
        details = members(item["schema"])
        if details:
            details = f"<details><summary>form</summary>{details}</details>"
        rows.append(f"{head}<dd>{text(item['description'])}{details}</dd>")
    return f"<h3>{title}</h3><dl>{''.join(rows)}</dl>"


def process(description):
    return (
        f'<h2 id="{text(description["id"])}">{code(description["id"])} {text(description["title"])}'
        f"</h2><p>{text(description['description'])}</p>"
        + puts("Inputs", description["inputs"])
        + puts("Outputs", description["outputs"])
    )


def resources(openapi):
    rows = []
    for path, operations in openapi["paths"].items():
        for method in [name for name in ("get", "post", "delete") if name in operations]:
            operation = operations[method]
            codes = " ".join(sorted(operation["responses"]))
            about = text(operation["summary"])
            rows.append(
                f"<tr><td>{method.upper()}</td><td>{code(path)}</td><td>{about}</td>"
                f'<td class="kind">{codes}</td></tr>'
            )
    return f"<table>{''.join(rows)}</table>"


def statuses(openapi):
    answers = openapi["components"]["responses"].items()
    rows = [f"<tr><td>{number}</td><td>{text(a['description'])}</td></tr>" for number, a in answers]
    return f"<table>{''.join(rows)}</table>"


def page(openapi, descriptions):
    """The whole page."""
    info = openapi["info"]
    links = " · ".join(f'<a href="#{text(d["id"])}">{text(d["id"])}</a>' for d in descriptions)
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<link rel="icon" href="data:,">'
        f"<title>{text(info['title'])} interface</title><style>{STYLE}</style></head><body>"
        f"<h1>{text(info['title'])} {text(info['version'])}</h1><p>{text(info['description'])}</p>"
        f"<p>Processes: {links}</p><h2>Resources</h2>{resources(openapi)}"
        f"<h2>Problems</h2><p>Every failure is a problem document (RFC 9457).</p>"
        f"{statuses(openapi)}{''.join(process(d) for d in descriptions)}</body></html>\n"
    )
