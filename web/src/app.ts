/** What panels and commands ask for: puts the store and the view together. */
import { effect, signal } from '@preact/signals';
import sample from 'batten-sample?url';
import { EngineError } from '../engine/engine';
import { SocketEngine } from '../engine/socket';
import { ACCEPTED, bytesOf, choose, download, fileName } from './document/files';
import { type Folder, Server, type ServerFile } from './document/server';
import type { Store } from './document/store';
import type { Drawn, ObjectEntry, RequestOptions } from './document/types';
import { register } from './ui/commands';
import type { Pin } from './ui/pins';
import { SHOWN_UNITS, shownUnit } from './ui/numbers';
import { startTour } from './ui/tour';
import type { NamedView } from './view/camera';
import type { Shading } from './view/materials';
import type { View } from './view/scene';

export type Room = 'reconstruct' | 'sketch' | 'inspect' | 'process' | 'capture';
export const ROOMS: readonly (readonly [Room, string])[] = [
  ['reconstruct', 'Reconstruct'],
  ['sketch', 'Sketch'],
  ['inspect', 'Inspect'],
  ['process', 'Process'],
  ['capture', 'Capture'],
];

export interface Look {
  shading: 'shaded' | 'wireframe' | 'isophotes' | 'reflection-lines' | 'normal-map' | 'mean-curvature' | 'gaussian-curvature' | 'uncertainty' | 'error';
  stripes: number;
  flat: boolean;
  curves: boolean;
}

/** Triangles. */
const NATIVE_ABOVE = 150_000;
const UNIT_KEY = 'batten-unit';
const COMPUTED_SHADINGS = ['mean-curvature', 'gaussian-curvature', 'uncertainty'];
const VALUE_SHADINGS = [...COMPUTED_SHADINGS, 'error'];

/** Linear colours as a gradient of the page. */
function rampOf(rgb: Float32Array): string {
  const stops: string[] = [];
  for (let i = 0; i < rgb.length / 3; i += 15)
    stops.push(`color(srgb-linear ${[0, 1, 2].map((k) => (rgb[3 * i + k] ?? 0).toFixed(4)).join(' ')})`);
  return `linear-gradient(to top, ${stops.join(', ')})`;
}

export class App {
  readonly room = signal<Room>('reconstruct');
  readonly look = signal<Look>({ shading: 'shaded', stripes: 28, flat: false, curves: true });
  readonly palette = signal(false);
  readonly help = signal(false);
  /** What is seen of a step: what it made, what it was made of, or both beside each other. */
  readonly seen = signal<'after' | 'before' | 'both'>('after');
  readonly theme = signal<'system' | 'light' | 'dark'>('system');
  /** The colour bars as backgrounds, from below to above. */
  readonly ramps = signal({ sequential: '', diverging: '' });
  /** The files of the server's folder, where there is one. */
  readonly folder = signal<Folder | null>(null);
  readonly hasServer = signal(false);
  private server: Server | null = null;
  private offered = false;
  /** What is being computed at this moment, and the mesh that distances are measured to. */
  private colouring: { drawn: Drawn; shading: string } | null = null;
  private distanceTo: { object: string; truth: string } | null = null;
  /** Places with something to be said of them. */
  readonly pins = signal<Pin[]>([]);
  view: View | null = null;
  private readonly started: Promise<void>;

  constructor(readonly store: Store) {
    try {
      shownUnit.value = localStorage.getItem(UNIT_KEY) ?? '';
    } catch {
      // each object's own, then
    }
    this.registerCommands();
    this.started = store.start(true);
    void this.findServer();
    this.started.catch((error: unknown) =>
      store.tell('error', `The engine could not be started: ${error instanceof Error ? error.message : String(error)}.`, 'Load the page again, or take another browser.'),
    );
  }

  /** The view follows the store. */
  attach(view: View): void {
    this.view = view;
    void this.started.then(async () => {
      const { arrays } = await this.store.engine.ask({ op: 'colours' });
      const sequential = arrays.sequential as Float32Array;
      const diverging = arrays.diverging as Float32Array;
      view.setColours(sequential, diverging);
      this.ramps.value = { sequential: rampOf(sequential), diverging: rampOf(diverging) };
    }, () => {});
    effect(() => view.setObjects(this.visible()));
    effect(() => {
      const largest = Math.max(0, ...[...this.store.drawn.value.values()].map((one) => one.mesh?.n_triangles ?? 0));
      if (largest > NATIVE_ABOVE && this.hasServer.value && !this.offered) {
        this.offered = true;
        this.store.tell('info', 'This is a large model; the native engine of the server is faster.', 'Ctrl+K, "Use the native engine".');
      }
    });
    effect(() => {
      const look = this.look.value;
      const shading: Shading = VALUE_SHADINGS.includes(look.shading) ? 'values' : (look.shading as Shading);
      view.setLook({ shading, stripes: look.stripes, flat: look.flat, curves: look.curves, nodes: true });
    });
    effect(() => view.setValues(this.store.values.value));
    effect(() => this.colour());
    effect(() => {
      const found = this.store.continuity.value;
      void this.store.drawn.value;
      view.setVerdicts(found?.object ?? null, found?.curves ?? []);
    });
  }

  private visible(): Drawn[] {
    const { objects, drawn, hidden } = this.store;
    const selected = this.store.selectedObject.value;
    const before = this.seen.value !== 'after' ? selected?.source : undefined;
    return objects.value
      .filter((one) => {
        if (hidden.value.has(one.id)) return false;
        if (before) return one.id === before || (this.seen.value === 'both' && one.id === selected?.id);
        return this.store.isShown(one);
      })
      .flatMap((one) => drawn.value.get(one.id) ?? []);
  }

  // ---- files ------------------------------------------------------------------------------------------------------

  async openFiles(files: readonly (readonly [string, Blob])[]): Promise<void> {
    for (const [fullName, blob] of files) {
      let read: { name: string; bytes: ArrayBuffer };
      try {
        read = await bytesOf(blob, fullName);
      } catch {
        this.store.tell('error', `${fullName} cannot be read; its compression is damaged.`);
        continue;
      }
      const id = await this.store.open(read.name, read.bytes);
      if (!id) continue;
      const kind = this.store.objects.value.find((one) => one.id === id)?.kind;
      if (kind === 'scan') {
        this.room.value = 'reconstruct';
        await this.store.reconstruct(id);
      } else if (this.room.value === 'reconstruct' && kind === 'mesh') {
        this.room.value = 'inspect';
      }
      await this.store.showAll();
      this.view?.fit();
    }
  }

  async chooseFiles(): Promise<void> {
    await this.openFiles((await choose(ACCEPTED)).map((file) => [file.name, file] as const));
  }

  async openSample(): Promise<void> {
    const answer = await fetch(sample);
    await this.openFiles([['sample.rawnet', await answer.blob()] as const]);
    startTour();
  }

  private async findServer(): Promise<void> {
    this.server = await Server.connect();
    this.hasServer.value = this.server !== null;
    if (!this.server || this.server.folder === null) return;
    try {
      await this.started;
      this.folder.value = await this.server.files();
      const wanted = this.folder.value.files.find((one) => one.number === this.folder.value?.open);
      if (wanted && this.store.objects.value.length === 0) await this.openServerFile(wanted);
    } catch (error) {
      this.store.tell('error', error instanceof Error ? error.message : String(error));
    }
  }

  async openServerFile(file: ServerFile): Promise<void> {
    if (!this.server) return;
    if (file.name.endsWith('.blog')) {
      this.room.value = 'capture'; // which makes scans of recordings
      return;
    }
    try {
      await this.openFiles([[file.name.replace(/^.*\//, ''), await this.server.bytes(file)] as const]);
    } catch (error) {
      this.store.tell('error', `${file.name}: ${error instanceof Error ? error.message : String(error)}`);
    }
  }

  /** Big models are faster outside the page: the project goes over to the server's engine. */
  async useNative(): Promise<void> {
    try {
      await this.store.moveTo(new SocketEngine(`${location.origin.replace(/^http/, 'ws')}/engine`));
      this.store.tell('info', 'The native engine works now. Save the project: the browser does not keep it any more.');
    } catch (error) {
      this.store.tell('error', error instanceof Error ? error.message : String(error));
    }
  }

  /** Into the server's folder where there is one, else as a download. */
  private async keep(bytes: Uint8Array<ArrayBuffer>, name: string): Promise<void> {
    if (!this.server || this.server.folder === null) {
      download(bytes, name);
      return;
    }
    try {
      const data = new Blob([bytes]);
      const written = (await this.server.write(name, data, false)) || (confirm(`Replace ${name}?`) && (await this.server.write(name, data, true)));
      if (!written) return;
      this.store.tell('info', `${name} is in the folder ${this.server.folder}.`);
      this.folder.value = await this.server.files();
    } catch (error) {
      this.store.tell('error', error instanceof Error ? error.message : String(error), 'It is downloaded instead.');
      download(bytes, name);
    }
  }

  async saveObject(format: string): Promise<void> {
    const object = this.store.selectedObject.value;
    if (!object) return;
    if (format === 'step') {
      await this.saveStep(object.id, object.name);
      return;
    }
    const bytes = await this.store.save(object.id, format);
    if (bytes) await this.keep(bytes, fileName(object.name, format));
  }

  private async saveStep(id: string, name: string): Promise<void> {
    if (!this.hasServer.value) {
      this.store.tell(
        'info',
        'STEP files are written by the native library, which is not in this page.',
        'Open the page by "batten studio", or save the network and run "batten surface network.json -o surface.step".',
      );
      return;
    }
    try {
      const { stepFile } = await import('./document/step');
      await this.keep(await stepFile(this.store.engine, id), fileName(name, 'step'));
    } catch (error) {
      this.store.tell('error', error instanceof Error ? error.message : String(error), error instanceof EngineError ? error.remedy : undefined);
    }
  }

  /** What an object can be saved as, those of the server among it. */
  formatsOf(object: ObjectEntry): string[] {
    const isSurface = object.request?.kind === 'surface' || object.request?.kind === 'model-surface';
    return isSurface && !object.formats.includes('step') ? [...object.formats, 'step'] : object.formats;
  }

  async saveProject(): Promise<void> {
    const bytes = await this.store.save(null, 'batten');
    if (bytes) await this.keep(bytes, fileName(this.store.objects.value[0]?.name ?? 'project', 'batten'));
  }

  async savePicture(): Promise<void> {
    const picture = await this.view?.picture();
    if (picture) download(picture, fileName(this.store.selectedObject.value?.name ?? 'picture', 'png'));
  }

  saveText(text: string, name: string, extension: string): void {
    download(new Blob([text]), fileName(name, extension));
  }

  /** Says in which unit the numbers of an object are, and of what it was made of and what was made of it. */
  async setObjectUnit(object: ObjectEntry, unit: string): Promise<void> {
    let root = object;
    for (let next: ObjectEntry | undefined = object; next; next = this.store.objects.value.find((one) => one.id === root.source)) root = next;
    if (await this.store.edit({ op: 'unit', object: root.id, unit })) await this.store.showAll();
  }

  /** The unit that lengths are shown in; empty: each object's own. */
  setUnit(unit: string): void {
    shownUnit.value = unit;
    try {
      localStorage.setItem(UNIT_KEY, unit);
    } catch {
      // a browser that keeps nothing
    }
  }

  // ---- looking ----------------------------------------------------------------------------------------------------

  /** Colours that have to be computed follow (see `colour`). */
  setLook(patch: Partial<Look>): void {
    this.look.value = { ...this.look.value, ...patch };
  }

  /** Colours that belong to what is selected: computed when they are asked for, and again when it was made anew. */
  private colour(): void {
    const { shading } = this.look.value;
    const object = this.store.selectedObject.value;
    const drawn = object && this.store.drawn.value.get(object.id);
    const known = this.store.values.value;
    if (!drawn?.mesh || drawn.coarse || (known?.object === drawn.id && known.shading === shading)) return;
    if (this.colouring?.drawn === drawn && this.colouring.shading === shading) return;
    let done: Promise<boolean>;
    if (COMPUTED_SHADINGS.includes(shading)) done = this.store.computeValues(drawn.id, shading);
    else if (shading === 'error' && this.distanceTo?.object === drawn.id) done = this.store.computeDistances(drawn.id, this.distanceTo.truth);
    else return;
    const colouring = { drawn, shading };
    this.colouring = colouring;
    void done.then((isDone) => {
      if (this.colouring !== colouring) return;
      this.colouring = null;
      if (!isDone && this.look.value.shading === shading) this.setLook({ shading: 'shaded' });
    });
  }

  showDistances(object: string, truth: string): void {
    this.distanceTo = { object, truth };
    this.colouring = null; // distances to another mesh may be on their way
    this.store.values.value = null;
    this.setLook({ shading: 'error' });
  }

  pointAt(id: string, place: [number, number, number]): void {
    this.view?.setPin(id, place);
  }

  async select(id: string): Promise<void> {
    this.store.selected.value = id;
    this.seen.value = 'after';
    this.view?.setPin(id, null);
    await this.store.showAll();
  }

  async toggleHidden(id: string): Promise<void> {
    const hidden = new Set(this.store.hidden.value);
    if (!hidden.delete(id)) hidden.add(id);
    this.store.hidden.value = hidden;
    await this.store.showAll();
  }

  // ---- steps ------------------------------------------------------------------------------------------------------

  async process(source: string, name: string, request: RequestOptions): Promise<void> {
    const id = await this.store.derive(source, name, request);
    if (!id) return;
    if (!(await this.store.show(id))) await this.store.edit({ op: 'undo' }); // nothing came of it; its sentence is told
    await this.store.showAll();
  }

  async throwAway(id: string): Promise<void> {
    const source = this.store.objects.value.find((one) => one.id === id)?.source;
    if (await this.store.edit({ op: 'remove', object: id })) {
      this.seen.value = 'after';
      this.store.selected.value = source ?? null;
      await this.store.showAll();
    }
  }

  async setSeen(value: 'after' | 'before' | 'both'): Promise<void> {
    const source = this.store.selectedObject.value?.source;
    if (value !== 'after' && source) await this.store.show(source);
    this.seen.value = value;
  }

  // ---- commands ---------------------------------------------------------------------------------------------------

  private registerCommands(): void {
    const { store } = this;
    const hasObjects = () => store.objects.value.length > 0;
    const hasMesh = () => store.selectedObject.value?.kind === 'mesh';
    const shadings: [Look['shading'], string, string][] = [
      ['shaded', 'Shaded', 'Shift+S'],
      ['isophotes', 'Isophotes', 'Shift+Z'],
      ['reflection-lines', 'Reflection lines', 'Shift+R'],
      ['normal-map', 'Normals', 'Shift+N'],
      ['mean-curvature', 'Mean curvature', 'Shift+M'],
      ['gaussian-curvature', 'Gaussian curvature', 'Shift+G'],
      ['wireframe', 'Triangles', 'Shift+W'],
      ['uncertainty', 'How sure it is', 'Shift+U'],
    ];
    const views: [NamedView, string, string][] = [
      ['front', 'front', '1'],
      ['right', 'right', '2'],
      ['top', 'top', '3'],
      ['back', 'back', '4'],
      ['left', 'left', '5'],
      ['bottom', 'bottom', '6'],
      ['home', 'home', 'H'],
    ];
    register(
      { id: 'open', title: 'Open a file', keys: 'Ctrl+O', run: () => this.chooseFiles() },
      { id: 'open-sample', title: 'Open the sample scan', run: () => this.openSample() },
      { id: 'save-project', title: 'Save the project', keys: 'Ctrl+S', when: hasObjects, run: () => this.saveProject() },
      { id: 'save-picture', title: 'Save a picture', keys: 'Ctrl+P', when: hasObjects, run: () => this.savePicture() },
      ...['ply', 'obj', 'stl', '3mf', 'glb', 'step', 'json', 'rawnet'].map((format) => ({
        id: `save-${format}`,
        title: `Save the selected object as ${format.toUpperCase()}`,
        when: () => store.selectedObject.value !== null && this.formatsOf(store.selectedObject.value).includes(format),
        run: () => this.saveObject(format),
      })),
      { id: 'new', title: 'New project', when: hasObjects, run: () => store.clear() },
      { id: 'undo', title: 'Undo', keys: 'Ctrl+Z', when: () => store.canUndo.value, run: () => store.undo() },
      { id: 'redo', title: 'Redo', keys: 'Ctrl+Shift+Z', when: () => store.canRedo.value, run: () => store.redo() },
      {
        id: 'tour',
        title: 'Tour of the studio',
        run: async () => {
          if (!hasObjects()) await this.openSample();
          startTour(true);
        },
      },
      {
        id: 'native',
        title: 'Use the native engine of the server',
        when: () => this.hasServer.value && !(store.engine instanceof SocketEngine),
        run: () => this.useNative(),
      },
      { id: 'palette', title: 'Find a command', keys: 'Ctrl+K', run: () => void (this.palette.value = true) },
      { id: 'keys', title: 'Keys and mouse', keys: '?', run: () => void (this.help.value = !this.help.value) },
      { id: 'fit', title: 'Fit the view', keys: 'F', run: () => this.view?.fit() },
      ...views.map(([view, title, keys]) => ({
        id: `view-${view}`,
        title: `View from ${title}`,
        keys,
        run: () => this.view?.lookFrom(view),
      })),
      ...shadings.map(([shading, title, keys]) => ({
        id: `shading-${shading}`,
        title: `Show ${title.toLowerCase()}`,
        keys,
        when: hasMesh,
        run: () => this.setLook({ shading }),
      })),
      { id: 'curves', title: 'Show or hide curves', keys: 'C', run: () => this.setLook({ curves: !this.look.value.curves }) },
      ...ROOMS.map(([room, title], i) => ({
        id: `room-${room}`,
        title: `Go to ${title}`,
        keys: `Ctrl+${i + 1}`,
        run: () => void (this.room.value = room),
      })),
      {
        id: 'theme',
        title: 'Light or dark',
        run: () => {
          const dark = this.theme.value === 'dark' || (this.theme.value === 'system' && matchMedia('(prefers-color-scheme: dark)').matches);
          this.theme.value = dark ? 'light' : 'dark';
        },
      },
      {
        id: 'unit',
        title: 'Next unit of lengths',
        keys: 'U',
        run: () => this.setUnit(['', ...SHOWN_UNITS][(1 + ['', ...SHOWN_UNITS].indexOf(shownUnit.value)) % (1 + SHOWN_UNITS.length)] ?? ''),
      },
      { id: 'stop', title: 'Stop what is being computed', keys: 'Escape', when: () => store.work.value !== null, run: () => store.cancel() },
    );
  }
}
