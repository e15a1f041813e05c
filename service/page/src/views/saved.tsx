/** Saved work: what the user has stored, opened again, deleted, restored, or taken along as a file. */

import "../saved.css";
import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import { get } from "../api";
import { timeText, words } from "../format";
import { save } from "../parts/actions";
import { DropZone } from "../parts/dropzone";
import { Choice } from "../parts/fields";
import { Loading, ProblemNote } from "../parts/notes";
import { type DiscardedEntry, type Entry, KINDS, type Kind, addProject, discard, entries, nameOf, projectFile, rename, restore, shown, trash } from "../saved";
import { holder } from "../session";
import { go } from "../state";
import { useActions, usePolled } from "../use";

const ROWS = 25; // of a list at a time

type Tab = Kind | "trash";
const TABS = [...Object.entries(KINDS), ["trash", "Trash"]].map(([value, text]) => ({ value: value as Tab, text }));

export function SavedWork({ close }: { close(): void }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const [tab, setTab] = useState<Tab>("measurement");
  useEffect(() => {
    const open = dialog.current!;
    open.showModal();
    return () => open.close(); // which gives the focus back
  }, []);
  return (
    <dialog ref={dialog} class="saved" aria-labelledby="saved-title" onCancel={close}>
      <div class="saved-head">
        <h2 id="saved-title">Saved work</h2>
        <button type="button" class="quiet" onClick={close}>Close</button>
      </div>
      <div class="saved-body">
        <Choice<Tab> label="Kind" value={tab} set={setTab} options={TABS} />
        {tab === "trash" ? <Trash /> : <Stored key={tab} kind={tab} close={close} />}
        <Project />
      </div>
    </dialog>
  );
}

/** The list of one kind, newest first. */
function Stored({ kind, close }: { kind: Kind; close(): void }) {
  const [limit, setLimit] = useState(ROWS);
  const [told, setTold] = useState("");
  const [renamed, setRenamed] = useState<string | null>(null);
  const list = usePolled(`${kind}/${limit}`, () => entries(kind, holder()?.id, limit));
  const actions = useActions(setTold, list.again);
  const open = async (entry: Entry) => {
    const model = kind === "measurement" ? await modelOf(entry.id) : undefined;
    go({ ...shown(kind, entry), ...(model && { s: model }) });
    close();
  };
  const leave = (id: string) => {
    setRenamed(null);
    document.getElementById(`rename-${id}`)?.focus();
  };
  if (list.problem) return <ProblemNote problem={list.problem} again={list.again} />;
  if (!list.value) return <Loading what="the list" />;
  const { items, next } = list.value;
  return (
    <>
      {items.length === 0 && <p class="hint">Nothing of this kind is stored yet.</p>}
      {items.length > 0 && (
        <ul class="saved-list" aria-label={KINDS[kind]} tabIndex={0}>
          {items.map((entry) => (
            <li key={entry.id}>
              {renamed === entry.id
                ? <NameForm entry={entry} kind={kind} take={(name) => actions.run(() => rename(kind, entry.id, name), "Renamed.").then(() => leave(entry.id))} leave={() => leave(entry.id)} />
                : <What entry={entry} kind={kind} />}
              <button type="button" class="quiet" onClick={() => open(entry)}>Open<Of entry={entry} /></button>
              <button type="button" class="quiet" id={`rename-${entry.id}`} aria-expanded={renamed === entry.id} onClick={() => setRenamed(entry.id)}>Rename<Of entry={entry} /></button>
              <button type="button" class="quiet" disabled={actions.busy} onClick={() => actions.run(() => discard(kind, entry.id), "Moved to the trash: it can be restored for a day.")}>Delete<Of entry={entry} /></button>
            </li>
          ))}
        </ul>
      )}
      {next && <button type="button" class="wide" onClick={() => setLimit(limit + ROWS)}>Show older ones</button>}
      <p class="hint" role="status">{told}</p>
      {actions.problem && <ProblemNote problem={actions.problem} />}
    </>
  );
}

function Trash() {
  const [told, setTold] = useState("");
  const list = usePolled("trash", () => trash(holder()?.id));
  const actions = useActions(setTold, list.again);
  if (list.problem) return <ProblemNote problem={list.problem} again={list.again} />;
  if (!list.value) return <Loading what="the trash" />;
  const { items } = list.value;
  return (
    <>
      {items.length === 0 && <p class="hint">The trash is empty.</p>}
      {items.length > 0 && (
        <ul class="saved-list" aria-label="Trash" tabIndex={0}>
          {items.map((entry) => (
            <li>
              <What entry={entry} kind={entry.kind} />
              <span class="when">until {timeText(entry.until)}</span>
              <button type="button" class="quiet" disabled={actions.busy} onClick={() => actions.run(() => restore(entry.id), "Restored.")}>Restore<Of entry={entry} /></button>
            </li>
          ))}
        </ul>
      )}
      <p class="hint" role="status">{told}</p>
      {actions.problem && <ProblemNote problem={actions.problem} />}
    </>
  );
}

/** All stored objects as one file, and back. */
function Project() {
  const [told, setTold] = useState("");
  const actions = useActions(setTold);
  const add = (files: File[]) =>
    actions.run(async () => countsText(await Promise.all(files.map(addProject))));
  return (
    <section aria-labelledby="project-title">
      <h3 id="project-title">Project file</h3>
      <div class="project">
        <button type="button" disabled={actions.busy} onClick={() => actions.run(async () => save(await projectFile(), "project.zip"), "Saved as project.zip.")}>Save all as a file</button>
        <DropZone label="Add a project file" hint="project.zip of this or another laboratory" accept=".zip" take={add} busy={actions.busy} />
      </div>
      <p class="hint" role="status">{told}</p>
      {actions.problem && <ProblemNote problem={actions.problem} />}
    </section>
  );
}

function What({ entry, kind }: { entry: Entry | DiscardedEntry; kind: string }) {
  return (
    <span class="what">
      {nameOf(entry, kind)} <span class="when">{timeText(entry.created)}</span>
      {entry.comment && <span class="hint"> {entry.comment}</span>}
    </span>
  );
}

/** The name of an entry in a field: Enter takes it, Escape leaves it as it was. */
function NameForm({ entry, kind, take, leave }: { entry: Entry; kind: Kind; take(name: string): void; leave(): void }) {
  const field = useRef<HTMLInputElement>(null);
  useLayoutEffect(() => field.current!.select(), []); // before a key can be pressed
  const send = (event: Event) => {
    event.preventDefault();
    take(field.current!.value.trim());
  };
  const escape = (event: KeyboardEvent) => {
    if (event.key !== "Escape") return;
    event.preventDefault(); // the dialog stays open
    leave();
  };
  return (
    <form class="what" onSubmit={send}>
      <span class="input">
        <input ref={field} aria-label="Name" defaultValue={entry.name} placeholder={nameOf(entry, kind)} maxLength={100} onKeyDown={escape} />
        <button type="submit" class="quiet">Save</button>
      </span>
    </form>
  );
}

/** Tells a screen reader which one of a list a button is for. */
function Of({ entry }: { entry: Entry }) {
  return <span class="visually-hidden"> {entry.name || entry.id}, {timeText(entry.created)}</span>;
}

/** Return the structure that was tested, where the user may know it: of an assignment it is sealed. */
async function modelOf(test: string): Promise<string | undefined> {
  const { route } = await get<{ route: string | null }>(`/measurements/${test}`);
  if (route === null) return undefined; // a file tells none
  return get<{ structure_id: string }>(`/measurements/${test}/truth`).then((truth) => truth.structure_id, () => undefined);
}

function countsText(counts: Record<string, number>[]): string {
  const sums: Record<string, number> = {};
  for (const each of counts) for (const [kind, n] of Object.entries(each)) sums[kind] = (sums[kind] ?? 0) + n;
  const parts = Object.entries(sums).filter(([, n]) => n > 0).map(([kind, n]) => `${words(kind)}: ${n}`);
  return parts.length ? `Added: ${parts.join(", ")}.` : "The file holds nothing.";
}
