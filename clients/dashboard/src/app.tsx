/** The page around its views. */

import { useEffect, useRef, useState } from 'preact/hooks';
import { useDaemon } from './lib/daemon';
import { setTheme, theme, type Theme } from './lib/memory';
import { useRoute, type Route } from './lib/route';
import { Catalogue } from './views/Catalogue';
import { Jobs } from './views/Jobs';
import { Workspace } from './views/Workspace';

const views: [title: string, fits: (path: string[]) => boolean, view: (route: Route) => preact.JSX.Element][] = [
  ['Problem', ([first]) => first === 'run', (route) => <Workspace route={route} />],
  ['Job', ([first, id]) => first === 'jobs' && id !== undefined, (route) => <Workspace route={route} />],
  ['Jobs', ([first]) => first === 'jobs', () => <Jobs />],
  ['Cases', () => true, () => <Catalogue />],
];

export function App() {
  const route = useRoute();
  const there = useDaemon();
  const [title, , view] = views.find(([, fits]) => fits(route.path))!;
  const first = useRef(true);
  useEffect(() => {
    document.title = `${title} · scatterd`;
    if (!first.current) document.getElementById('main')?.scrollIntoView();
    first.current = false;
  }, [title]);
  return (
    <>
      <a class="skip" href="#main" onClick={(event) => { event.preventDefault(); document.querySelector<HTMLElement>('#main :is(a, button, input, select)')?.focus(); }}>Skip to the content</a>
      <header class="top">
        <a class="brand" href="#/"><Mark />scatterd</a>
        <nav aria-label="Views">
          <NavLink href="#/" here={title === 'Cases'}>Cases</NavLink>
          <NavLink href="#run/solve" here={title === 'Problem'}>Problem</NavLink>
          <NavLink href="#jobs" here={title.startsWith('Job')}>Jobs</NavLink>
          <a href="api">Interface</a>
        </nav>
        <span class="spring" />
        <span class={`daemon${there ? '' : ' away'}`} role="status">{there ? 'connected' : 'no answer'}</span>
        <ThemeButton />
      </header>
      {!there && <div class="banner" role="alert">The daemon does not answer. What you see stays; the page goes on by itself when the daemon is back.</div>}
      {view(route)}
    </>
  );
}

function NavLink({ href, here, children }: { href: string; here: boolean; children: string }) {
  return <a href={href} aria-current={here ? 'page' : undefined}>{children}</a>;
}

function Mark() {
  return (
    <svg viewBox="0 0 24 24" width="22" height="22" aria-hidden="true" class="mark">
      {[[4, 5], [11, 3.5], [19, 6], [5.5, 12], [12.5, 10.5], [20, 13], [4, 19.5], [11, 18], [18.5, 20]].map(([x, y], k) => (
        <circle key={k} cx={x} cy={y} r={k === 4 ? 3.4 : 1.9} />
      ))}
    </svg>
  );
}

const next: Record<Theme, Theme> = { system: 'light', light: 'dark', dark: 'system' };
const said: Record<Theme, string> = { system: 'Auto', light: 'Light', dark: 'Dark' };

function ThemeButton() {
  const [now, setNow] = useState(theme);
  const turn = (): void => {
    setTheme(next[now]);
    setNow(next[now]);
  };
  return <button type="button" class="quiet" onClick={turn} aria-label={`Colours: ${said[now]}`}>{said[now]}</button>;
}
