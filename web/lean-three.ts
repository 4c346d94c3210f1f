/** three without the shaders that the page does not draw with, headsets and reflections of surroundings: a fifth of its bytes. */
import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import type { Plugin } from 'vite';

const at = (path: string) => fileURLToPath(new URL(path, import.meta.url));
const THREE = at('node_modules/three/src/');
const CHUNKS = `${THREE}renderers/shaders/ShaderChunk/`;
const LIBRARY = `${THREE}renderers/shaders/ShaderLib/`;

/** What draws: the materials of the page and those of three that it takes, and what every program begins with. */
const DRAWN = [
  at('src/view/materials.ts'),
  at('node_modules/three/examples/jsm/lines/LineMaterial.js'),
  `${LIBRARY}points.glsl.js`,
  `${THREE}renderers/webgl/WebGLProgram.js`,
];

/** Names of the chunks that these files take, and those that they include in turn. */
function chunksOf(files: string[]): Set<string> {
  const names = new Set<string>();
  const read = (file: string) => {
    for (const [, name] of readFileSync(file, 'utf8').matchAll(/(?:#include <|ShaderChunk\[ ')(\w+)/g))
      if (name && !names.has(name)) {
        names.add(name);
        read(`${CHUNKS}${name}.glsl.js`);
      }
  };
  files.forEach(read);
  return names;
}

/** What takes the place of modules; each has what WebGLRenderer asks of it while it is not used. */
const ABSENT: Record<string, string> = {
  'renderers/webxr/WebXRManager.js': `
import { EventDispatcher } from '${THREE}core/EventDispatcher.js';
export class WebXRManager extends EventDispatcher {
  enabled = false;
  isPresenting = false;
  cameraAutoUpdate = false;
  getFoveation() {}
  setFoveation() {}
  setAnimationLoop() {}
  getEnvironmentBlendMode() {}
  dispose() {}
}`,
  'extras/PMREMGenerator.js': `export class PMREMGenerator {
  constructor() { throw new Error('environments are not in this build of three: see lean-three.ts'); }
}`,
};

export function leanThree(): Plugin {
  const drawn = chunksOf(DRAWN);
  return {
    name: 'batten-lean-three',
    apply: 'build',
    config: () => ({ resolve: { alias: [{ find: /^three$/, replacement: `${THREE}Three.js` }] } }),
    load(id) {
      if (id.startsWith(THREE)) return ABSENT[id.slice(THREE.length)];
    },
    transform(code, id) {
      const isChunk = id.startsWith(CHUNKS);
      if (!isChunk && !id.startsWith(LIBRARY)) return;
      const name = id.slice((isChunk ? CHUNKS : LIBRARY).length).replace('.glsl.js', '');
      const isDrawn = isChunk ? drawn.has(name) : DRAWN.includes(id);
      if (isDrawn) return code.replace(/\/\/.*$/gm, '').replace(/\n\s+/g, '\n');
      return isChunk ? "export default ''" : "export const vertex = '', fragment = ''";
    },
  };
}
