/** STEP files: the native library behind `batten studio` writes them, whichever engine holds the project. */
import { SocketEngine } from '../../engine/socket';
import type { AnyEngine } from '../../engine/engine';

/** The project goes to an engine of the server for as long as it takes. @throws EngineError */
export async function stepFile(own: AnyEngine, id: string): Promise<Uint8Array<ArrayBuffer>> {
  if (own instanceof SocketEngine) return (await own.ask({ op: 'save', object: id, format: 'step' })).arrays.file as Uint8Array<ArrayBuffer>;
  const { arrays } = await own.ask({ op: 'save' });
  const native = new SocketEngine(`${location.origin.replace(/^http/, 'ws')}/engine`);
  try {
    await native.start();
    await native.ask({ op: 'open', name: 'project.batten' }, (arrays.file as Uint8Array<ArrayBuffer>).slice().buffer);
    return (await native.ask({ op: 'save', object: id, format: 'step' })).arrays.file as Uint8Array<ArrayBuffer>;
  } finally {
    native.end();
  }
}
