/** What this browser remembers: the problem being edited, requests of jobs, the theme. */

import { sizeOf, type Request } from './request';

function read<Value>(store: Storage, key: string): Value | undefined {
  try {
    return JSON.parse(store.getItem(key) ?? 'null') ?? undefined;
  } catch {
    return undefined;
  }
}

function write(store: Storage, key: string, value: unknown): void {
  try {
    store.setItem(key, JSON.stringify(value));
  } catch {
    /* full or forbidden: then it is not remembered */
  }
}

const most = 40; // jobs

/** The daemon keeps results of a job, not what was asked: what the page asked it keeps itself. */
export function rememberJob(id: string, request: Request): void {
  if (sizeOf(request.inputs) > 20_000) return;
  const jobs = read<[string, Request][]>(localStorage, 'jobs') ?? [];
  write(localStorage, 'jobs', [[id, request], ...jobs].slice(0, most));
}

export function requestOfJob(id: string): Request | undefined {
  return read<[string, Request][]>(localStorage, 'jobs')?.find(([key]) => key === id)?.[1];
}

/** What is being edited survives a reload. */
export function rememberDraft(request: Request): void {
  if (sizeOf(request.inputs) <= 20_000) write(sessionStorage, `draft ${request.process}`, request);
}

export function draftOf(process: string): Request | undefined {
  return read<Request>(sessionStorage, `draft ${process}`);
}

export type Theme = 'system' | 'light' | 'dark';

export function theme(): Theme {
  return read<Theme>(localStorage, 'theme') ?? 'system';
}

export function setTheme(next: Theme): void {
  write(localStorage, 'theme', next);
  applyTheme();
}

export function applyTheme(): void {
  const now = theme();
  if (now === 'system') delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = now;
  dispatchEvent(new Event('themechange'));
}
