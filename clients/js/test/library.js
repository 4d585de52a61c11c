/** The client under test: that of the build folder $SCATTERD_WEB, else that beside this folder. */

import { pathToFileURL } from 'node:url';

const built = process.env.SCATTERD_WEB;
export const library = await import(built ? pathToFileURL(`${built}/js/dist/index.js`) : '../dist/index.js');
