/** `batten studio` behind the page, where it is there (docs/studio-server.md): the files of a folder, by numbers. */

export interface ServerFile {
  number: number;
  name: string;
  size: number;
}

export interface Folder {
  folder: string | null;
  /** The file that the studio was started for. */
  open: number | null;
  files: ServerFile[];
  left_out: number;
}

export class Server {
  private constructor(readonly folder: string | null) {}

  /** Trades the secret of the address for a cookie, once; on later visits the cookie is asked. Null without a server. */
  static async connect(): Promise<Server | null> {
    const secret = /^#[0-9A-Za-z_-]{16,}$/.test(location.hash) ? location.hash.slice(1) : null;
    if (secret) history.replaceState(null, '', location.pathname + location.search);
    try {
      const answer = secret
        ? await fetch('./session', { method: 'POST', body: JSON.stringify({ secret }) })
        : await fetch('./session');
      if (!answer.ok || !answer.headers.get('content-type')?.startsWith('application/json')) return null;
      const said = (await answer.json()) as { ok: boolean; folder: string | null };
      return said.ok ? new Server(said.folder) : null;
    } catch {
      return null; // no server, or another one
    }
  }

  async files(): Promise<Folder> {
    return (await this.asked(await fetch('./files'))).json() as Promise<Folder>;
  }

  async bytes(file: ServerFile): Promise<Blob> {
    return (await this.asked(await fetch(`./files/${file.number}`))).blob();
  }

  /** @returns false where there is a file of this name, and it may not be replaced. */
  async write(name: string, data: Blob, replace: boolean): Promise<boolean> {
    const answer = await fetch(`./files?name=${encodeURIComponent(name)}${replace ? '&replace=1' : ''}`, { method: 'POST', body: data });
    if (answer.status === 409) return false;
    await this.asked(answer);
    return true;
  }

  private async asked(answer: Response): Promise<Response> {
    if (answer.ok) return answer;
    const said = (await answer.json().catch(() => null)) as { message?: string } | null;
    throw new Error(said?.message ?? `the server answered ${answer.status}`);
  }
}
