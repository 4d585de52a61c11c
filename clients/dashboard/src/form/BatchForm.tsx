/** The form of a batch: the requests one after the other, each with the form of its process; or one
 *  request and a table of values for its parameters. */

import type { ProcessDescription } from 'scatterd';
import type { ComponentChildren } from 'preact';
import { useEffect, useRef, useState } from 'preact/hooks';
import { inShort, lengthOf, parseRequests, type BatchInputs, type Part } from '../lib/batch';
import { startOf } from '../lib/cases';
import { client, describe, useAsked } from '../lib/daemon';
import { some } from '../lib/text';
import { Errors, Members, RemoveButton } from './Field';
import { child, errorsUnder, fieldId, ownErrors, schemaOf, type FieldError } from './value';

interface Props {
  description: ProcessDescription;
  inputs: BatchInputs;
  errors: readonly FieldError[];
  onChange: (inputs: BatchInputs) => void;
}

const kinds = { list: 'List of requests', table: 'Table of parameters' };

export function BatchForm({ description, inputs, errors, onChange }: Props) {
  const { requests, request, parameters, ...rest } = inputs;
  const { cloud: own, ...others } = inputs;
  const isTable = requests === undefined && (request !== undefined || parameters !== undefined);
  const kept = useRef<BatchInputs>({});
  const choose = (kind: string): void => {
    if ((kind === 'table') === isTable) return;
    const before = kept.current;
    kept.current = { ...(requests && { requests }), ...(parameters && { parameters }) };
    onChange(kind === 'table'
      ? { ...rest, request: requests?.[0] ?? { process: 'solve', inputs: startOf('solve') }, parameters: before.parameters ?? {} }
      : { ...rest, requests: before.requests ?? (request ? [request] : []) });
  };
  const { cloud } = description.inputs;
  const shared = { type: 'object', properties: { cloud: cloud!.schema } };
  return (
    <>
      <div class="segments" role="radiogroup" aria-label="Kind of batch">
        {Object.entries(kinds).map(([kind, label]) => (
          <button key={kind} type="button" role="radio" aria-checked={(kind === 'table') === isTable} onClick={() => choose(kind)}>{label}</button>
        ))}
      </div>
      <p class="hint">{isTable
        ? 'One request, run once for every row of the table. Its expressions know the names of the columns.'
        : 'Every request becomes a job of its own, checked before any of them starts.'}</p>
      {isTable
        ? <Table inputs={inputs} errors={errors} onChange={onChange} />
        : <List requests={requests ?? []} shared={own !== undefined} errors={errors} onChange={(next) => onChange({ ...inputs, requests: next })} />}
      {cloud && <Members name="inputs" schema={shared} pointer="/inputs" value={own === undefined ? {} : { cloud: own }} errors={errors}
        onChange={(next) => onChange({ ...others, ...(next as BatchInputs) })} />}
      {cloud && <p class="hint">{own === undefined ? 'A cloud for all requests that have none of their own.' : 'This cloud is used by every request that has none of its own.'}</p>}
    </>
  );
}

/** A request to begin with; where the batch has a cloud it needs none of its own. */
function freshPart(process: string, shared: boolean): Part {
  const { cloud, ...inputs } = startOf(process);
  return { process, inputs: shared || cloud === undefined ? inputs : { cloud, ...inputs } };
}

// ---- Requests one after the other ----

interface ListProps {
  requests: Part[];
  shared: boolean;
  errors: readonly FieldError[];
  onChange: (requests: Part[]) => void;
}

/** Numbers that stay with the entries of a list while others come and go. */
function useKeys(count: number): { keys: number[]; last: () => number } {
  const next = useRef(0);
  const keys = useRef<number[]>([]);
  while (keys.current.length < count) keys.current.push(next.current++);
  keys.current.length = count;
  return { keys: keys.current, last: () => next.current };
}

function List({ requests, shared, errors, onChange }: ListProps) {
  const { keys, last } = useKeys(requests.length);
  const opened = useRef(requests.length === 1 ? 0 : Infinity); // entries from this key on are born open
  const own = ownErrors(errors, '/inputs/requests', requests.map((_, k) => String(k)));
  const add = (): void => {
    opened.current = last();
    onChange([...requests, freshPart(requests.at(-1)?.process ?? 'solve', shared)]);
  };
  const addAll = (parts: Part[]): void => {
    opened.current = Infinity;
    onChange([...requests, ...parts]);
  };
  const remove = (k: number): void => {
    keys.splice(k, 1);
    onChange(requests.filter((_, p) => p !== k));
  };
  return (
    <fieldset class="group" id={fieldId('/inputs/requests')} tabIndex={-1}>
      <legend>{some(requests.length, 'request')}</legend>
      <Errors errors={own} id="errors-of-requests" />
      <ol class="entries">
        {requests.map((part, k) => (
          <Entry key={keys[k]} k={k} part={part} shared={shared} errors={errors} open={keys[k]! >= opened.current}
            onChange={(next) => onChange(requests.map((one, p) => (p === k ? next : one)))}
            onCopy={() => onChange([...requests, structuredClone(part)])}
            onRemove={() => remove(k)} />
        ))}
      </ol>
      <div class="row-tools"><button type="button" onClick={add}>Add a request</button></div>
      <Paste onAdd={addAll} />
    </fieldset>
  );
}

interface EntryProps {
  k: number;
  part: Part;
  shared: boolean;
  errors: readonly FieldError[];
  open: boolean;
  onChange: (part: Part) => void;
  onCopy: () => void;
  onRemove: () => void;
}

function Entry({ k, part, shared, errors, open: born, onChange, onCopy, onRemove }: EntryProps) {
  const [open, setOpen] = useState(born);
  const pointer = child('/inputs/requests', k);
  const wrong = errorsUnder(errors, pointer).length;
  useEffect(() => {
    if (wrong > 0) setOpen(true);
  }, [wrong]);
  return (
    <li class={`entry part${wrong ? ' wrong' : ''}`} id={fieldId(pointer)} tabIndex={-1}>
      <div class="part-head">
        <button type="button" class="quiet part-name" aria-expanded={open} onClick={() => setOpen(!open)}>
          <b>{k + 1}. {part.process ?? 'solve'}</b>
          {wrong > 0 && <span class="errors">{some(wrong, 'value')} wrong</span>}
          <span class="hint">{inShort(part.inputs)}</span>
        </button>
        <button type="button" class="quiet" aria-label={`Copy request ${k + 1}`} title="Add a copy of this request" onClick={onCopy}>Copy</button>
        <RemoveButton name={`request ${k + 1}`} onRemove={onRemove} />
      </div>
      {open && <PartForm part={part} pointer={pointer} shared={shared} errors={errors} onChange={onChange} />}
    </li>
  );
}

interface PartFormProps {
  part: Part;
  pointer: string;
  shared: boolean;
  errors: readonly FieldError[];
  onChange: (part: Part) => void;
}

/** The process of a request and the form of that process. */
function PartForm({ part, pointer, shared, errors, onChange }: PartFormProps) {
  const process = part.process ?? 'solve';
  const { value: processes } = useAsked(() => client.processes(), []);
  const { value: description } = useAsked(() => describe(process), [process]);
  const names = (processes ?? []).map(({ id }) => id).filter((id) => id !== 'batch');
  const id = fieldId(child(pointer, 'process'));
  const below = child(pointer, 'inputs');
  const fits = description?.id === process;
  const schema = fits ? schemaOf(description) : {};
  const required = (schema.required ?? []).filter((name) => name !== 'cloud' || !shared);
  return (
    <>
      <div class="field">
        <label for={id}>Process</label>
        <select id={id} value={process} onChange={(event) => onChange(freshPart(event.currentTarget.value, shared))}>
          {!names.includes(process) && <option value={process}>{process}</option>}
          {names.map((name) => <option key={name} value={name}>{name}</option>)}
        </select>
      </div>
      <Errors errors={[...ownErrors(errors, pointer, ['inputs']), ...ownErrors(errors, below, Object.keys({ ...schema.properties, ...part.inputs }))]} id={`${id}-errors`} />
      {fits && <Members name="inputs" schema={{ ...schema, required }} pointer={below} value={part.inputs} errors={errors}
        onChange={(inputs) => onChange({ ...part, inputs: inputs as Part['inputs'] })} />}
    </>
  );
}

/** Requests as text or files, added to the list. */
function Paste({ onAdd }: { onAdd: (parts: Part[]) => void }) {
  const [text, setText] = useState('');
  const [said, setSaid] = useState('');
  const [trouble, setTrouble] = useState('');
  const take = (texts: string[]): void => {
    try {
      const parts = texts.flatMap(parseRequests);
      onAdd(parts);
      setText('');
      setSaid(`${some(parts.length, 'request')} added.`);
      setTrouble('');
    } catch (error) {
      setTrouble((error as Error).message);
      setSaid('');
    }
  };
  const read = async (input: HTMLInputElement): Promise<void> => {
    const texts = await Promise.all(Array.from(input.files ?? [], (file) => file.text()));
    input.value = '';
    take(texts);
  };
  return (
    <div class="paste">
      <label for="batch-paste">Or paste requests as JSON: one, a list, or one on every line</label>
      <textarea id="batch-paste" class="code" rows={3} spellcheck={false} value={text} aria-invalid={Boolean(trouble)} aria-describedby="batch-paste-said"
        placeholder={'{"process": "solve", "inputs": {…}}'} onInput={(event) => setText(event.currentTarget.value)} />
      <div class="row-tools">
        <button type="button" disabled={!text.trim()} onClick={() => take([text])}>Add these</button>
        <label class="button">Choose files<input class="unseen" type="file" multiple accept=".json,.ndjson,.jsonl" onChange={(event) => void read(event.currentTarget)} /></label>
      </div>
      <p id="batch-paste-said" role="status" class={trouble ? 'errors' : 'hint'}>{trouble ? `Nothing was added: ${trouble}` : said}</p>
    </div>
  );
}

// ---- One request and a table ----

function Table({ inputs, errors, onChange }: { inputs: BatchInputs; errors: readonly FieldError[]; onChange: (inputs: BatchInputs) => void }) {
  const { request = { process: 'solve', inputs: {} }, parameters = {} } = inputs;
  const columns = Object.entries(parameters);
  const { keys } = useKeys(columns.length);
  const set = (rows: [string, number[]][]): void => onChange({ ...inputs, parameters: Object.fromEntries(rows) });
  const add = (): void => {
    const free = 'abcdefghklmnpqrsuvw'.split('').find((name) => !(name in parameters)) ?? `p${columns.length}`;
    set([...columns, [free, []]]);
  };
  const runs = lengthOf({ parameters });
  return (
    <>
      <Box legend="Request" pointer="/inputs/request">
        <PartForm part={request} pointer="/inputs/request" shared={inputs.cloud !== undefined} errors={errors} onChange={(next) => onChange({ ...inputs, request: next })} />
      </Box>
      <Box legend="Values of parameters" pointer="/inputs/parameters">
        <Errors errors={ownErrors(errors, '/inputs/parameters', Object.keys(parameters))} id="errors-of-parameters" />
        {columns.map(([name, values], k) => (
          <Column key={keys[k]} name={name} values={values} errors={errors}
            onChange={(next, column) => set(columns.map((one, p) => (p === k ? [next, column] : one)))}
            onRemove={() => { keys.splice(k, 1); set(columns.filter((_, p) => p !== k)); }} />
        ))}
        <div class="row-tools">
          <button type="button" onClick={add}>Add a parameter</button>
          <span class={runs === undefined ? 'errors' : 'hint'} role="status">
            {runs === undefined ? 'The columns are not of the same length' : columns.length > 0 && `makes ${some(runs, 'request')}`}
          </span>
        </div>
      </Box>
    </>
  );
}

function Box({ legend, pointer, children }: { legend: string; pointer: string; children: ComponentChildren }) {
  return <fieldset class="group" id={fieldId(pointer)} tabIndex={-1}><legend>{legend}</legend>{children}</fieldset>;
}

interface ColumnProps {
  name: string;
  values: number[];
  errors: readonly FieldError[];
  onChange: (name: string, values: number[]) => void;
  onRemove: () => void;
}

/** Numbers with anything between them, as they come out of a spreadsheet or a list. */
function numbersOf(text: string): (number | string)[] {
  return text.split(/[\s,;[\]]+/).filter(Boolean).map((word) => (Number.isNaN(Number(word)) ? word : Number(word)));
}

function Column({ name, values, errors, onChange, onRemove }: ColumnProps) {
  const [text, setText] = useState(() => values.join(', '));
  const pointer = child('/inputs/parameters', name);
  const wrong = errorsUnder(errors, pointer);
  const type = (next: string): void => {
    setText(next);
    onChange(name, numbersOf(next) as number[]); // what is no number, the daemon objects to
  };
  return (
    <div class={`column${wrong.length ? ' wrong' : ''}`}>
      <input class="code" aria-label="Name of the parameter" value={name} spellcheck={false} onChange={(event) => onChange(event.currentTarget.value, values)} />
      <input class="code" id={fieldId(pointer)} aria-label={`Values of ${name}`} aria-invalid={wrong.length > 0 || undefined} value={text} spellcheck={false}
        placeholder="0.1, 0.2, 0.4" onInput={(event) => type(event.currentTarget.value)} />
      <RemoveButton name={name} onRemove={onRemove} />
      <Errors errors={wrong} id={`${fieldId(pointer)}-errors`} />
    </div>
  );
}
