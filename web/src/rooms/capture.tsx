/** A device in the hand, or a simulated one, followed while it records; what it recorded becomes a scan. */
import { useState } from 'preact/hooks';
import type { App } from '../app';
import { bytesOf, choose } from '../document/files';
import { Choice, Figures, Section } from '../ui/controls';
import { length, milliseconds, percent, short } from '../ui/numbers';
import { type Capturing, capturingOf, type CaptureNews, type CaptureState, freeName, type SourceEntry } from './capturing';
import { Sentences } from './reconstruct';

export function CapturePanel({ app }: { app: App }) {
  if (!app.hasServer.value)
    return <p class="empty">Devices are read by the program behind the page: start <code>batten studio FOLDER</code> and open the address that it prints.</p>;
  return <Desk app={app} capturing={capturingOf(app)} />;
}

function Desk({ app, capturing }: { app: App; capturing: Capturing }) {
  const news = capturing.news.value;
  const doing = news?.doing ?? 'nothing';
  const isFollowed = doing === 'record' || doing === 'replay';
  return (
    <>
      <h2>Capture</h2>
      {!capturing.isLinked.value && <p class="problem">The server does not answer; it is asked again every second.</p>}
      {isFollowed && (
        <button type="button" class="primary" title="Ctrl+Enter" onClick={() => void capturing.stop()}>
          {doing === 'record' ? 'Stop recording' : 'Stop the replay'}
        </button>
      )}
      {news?.problem && <p class="problem" role="alert">{news.problem}</p>}
      {!isFollowed && news?.report && <Result capturing={capturing} news={news} report={news.report} />}
      {news?.state && <Live capturing={capturing} news={news} state={news.state} />}
      {doing === 'record' && <Keypad capturing={capturing} digits={news?.state?.digits ?? ''} />}
      {!isFollowed && <Choose app={app} capturing={capturing} />}
      {doing !== 'record' && <Recordings capturing={capturing} busy={doing !== 'nothing'} />}
    </>
  );
}

// ---- before ---------------------------------------------------------------------------------------------------------

const KINDS: readonly (readonly [string, (source: string) => boolean])[] = [
  ['Simulated devices', (source) => source.startsWith('simulator:')],
  ['Serial ports', (source) => /^(line|morphorider):/.test(source)],
  ['Network', (source) => /^(ws|udp):/.test(source)],
];

const FAULTS = [
  ['', 'none'],
  ['flip=0.05%', 'a wrong bit in 1 % of the packets'],
  ['flip=1%', 'a wrong bit in 1 % of the bytes'],
  ['unplug=5:2', 'unplugged for two seconds'],
  ['burst=0.1', 'delivered in bursts'],
  ['slip=5:2', 'the wheel slips for two seconds'],
] as const;

/** A source as `batten capture` takes it. */
export function sourceText(source: string, device: string, faults: string, speed: string): string {
  if (!source.startsWith('simulator:')) return source;
  const options = [device === 'line' && 'device=line', faults, speed !== '1' && `speed=${speed}`].filter(Boolean).join('&');
  return options ? `${source}?${options}` : source;
}

/** Whether the length of a turn of the wheel has to be told: devices of the line protocol say it themselves. */
export const asksForWheel = (source: string): boolean => /^(morphorider:|simulator:)/.test(source) && !/[?&]device=line/.test(source);

function Choose({ app, capturing }: { app: App; capturing: Capturing }) {
  const [source, setSource] = useState('simulator:bumpycube');
  const [device, setDevice] = useState('morphorider');
  const [faults, setFaults] = useState('');
  const [speed, setSpeed] = useState('1');
  const [typed, setTyped] = useState<string | null>(null);
  const [name, setName] = useState<string | null>(null);
  const [wheel, setWheel] = useState('62.8');
  const [nodes, setNodes] = useState('');
  const [calibration, setCalibration] = useState<{ name: string; text: string } | null>(null);
  const asked = typed ?? sourceText(source, device, faults, speed);
  const named = name ?? freeName(capturing.recordings.value.map((one) => one.name));
  const set = <T,>(change: (value: T) => void) => (value: T) => {
    setTyped(null);
    change(value);
  };
  const start = async () => {
    await capturing.record({
      source: asked.trim(),
      name: named.trim(),
      ...(asksForWheel(asked) && Number(wheel) > 0 ? { wheel_m: Number(wheel) / 1000 } : {}),
      ...(Number(nodes) >= 1 ? { nodes: Math.round(Number(nodes)) } : {}),
      ...(calibration ? { calibration: calibration.text } : {}),
    });
    setName(null);
  };
  const chooseCalibration = async () => {
    const [file] = await choose('.json');
    if (!file) return;
    const read = await bytesOf(file, file.name);
    setCalibration({ name: read.name, text: new TextDecoder().decode(read.bytes) });
  };
  return (
    <Section title="Record">
      {capturing.folder.value === null && <p class="problem">Recordings are files: start <code>batten studio</code> with a folder for them.</p>}
      <SourceChoice list={capturing.sources.value} value={source} onChange={set(setSource)} />
      {source.startsWith('simulator:') && (
        <>
          <Choice
            label="Device"
            value={device}
            options={[
              ['morphorider', 'Morphorider'],
              ['line', 'of the line protocol'],
            ]}
            onChange={set(setDevice)}
          />
          <Choice label="Faults" help="What goes wrong with the simulated device." value={faults} options={FAULTS as readonly (readonly [string, string])[]} onChange={set(setFaults)} />
          <Choice
            label="Speed"
            value={speed}
            options={[
              ['1', 'real time'],
              ['4', '4 times'],
              ['max', 'as fast as it goes'],
            ]}
            onChange={set(setSpeed)}
          />
        </>
      )}
      <Text label="Source" help="As batten capture takes it; more options can be typed." value={asked} onChange={setTyped} />
      <Text label="Recording" help="A new file of the folder." value={named} onChange={setName} />
      {asksForWheel(asked) && <Text label="Wheel, mm" help="Its circumference: roll it along a metre and count." value={wheel} onChange={setWheel} />}
      <Text label="Nodes" help="Of the network. Below 10 one digit is a node at once; empty: not known." value={nodes} onChange={setNodes} />
      <div class="tools">
        <button type="button" onClick={() => void chooseCalibration()}>
          Calibration…
        </button>
        {calibration && <span class="hint">{calibration.name}</span>}
      </div>
      <div class="tools">
        <button type="button" class="primary" disabled={!capturing.isLinked.value || capturing.folder.value === null || !app.store.started.value} onClick={() => void start()}>
          Start recording
        </button>
        <button type="button" onClick={() => void capturing.look()}>
          Look again for devices
        </button>
      </div>
    </Section>
  );
}

function SourceChoice(props: { list: SourceEntry[]; value: string; onChange: (source: string) => void }) {
  return (
    <div class="field">
      <label for="capture-source">From</label>
      <select id="capture-source" value={props.value} onChange={(event) => props.onChange(event.currentTarget.value)}>
        {KINDS.map(([title, belongs]) => {
          const some = props.list.filter((one) => belongs(one.source));
          return some.length > 0 ? (
            <optgroup key={title} label={title}>
              {some.map((one) => (
                <option key={one.source} value={one.source} title={one.what}>
                  {one.source}
                </option>
              ))}
            </optgroup>
          ) : null;
        })}
      </select>
    </div>
  );
}

function Text(props: { label: string; help: string; value: string; onChange: (value: string) => void }) {
  return (
    <div class="field">
      <label>{props.label}</label>
      <input type="text" aria-label={props.label} value={props.value} onInput={(event) => props.onChange(event.currentTarget.value)} />
      <small class="help">{props.help}</small>
    </div>
  );
}

// ---- meanwhile ------------------------------------------------------------------------------------------------------

function deviceWords(device: string): string {
  if (device.startsWith('lost')) return `${device}. It is opened anew twice a second, and the recording goes on.`;
  return ({ open: 'answers', back: 'answers again', end: 'over' } as Record<string, string>)[device] ?? '–';
}

function Live({ capturing, news, state }: { capturing: Capturing; news: CaptureNews; state: CaptureState }) {
  const delays = capturing.delays.value;
  const isLost = state.device.startsWith('lost');
  const drift = state.drift_m === null ? '–' : `${length(1000 * state.drift_m, 'mm')} at node ${state.drift_node}, ${percent(state.drift_way_m > 0 ? state.drift_m / state.drift_way_m : 0)} of the way`;
  return (
    <Section title={news.name}>
      {isLost && (
        <p class="problem" role="alert">
          {deviceWords(state.device)}
        </p>
      )}
      <Figures
        rows={[
          ['device', isLost ? 'lost' : deviceWords(state.device)],
          ['time', `${state.seconds.toFixed(1)} s`],
          ['rate', `${short(Math.round(state.rate_hz))} Hz ± ${short(1000 * state.jitter_s, 2)} ms`],
          ['curve', state.curves === 0 ? '–' : `${state.curves}${state.paused ? ', pause' : state.drawing ? '' : ', finished'}`],
          ['along it', length(1000 * state.distance_m, 'mm', 1)],
          ['nodes', short(state.nodes)],
          ['drift', drift],
          ['readings', short(state.readings)],
          ['gaps', `${short(state.gaps)}, ${short(state.missing)} readings missing`],
          ['refused', `${short(state.refused)}, ${percent(state.refused / Math.max(1, state.readings + state.refused))}`],
          ['to the picture', delays ? `${milliseconds(delays.median)}, 95 % below ${milliseconds(delays.most)}` : '–'],
        ]}
      />
      <p class="hint">Some per cent of drift are usual. A jump says that the wheel slipped, or that a node has the wrong number.</p>
    </Section>
  );
}

const KEYS: readonly (readonly [key: string, sign: string, title: string])[] = [
  ['+', '+', 'New curve inside the surface'],
  ['-', '−', 'New curve on its border'],
  ['.', '.', 'Finish the curve'],
  ['/', '/', 'Forget the curve'],
  ['7', '7', 'Node 7'],
  ['8', '8', 'Node 8'],
  ['9', '9', 'Node 9'],
  ['*', '*', 'Pause, and go on'],
  ['4', '4', 'Node 4'],
  ['5', '5', 'Node 5'],
  ['6', '6', 'Node 6'],
  ['backspace', '⌫', 'The last digit, or the last node, was wrong'],
  ['1', '1', 'Node 1'],
  ['2', '2', 'Node 2'],
  ['3', '3', 'Node 3'],
  ['enter', '⏎', 'The number of the node is whole'],
  ['0', '0', 'Node 0'],
];

function Keypad({ capturing, digits }: { capturing: Capturing; digits: string }) {
  return (
    <Section title="Keys">
      <div class="keypad">
        {KEYS.map(([key, sign, title]) => (
          <button key={key} type="button" title={title} aria-label={title} onClick={() => void capturing.press(key)}>
            {sign}
          </button>
        ))}
        <output class="digits" aria-label="Number being typed">
          {digits && `node ${digits}_`}
        </output>
      </div>
      <p class="hint">+ and − begin a curve, digits are nodes where the device rests, . finishes it. The keyboard does the same.</p>
    </Section>
  );
}

// ---- after ----------------------------------------------------------------------------------------------------------

function Result({ capturing, news, report }: { capturing: Capturing; news: CaptureNews; report: NonNullable<CaptureNews['report']> }) {
  const { curves, decoded, end } = report.figures;
  return (
    <Section title="What came of it">
      <Figures
        rows={[
          ['ended', end],
          ['curves', short(curves)],
          ['readings', short(decoded?.readings)],
          ['wrong, left out', decoded ? `${short(decoded.refused)}, ${percent(decoded.refused / Math.max(1, decoded.readings + decoded.refused))}` : '–'],
          ['missing', short(decoded?.missing)],
        ]}
      />
      <Sentences title="Warnings" list={report.warnings} />
      <button type="button" class="primary" disabled={curves === 0 || news.doing !== 'nothing'} onClick={() => void capturing.openScan()}>
        Make the scan and its surface
      </button>
    </Section>
  );
}

function Recordings({ capturing, busy }: { capturing: Capturing; busy: boolean }) {
  const [speed, setSpeed] = useState('1');
  const list = capturing.recordings.value;
  if (list.length === 0) return null;
  return (
    <Section title="Recordings">
      <Choice
        label="Replay"
        help="How fast, compared with when it was made."
        value={speed}
        options={[
          ['1', 'as it was'],
          ['4', '4 times'],
          ['16', '16 times'],
          ['0', 'as fast as it goes'],
        ]}
        onChange={setSpeed}
      />
      <ul class="plain recordings">
        {list.map((file) => (
          <li key={file.number}>
            <span>{file.name}</span>
            <button type="button" disabled={busy} aria-label={`Replay ${file.name}`} onClick={() => void capturing.replay(file, Number(speed))}>
              Replay
            </button>
            <button type="button" disabled={busy} aria-label={`Scan of ${file.name}`} onClick={() => void capturing.openScan(file)}>
              Scan
            </button>
          </li>
        ))}
      </ul>
    </Section>
  );
}
