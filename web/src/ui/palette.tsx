/** Every command, found by its words. */
import { useEffect, useRef, useState } from 'preact/hooks';
import type { App } from '../app';
import { registerAll } from './all-commands';
import { available, search } from './commands';

export function Palette({ app }: { app: App }) {
  registerAll(app);
  const dialog = useRef<HTMLDialogElement>(null);
  const [text, setText] = useState('');
  const [at, setAt] = useState(0);
  useEffect(() => dialog.current?.showModal(), []);
  const found = search(text).slice(0, 12);
  const run = (index: number) => {
    const command = found[index];
    if (!command || !available(command)) return;
    dialog.current?.close();
    void command.run();
  };
  return (
    <dialog ref={dialog} class="palette" aria-label="Find a command" onClose={() => (app.palette.value = false)}>
      <input
        type="text"
        role="combobox"
        aria-expanded="true"
        aria-controls="palette-list"
        aria-activedescendant={found[at] ? `palette-${found[at].id}` : undefined}
        aria-label="Words of a command"
        placeholder="What do you want to do?"
        value={text}
        onInput={(event) => {
          setText(event.currentTarget.value);
          setAt(0);
        }}
        onKeyDown={(event) => {
          if (event.key === 'ArrowDown') setAt(Math.min(at + 1, found.length - 1));
          else if (event.key === 'ArrowUp') setAt(Math.max(at - 1, 0));
          else if (event.key === 'Enter') run(at);
          else return;
          event.preventDefault();
        }}
      />
      <ul id="palette-list" role="listbox" aria-label="Commands">
        {found.map((command, i) => (
          <li
            key={command.id}
            id={`palette-${command.id}`}
            role="option"
            aria-selected={i === at}
            aria-disabled={!available(command)}
            onClick={() => run(i)}
          >
            {command.title} {command.keys && <kbd>{command.keys}</kbd>}
          </li>
        ))}
      </ul>
    </dialog>
  );
}
