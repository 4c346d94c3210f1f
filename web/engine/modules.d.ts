declare module 'batten-engine' {
  /** The class that web/engine/bindings.cpp offers. */
  export interface NativeEngine {
    handle(
      message: string,
      bytes: Uint8Array | string,
      progress: ((stage: string, fraction: number) => boolean) | null,
    ): { text: string; arrays: Record<string, EngineArray> };
    delete(): void;
  }
  export type EngineArray = Float32Array<ArrayBuffer> | Uint32Array<ArrayBuffer> | Uint8Array<ArrayBuffer>;
  export interface EngineModule {
    Engine: new () => NativeEngine;
    /** All of the engine's memory. */
    readonly HEAPU8: Uint8Array;
  }
  export default function load(options?: {
    locateFile?: (name: string) => string;
    wasmBinary?: ArrayBuffer | Uint8Array;
  }): Promise<EngineModule>;
}
declare module 'batten-engine-wasm?url' {
  const url: string;
  export default url;
}
declare module 'batten-sample?url' {
  const url: string;
  export default url;
}
