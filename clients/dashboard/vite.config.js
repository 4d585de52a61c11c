import { defineConfig } from 'vite';

/* For `npm run dev`: the daemon that answers; the built page talks to the daemon that serves it. */
const daemon = process.env.SCATTERD_URL ?? 'http://127.0.0.1:8480';
const paths = ['/processes', '/jobs', '/data', '/readyz', '/api', '/conformance'];

export default defineConfig({
  base: './',
  esbuild: { jsx: 'automatic', jsxImportSource: 'preact' },
  build: {
    target: 'es2022',
    modulePreload: { polyfill: false },
    assetsInlineLimit: 0,
    reportCompressedSize: false,
  },
  server: { proxy: Object.fromEntries(paths.map((path) => [path, daemon])) },
});
