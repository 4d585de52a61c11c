/** Tabs, by the keyboard pattern of the ARIA practices: arrows choose, Tab leaves. */

import type { ComponentChildren } from 'preact';
import { useId, useState } from 'preact/hooks';

export function Tabs({ label, tabs }: { label: string; tabs: Record<string, () => ComponentChildren> }) {
  const names = Object.keys(tabs);
  const id = useId();
  const [chosen, setChosen] = useState(names[0]!);
  const now = names.includes(chosen) ? chosen : names[0]!;
  const key = (event: KeyboardEvent): void => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const next = names[(names.indexOf(now) + step + names.length) % names.length]!;
    setChosen(next);
    document.getElementById(`${id}-${next}`)?.focus();
  };
  return (
    <div class="tabs">
      <div role="tablist" aria-label={label} onKeyDown={key}>
        {names.map((name) => (
          <button key={name} id={`${id}-${name}`} type="button" role="tab" aria-selected={name === now} aria-controls={`${id}-panel`}
            tabIndex={name === now ? 0 : -1} onClick={() => setChosen(name)}>{name}</button>
        ))}
      </div>
      <div role="tabpanel" id={`${id}-panel`} aria-labelledby={`${id}-${now}`}>{tabs[now]!()}</div>
    </div>
  );
}
