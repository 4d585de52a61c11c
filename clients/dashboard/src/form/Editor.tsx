/** The problem as a form, as JSON, and as what one types elsewhere to ask the same. */

import type { ProcessDescription } from 'scatterd';
import { useEffect, useState } from 'preact/hooks';
import { base } from '../lib/daemon';
import { asCurl, asPython, pretty, sizeOf, type Request } from '../lib/request';
import { Tabs } from '../ui/Tabs';
import { BatchForm } from './BatchForm';
import { Errors, Members } from './Field';
import { focusField, ownErrors, schemaOf, type FieldError } from './value';

interface Props {
  description: ProcessDescription;
  request: Request;
  errors: readonly FieldError[];
  onChange: (request: Request) => void;
}

export function Editor({ description, request, errors, onChange }: Props) {
  const [explained, setExplained] = useState(false);
  const schema = schemaOf(description);
  const change = (inputs: unknown): void => onChange({ ...request, inputs: inputs as Request['inputs'] });
  return (
    <Tabs label="The problem" tabs={{
      Form: () => (
        <div class={`form${explained ? ' explained' : ''}`}>
          <Complaints errors={errors} />
          <label class="toggle explain"><input type="checkbox" checked={explained} onChange={(event) => setExplained(event.currentTarget.checked)} /> Explain every field</label>
          {explained && <p class="hint">{description.description}</p>}
          <Errors errors={ownErrors(errors, '/inputs', Object.keys({ ...description.inputs, ...request.inputs }))} id="errors-of-inputs" />
          {description.id === 'batch'
            ? <BatchForm description={description} inputs={request.inputs} errors={errors} onChange={change} />
            : <Members name="inputs" schema={schema} pointer="/inputs" value={request.inputs} errors={errors} onChange={change} />}
        </div>
      ),
      JSON: () => <JsonText inputs={request.inputs} onChange={change} />,
      Code: () => <Code request={request} />,
    }} />
  );
}

function Complaints({ errors }: { errors: readonly FieldError[] }) {
  if (errors.length === 0) return null;
  return (
    <div class="complaints" role="alert">
      <strong>{errors.length === 1 ? 'One value is wrong' : `${errors.length} values are wrong`}</strong>
      <ul>
        {errors.map(({ pointer, detail }) => (
          <li key={pointer + detail}><button type="button" class="link code" onClick={() => focusField(pointer)}>{pointer}</button> {detail}</li>
        ))}
      </ul>
    </div>
  );
}

function JsonText({ inputs, onChange }: { inputs: Request['inputs']; onChange: (inputs: unknown) => void }) {
  const large = sizeOf(inputs) > 20_000;
  const [text, setText] = useState(() => (large ? '' : pretty(inputs)));
  const [trouble, setTrouble] = useState('');
  useEffect(() => {
    if (!large && document.activeElement?.id !== 'json-text') setText(pretty(inputs));
  }, [inputs]);
  if (large) return <p class="hint">These inputs hold {sizeOf(inputs)} numbers, too many to edit as text.</p>;
  const type = (next: string): void => {
    setText(next);
    try {
      const value = JSON.parse(next);
      onChange(value.inputs ?? value);
      setTrouble('');
    } catch (error) {
      setTrouble((error as Error).message);
    }
  };
  return (
    <div class="form">
      <label for="json-text">Inputs, or a whole request</label>
      <textarea id="json-text" class="code tall" spellcheck={false} value={text} aria-invalid={Boolean(trouble)} onInput={(event) => type(event.currentTarget.value)} />
      {trouble && <p class="errors">{trouble}</p>}
    </div>
  );
}

function Code({ request }: { request: Request }) {
  if (sizeOf(request.inputs) > 20_000) return <p class="hint">These inputs hold {sizeOf(request.inputs)} numbers: too many for a command line.</p>;
  return (
    <div class="form">
      <Snippet name="curl" text={asCurl(request, base)} />
      <Snippet name="Python" text={asPython(request, base)} />
    </div>
  );
}

function Snippet({ name, text }: { name: string; text: string }) {
  const [done, setDone] = useState(false);
  const copy = async (): Promise<void> => {
    await navigator.clipboard.writeText(text);
    setDone(true);
    setTimeout(() => setDone(false), 2000);
  };
  return (
    <section class="snippet">
      <header><h3>{name}</h3><button type="button" class="quiet" onClick={() => void copy()}>{done ? 'Copied' : 'Copy'}</button></header>
      <pre class="code" tabIndex={0}>{text}</pre>
    </section>
  );
}
