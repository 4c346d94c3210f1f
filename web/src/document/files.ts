/** Files in and out: dropped, chosen, fetched; saved by download. What is packed with gzip is unpacked here. */

export async function bytesOf(file: Blob, name: string): Promise<{ name: string; bytes: ArrayBuffer }> {
  const head = new Uint8Array(await file.slice(0, 2).arrayBuffer());
  if (head[0] === 0x1f && head[1] === 0x8b) {
    const unpacked = file.stream().pipeThrough(new DecompressionStream('gzip'));
    return { name: name.replace(/\.gz$/, ''), bytes: await new Response(unpacked).arrayBuffer() };
  }
  return { name, bytes: await file.arrayBuffer() };
}

export function download(data: Blob | Uint8Array<ArrayBuffer>, name: string): void {
  const url = URL.createObjectURL(data instanceof Blob ? data : new Blob([data]));
  const link = document.createElement('a');
  link.href = url;
  link.download = name;
  link.click();
  // The download has begun when the click returns; the address is needed a little longer.
  setTimeout(() => URL.revokeObjectURL(url), 60_000);
}

export function choose(accept: string): Promise<File[]> {
  return new Promise((resolve) => {
    const input = document.createElement('input');
    input.type = 'file';
    input.multiple = true;
    input.accept = accept;
    input.onchange = () => resolve([...(input.files ?? [])]);
    input.oncancel = () => resolve([]);
    input.click();
  });
}

/** A name that every system takes. */
export function fileName(name: string, extension: string): string {
  return `${name.replace(/[^\p{L}\p{N} _.-]/gu, '_').trim() || 'object'}.${extension}`;
}

export const ACCEPTED =
  '.rawnet,.csv,.txt,.net,.json,.lop,.obj,.ply,.off,.stl,.glb,.gltf,.3mf,.batten,.jsonl,.gz';
