/** The keys and what the mouse does. */
import { useEffect, useRef } from 'preact/hooks';
import type { App } from '../app';
import { registerAll } from './all-commands';
import { available, commands } from './commands';

export function Help({ app }: { app: App }) {
  registerAll(app);
  const dialog = useRef<HTMLDialogElement>(null);
  useEffect(() => dialog.current?.showModal(), []);
  return (
    <dialog ref={dialog} class="help-dialog" onClose={() => (app.help.value = false)} aria-label="Keys and mouse">
      <h2>Keys and mouse</h2>
      <p>Drag to turn about what is under the cursor; right button or shift to move; wheel to zoom to the cursor. One finger turns, two move and pinch.</p>
      <table>
        <tbody>
          {commands()
            .filter((command) => command.keys)
            .map((command) => (
              <tr key={command.id} class={available(command) ? '' : 'off'}>
                <th scope="row">
                  <kbd>{command.keys}</kbd>
                </th>
                <td>{command.title}</td>
              </tr>
            ))}
        </tbody>
      </table>
      <button type="button" onClick={() => dialog.current?.close()}>
        Close
      </button>
    </dialog>
  );
}
