/** A field for any schema: the form is made from the descriptions of the daemon's processes, so that
 *  what the daemon learns appears here by itself. */

import type { ComponentChildren, ComponentType } from 'preact';
import type { Schema } from 'scatterd';
import { useEffect, useState } from 'preact/hooks';
import { CloudField } from './CloudField';
import {
  bare, child, errorsUnder, fieldId, fresh, isLong, kindOf, ownErrors, parse, shapeOf, show,
  type FieldError, type Kind, type Value,
} from './value';

export interface FieldProps {
  name: string;
  schema: Schema;
  pointer: string;
  value: Value;
  errors: readonly FieldError[];
  onChange: (value: Value) => void;
  onRemove?: (() => void) | undefined;
}

export function Field(props: FieldProps) {
  const schema = bare(props.schema);
  const Kind = isCloud(schema) ? CloudField : kinds[kindOf(schema)];
  return <Kind {...props} schema={schema} />;
}

function isCloud({ oneOf }: Schema): boolean {
  return oneOf?.some(({ properties }) => properties?.lattice) ?? false;
}

// ---- Around every field ----

export function plainName(name: string): string {
  const words = name.replaceAll('_', ' ');
  return words.charAt(0).toUpperCase() + words.slice(1);
}

export function RemoveButton({ name, onRemove }: { name: string; onRemove?: (() => void) | undefined }) {
  if (!onRemove) return null;
  return <button type="button" class="quiet remove" aria-label={`Remove ${name}`} title={`Remove ${name}`} onClick={onRemove}>×</button>;
}

export function Errors({ errors, id }: { errors: readonly FieldError[]; id: string }) {
  if (errors.length === 0) return null;
  return (
    <ul class="errors" id={id}>
      {errors.map(({ pointer, detail }) => <li key={pointer + detail}>{detail}</li>)}
    </ul>
  );
}

/** A label, one control, what it is about, what is wrong with it. */
function Line(props: FieldProps & { note?: string | undefined; children: (id: string, attributes: object) => ComponentChildren }) {
  const { name, schema, pointer, errors, onRemove, note, children } = props;
  const id = fieldId(pointer);
  const wrong = errorsUnder(errors, pointer);
  const described = [schema.description && `${id}-about`, wrong.length > 0 && `${id}-errors`].filter(Boolean);
  const attributes = {
    'aria-invalid': wrong.length > 0 || undefined,
    'aria-describedby': described.join(' ') || undefined,
  };
  return (
    <div class={`field${wrong.length ? ' wrong' : ''}`}>
      <label for={id} title={schema.description}>{plainName(name)}</label>
      <div class="control">{children(id, attributes)}<RemoveButton name={name} onRemove={onRemove} /></div>
      {note && <p class="note hint">{note}</p>}
      {schema.description && <p class="about" id={`${id}-about`}>{schema.description}</p>}
      <Errors errors={wrong} id={`${id}-errors`} />
    </div>
  );
}

/** A set of fields with a name. */
export function Group(props: FieldProps & { shown: readonly string[]; children: ComponentChildren; tools?: ComponentChildren }) {
  const { name, schema, pointer, errors, onRemove, shown, children, tools } = props;
  const id = fieldId(pointer);
  return (
    <fieldset class="group" id={id} tabIndex={-1}>
      <legend title={schema.description}>{plainName(name)}</legend>
      <div class="group-tools">{tools}<RemoveButton name={name} onRemove={onRemove} /></div>
      {schema.description && <p class="about">{schema.description}</p>}
      <Errors errors={ownErrors(errors, pointer, shown)} id={`${id}-errors`} />
      {children}
    </fieldset>
  );
}

// ---- Kinds ----

/** Numbers, expressions, names, short arrays: all that fits a line of text. */
function TextField(props: FieldProps) {
  const { value, schema, onChange } = props;
  const [text, setText] = useState(show(value));
  useEffect(() => {
    if (show(parse(text)) !== show(value)) setText(show(value));
  }, [value]);
  if (isLong(value)) return <LongField {...props} />;
  const type = (next: string): void => {
    setText(next);
    onChange(parse(next));
  };
  return (
    <Line {...props}>
      {(id, attributes) => (
        <input id={id} {...attributes} class="code" value={text} spellcheck={false} autocomplete="off"
          placeholder={schema.default === undefined ? undefined : show(schema.default)}
          inputMode={schema.type === 'number' || schema.type === 'integer' ? 'decimal' : undefined}
          onInput={(event) => type(event.currentTarget.value)} />
      )}
    </Line>
  );
}

function LongField(props: FieldProps) {
  return (
    <Line {...props}>
      {(id, attributes) => (
        <button id={id} {...attributes} type="button" class="long" title="Replace by a single value" onClick={() => props.onChange(0)}>
          {shapeOf(props.value)} numbers
        </button>
      )}
    </Line>
  );
}

function ChoiceField(props: FieldProps) {
  const { value, schema, onChange } = props;
  const titles = new Map(schema.oneOf?.map(({ enum: names, title }) => [names?.[0], title]));
  return (
    <Line {...props} note={titles.get(value)}>
      {(id, attributes) => (
        <select id={id} {...attributes} value={String(value ?? '')} onChange={(event) => onChange(event.currentTarget.value)}>
          {!schema.enum!.includes(value) && <option value={String(value ?? '')}>{String(value ?? '')}</option>}
          {schema.enum!.map((name) => (
            <option key={String(name)} value={String(name)}>{titles.get(name) ? `${name}: ${titles.get(name)}` : String(name)}</option>
          ))}
        </select>
      )}
    </Line>
  );
}

function FlagField(props: FieldProps) {
  return (
    <Line {...props}>
      {(id, attributes) => (
        <input id={id} {...attributes} type="checkbox" checked={Boolean(props.value)} onChange={(event) => props.onChange(event.currentTarget.checked)} />
      )}
    </Line>
  );
}

/** Components of a vector side by side. */
function VectorField(props: FieldProps) {
  const { value, onChange } = props;
  const parts = value as Value[];
  if (!Array.isArray(value) || parts.length > 3 || parts.some((part) => typeof part === 'object')) return <TextField {...props} />;
  const set = (k: number, text: string): void => onChange(parts.map((part, p) => (p === k ? parse(text) : part)));
  return (
    <Line {...props}>
      {(id, attributes) => (
        <div class={`components${parts.some((part) => show(part).length > 11) ? ' tall' : ''}`}>
          {parts.map((part, k) => (
            <input key={k} id={k ? undefined : id} {...attributes} class="code" value={show(part)} spellcheck={false}
              aria-label={`${plainName(props.name)}, ${'xyz'[k]}`} onInput={(event) => set(k, event.currentTarget.value)} />
          ))}
        </div>
      )}
    </Line>
  );
}

export function Members({ schema, pointer, value, errors, onChange }: FieldProps) {
  const members = (value ?? {}) as Record<string, Value>;
  const known = Object.entries(schema.properties ?? {});
  const required = schema.required ?? [];
  const set = (name: string, next: Value): void => onChange({ ...members, [name]: next });
  const drop = (name: string): void => onChange(Object.fromEntries(Object.entries(members).filter(([key]) => key !== name)));
  const unknown = Object.keys(members).filter((name) => !(name in (schema.properties ?? {})));
  const missing = known.filter(([name]) => !(name in members) && !required.includes(name));
  return (
    <>
      {known.filter(([name]) => name in members || required.includes(name)).map(([name, part]) => (
        <Field key={name} name={name} schema={part} pointer={child(pointer, name)} value={members[name]} errors={errors}
          onChange={(next) => set(name, next)} onRemove={required.includes(name) ? undefined : () => drop(name)} />
      ))}
      {unknown.map((name) => (
        <Field key={name} name={name} schema={{ description: 'The daemon does not know this member.' }} pointer={child(pointer, name)} value={members[name]} errors={errors}
          onChange={(next) => set(name, next)} onRemove={() => drop(name)} />
      ))}
      {missing.length > 0 && (
        <div class="chips" role="group" aria-label="Add an optional member">
          {missing.map(([name, part]) => (
            <button key={name} type="button" class="chip" title={bare(part).description} onClick={() => set(name, fresh(bare(part)))}>
              + {plainName(name)}
            </button>
          ))}
        </div>
      )}
    </>
  );
}

function ObjectField(props: FieldProps) {
  const shown = Object.keys({ ...(props.value as object), ...props.schema.properties });
  return <Group {...props} shown={shown}><Members {...props} /></Group>;
}

/** Names that a person makes up, each with a value. */
function MapField(props: FieldProps) {
  const { schema, pointer, value, errors, onChange } = props;
  const members = Object.entries((value ?? {}) as Record<string, Value>);
  const item = schema.additionalProperties as Schema;
  const set = (rows: [string, Value][]): void => onChange(Object.fromEntries(rows));
  const add = (): void => {
    const free = 'abcdefghklmnpqrsuvw'.split('').find((name) => !members.some(([key]) => key === name)) ?? `p${members.length}`;
    set([...members, [free, fresh(bare(item))]]);
  };
  return (
    <Group {...props} shown={members.map(([name]) => name)} tools={<button type="button" class="quiet" onClick={add}>Add</button>}>
      {members.map(([name, one], k) => (
        <div class="map-row" key={k}>
          <input class="code" aria-label="Name" value={name} spellcheck={false}
            onChange={(event) => set(members.map(([key, v], p) => [p === k ? event.currentTarget.value : key, v]))} />
          <Field name={name} schema={item} pointer={child(pointer, name)} value={one} errors={errors}
            onChange={(next) => set(members.map(([key, v], p) => [key, p === k ? next : v]))}
            onRemove={() => set(members.filter((_, p) => p !== k))} />
        </div>
      ))}
    </Group>
  );
}

/** Objects one after the other, such as boundary entries, of which the later wins. */
function ListField(props: FieldProps) {
  const { schema, pointer, value, errors, onChange } = props;
  const items = (value ?? []) as Value[];
  const item = bare(schema.items!);
  const set = (k: number, next: Value): void => onChange(items.map((one, p) => (p === k ? next : one)));
  const add = <button type="button" class="quiet" onClick={() => onChange([...items, fresh(item)])}>Add</button>;
  return (
    <Group {...props} shown={items.map((_, k) => String(k))} tools={add}>
      <ol class="entries">
        {items.map((one, k) => (
          <li key={k} class="entry" id={fieldId(child(pointer, k))} tabIndex={-1}>
            <RemoveButton name={`entry ${k + 1}`} onRemove={() => onChange(items.filter((_, p) => p !== k))} />
            <Errors errors={ownErrors(errors, child(pointer, k), Object.keys(item.properties ?? {}))} id={`${fieldId(child(pointer, k))}-errors`} />
            <Members name={String(k)} schema={item} pointer={child(pointer, k)} value={one} errors={errors} onChange={(next) => set(k, next)} />
          </li>
        ))}
      </ol>
    </Group>
  );
}

const kinds: Record<Kind, ComponentType<FieldProps>> = {
  choice: ChoiceField,
  flag: FlagField,
  object: ObjectField,
  map: MapField,
  list: ListField,
  vector: VectorField,
  text: TextField,
};
