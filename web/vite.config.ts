import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { defineConfig, type Plugin } from 'vite';
import { leanThree } from './lean-three.ts';

const at = (path: string) => fileURLToPath(new URL(path, import.meta.url));

/** Adds sw.js, which keeps the page for use without a network: its list holds every file of the build. */
function offline(): Plugin {
  return {
    name: 'batten-offline',
    apply: 'build',
    generateBundle(_options, bundle) {
      const files = Object.keys(bundle).filter((name) => !name.endsWith('.map'));
      const hash = createHash('sha256');
      for (const name of files.sort()) {
        const file = bundle[name];
        hash.update(name);
        if (file) hash.update(file.type === 'chunk' ? file.code : file.source);
      }
      const source = readFileSync(at('src/offline.js'), 'utf8')
        .replace("'VERSION'", JSON.stringify(hash.digest('hex').slice(0, 16)))
        .replace("['FILES']", JSON.stringify(['./', 'phone.html', ...files.filter((name) => !name.endsWith('.html'))]));
      this.emitFile({ type: 'asset', fileName: 'sw.js', source });
    },
  };
}

/** What the page may do, wherever it is served: nothing from elsewhere, no code but its own. */
const POLICY = [
  "default-src 'self'",
  "script-src 'self' 'wasm-unsafe-eval'",
  "worker-src 'self'",
  "connect-src 'self'",
  "img-src 'self' blob: data:",
  "object-src 'none'",
  "base-uri 'none'",
].join('; ');

function policy(): Plugin {
  return {
    name: 'batten-policy',
    apply: 'build',
    transformIndexHtml: () => [
      { tag: 'meta', attrs: { 'http-equiv': 'Content-Security-Policy', content: POLICY }, injectTo: 'head-prepend' },
    ],
  };
}

export default defineConfig({
  base: './', // the page works from any folder of any server
  plugins: [leanThree(), offline(), policy()],
  resolve: {
    alias: [
      // Made by tools/build web. Patterns: what is imported ends in ?url.
      { find: /^batten-engine-wasm/, replacement: at('../build/web/engine/batten_engine.wasm') },
      { find: /^batten-engine/, replacement: at('../build/web/engine/batten_engine.mjs') },
      { find: /^batten-sample/, replacement: at('../data/sample.rawnet') },
    ],
  },
  build: { target: 'es2022', sourcemap: false, chunkSizeWarningLimit: 900, assetsInlineLimit: 0, rollupOptions: { input: [at('index.html'), at('phone.html')] } },
  worker: { format: 'es' },
  server: { fs: { allow: [at('..')] } },
  test: { include: ['tests/unit/**/*.test.ts'] },
} as Parameters<typeof defineConfig>[0]);
