// Validates the OpenAPI document and recorded traffic against it, by validators of others.
//
//   node validate.mjs OPENAPI.json TRAFFIC.json
//
// The document: the official schema of OpenAPI 3.0 and the recommended rules of Redocly. The
// traffic, a list of {request: {method, path, headers, body}, response: {status, headers, body}}
// with bodies parsed where they are JSON: path, operation, parameters, media types, bodies, status
// and headers of the answer, by ajv with draft 4, which OpenAPI 3.0 builds on. Prints a JSON object
// {document: [..], traffic: [..], seen: [[path, method, status], ..]} of what is wrong and what was
// seen.
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const require = createRequire(import.meta.url);
const { lintFromString, createConfig } = require("@redocly/openapi-core");
const Ajv = require("ajv-draft-04");
const formats = require("ajv-formats");

const text = readFileSync(process.argv[2], "utf8");
const api = JSON.parse(text);
const traffic = JSON.parse(readFileSync(process.argv[3], "utf8"));

async function checkDocument() {
  const { Validator } = await import("@seriousme/openapi-schema-validator");
  const official = await new Validator().validate(structuredClone(api));
  const found = official.valid ? [] : [official.errors].flat().map((e) => JSON.stringify(e));
  // Addresses are filled in when the document is served; 4XX answers are all listed by name.
  const config = await createConfig({ extends: ["recommended"] });
  const lint = await lintFromString({ source: text, config });
  const shown = lint.filter((p) => p.severity === "error" || p.severity === "warn");
  return [...found, ...shown.map((p) => `${p.ruleId}: ${p.message} ${p.location[0]?.pointer}`)];
}

// --- Traffic ---

const ajv = new Ajv({ strict: false, allErrors: false, validateFormats: true });
formats(ajv);
ajv.addSchema({ id: "api", components: api.components }, "api");

const compiled = new Map();

function check(schema, value) {
  const absolute = JSON.parse(JSON.stringify(schema).replaceAll('"#/', '"api#/'));
  const key = JSON.stringify(absolute);
  if (!compiled.has(key)) compiled.set(key, ajv.compile(absolute));
  const validate = compiled.get(key);
  return validate(value) ? null : ajv.errorsText(validate.errors.slice(0, 3));
}

function resolve(node) {
  if (!node?.$ref) return node;
  return node.$ref.slice(2).split("/").reduce((at, key) => at[key], api);
}

const templates = Object.keys(api.paths)
  .map((path) => ({ path, expression: new RegExp("^" + path.replace(/\{[^}]+\}/g, "([^/]+)") + "$") }))
  .sort((a, b) => a.path.split("{").length - b.path.split("{").length);

const lower = (fields) =>
  Object.fromEntries(Object.entries(fields).map(([k, v]) => [k.toLowerCase(), v]));

const media = (type) => type?.split(";")[0].trim().toLowerCase();

/* Headers of HTTP itself, which no OpenAPI document lists. */
const ofHttp = new Set(["date", "content-length", "content-type", "connection", "transfer-encoding"]);
const ofClients = new Set(["host", "accept", "content-type", "content-length", "user-agent",
  "connection", "transfer-encoding", "authorization"]);

function value(schema, raw) {
  const type = resolve(schema).type;
  return type === "integer" || type === "number" ? Number(raw) : raw;
}

function checkParameters(operation, item, request, found, match, path, good) {
  const known = [...(item.parameters ?? []), ...(operation.parameters ?? [])].map(resolve);
  const query = new URL(request.path, "http://x").searchParams;
  const names = [...path.matchAll(/\{([^}]+)\}/g)].map((m) => m[1]);
  const fields = lower(request.headers);
  const got = {
    path: Object.fromEntries(names.map((name, k) => [name, decodeURIComponent(match[k + 1])])),
    query: Object.fromEntries(query),
    header: fields,
  };
  for (const parameter of known) {
    const name = parameter.in === "header" ? parameter.name.toLowerCase() : parameter.name;
    const raw = got[parameter.in][name];
    if (raw === undefined) continue;
    used.add(`${parameter.in} ${parameter.name}`);
    const wrong = check(parameter.schema, value(parameter.schema, raw));
    if (wrong && good) found.push(`parameter ${parameter.name}: ${wrong}`);
  }
  const has = (place, name) =>
    known.some((p) => p.in === place && p.name.toLowerCase() === name.toLowerCase());
  for (const name of query.keys()) {
    if (good && !has("query", name)) found.push(`query ${name} is not documented`);
  }
  for (const name of Object.keys(fields)) {
    if (!ofClients.has(name) && !has("header", name)) found.push(`field ${name} is not documented`);
  }
}

function checkRequestBody(operation, request, found) {
  if (request.body === undefined || !operation.requestBody) return;
  const content = operation.requestBody.content;
  const entry = content[media(lower(request.headers)["content-type"])] ?? content["*/*"];
  if (!entry) found.push(`request body of ${lower(request.headers)["content-type"]}`);
  const wrong = entry && check(entry.schema, request.body);
  if (wrong) found.push(`request body: ${wrong}`);
}

function checkResponse(operation, method, response, found) {
  const documented = resolve(operation.responses[response.status]);
  if (!documented) {
    found.push(`status ${response.status} is not documented`);
    return;
  }
  const fields = lower(response.headers);
  const known = Object.keys(documented.headers ?? {}).map((name) => name.toLowerCase());
  for (const name of Object.keys(fields)) {
    if (!ofHttp.has(name) && !known.includes(name)) {
      found.push(`field ${name} of a ${response.status} is not documented`);
    }
  }
  for (const name of Object.keys(documented.headers ?? {})) {
    if (fields[name.toLowerCase()] !== undefined) used.add(`answer ${name}`);
  }
  const type = media(fields["content-type"]);
  if (method === "head" || [204, 304].includes(response.status)) return;
  const entry = documented.content?.[fields["content-type"]] ?? documented.content?.[type];
  if (!entry) {
    found.push(`a ${response.status} of ${type} is not documented`);
    return;
  }
  used.add(`media ${type}`);
  const wrong = response.body === undefined ? null : check(entry.schema, response.body);
  if (wrong) found.push(`a ${response.status}: ${wrong}`);
}

const seen = new Set();
const used = new Set();

function checkExchange({ request, response }) {
  const found = [];
  const method = request.method.toLowerCase();
  const plain = request.path.split("?")[0];
  const template = templates.find((t) => t.expression.test(plain));
  const operation = template && api.paths[template.path][method];
  if (!operation) {
    const expected = [template ? 405 : 404, 400, 414, 431]; // the last three by HTTP itself
    if (!expected.includes(response.status)) found.push(`not documented, and answered ${response.status}`);
    return found;
  }
  const item = api.paths[template.path];
  const good = response.status < 400;
  seen.add(JSON.stringify([template.path, method, String(response.status)]));
  checkParameters(operation, item, request, found, template.expression.exec(plain), template.path,
    good);
  if (good) checkRequestBody(operation, request, found);
  checkResponse(operation, method, response, found);
  return found;
}

const wrong = traffic.flatMap((exchange) =>
  checkExchange(exchange).map(
    (what) => `${exchange.request.method} ${exchange.request.path}: ${what}`,
  ),
);

console.log(
  JSON.stringify({
    document: await checkDocument(),
    traffic: wrong,
    seen: [...seen].map((entry) => JSON.parse(entry)),
    used: [...used].sort(),
  }),
);
