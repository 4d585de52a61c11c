/** Starts the daemon of $SCATTERD on a free port, with a directory of its own. */

import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { mkdtemp, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { createInterface } from 'node:readline';

export async function startDaemon({ port = 0, directory, options = [] } = {}) {
  const data = directory ?? (await mkdtemp(join(tmpdir(), 'scatterd-js-')));
  const args = ['--listen', `127.0.0.1:${port}`, '--data-dir', data, ...options];
  const child = spawn(process.env.SCATTERD, args, { stdio: ['ignore', 'ignore', 'pipe'] });
  const url = `http://${await addressOf(child)}`;
  return {
    url,
    port: Number(new URL(url).port),
    data,
    async stop({ keep = false, signal = 'SIGTERM' } = {}) {
      if (child.exitCode === null && child.signalCode === null) {
        child.kill(signal);
        await once(child, 'exit');
      }
      if (!keep) await rm(data, { recursive: true, force: true });
    },
  };
}

function addressOf(child) {
  return new Promise((resolve, reject) => {
    const lines = createInterface({ input: child.stderr });
    const seen = [];
    lines.on('line', (line) => {
      seen.push(line);
      const found = /event=listening address=(\S+)/.exec(line);
      if (found) resolve(found[1]);
    });
    child.on('exit', () => reject(new Error(`the daemon ended: ${seen.join('\n')}`)));
    child.on('error', reject);
  });
}
