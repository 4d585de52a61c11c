import { render } from 'preact';
import { App } from './app';
import { applyTheme } from './lib/memory';
import './style/base.css';
import './style/form.css';
import './style/result.css';
import './style/views.css';

applyTheme();
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', applyTheme);
render(<App />, document.getElementById('app')!);
