/** Controls of a front panel. */

import type { ComponentChildren } from "preact";
import { useId, useState } from "preact/hooks";
import { words } from "../format";

export function Group({ title, children }: { title: string; children: ComponentChildren }) {
  return (
    <fieldset class="group">
      <legend>{title}</legend>
      <div class="group-fields">{children}</div>
    </fieldset>
  );
}

interface NumberProps {
  label: string;
  unit?: string;
  value: number;
  set(value: number): void;
  min?: number;
  max?: number;
  whole?: boolean;
}

export function NumberField({ label, unit, value, set, min = -Infinity, max = Infinity, whole }: NumberProps) {
  const id = useId();
  // What has been typed stays as long as it means the value: `0.` on the way to 0.04 is 0.
  const [typed, setTyped] = useState({ text: String(value), value });
  const text = typed.value === value ? typed.text : String(value);
  const number = Number(text.replace(",", "."));
  const wrong = text.trim() === "" || !Number.isFinite(number) || number < min || number > max || (whole && !Number.isInteger(number));
  const read = (event: Event) => {
    const entered = (event.currentTarget as HTMLInputElement).value;
    const parsed = Number(entered.replace(",", "."));
    const right = entered.trim() !== "" && Number.isFinite(parsed) && parsed >= min && parsed <= max && (!whole || Number.isInteger(parsed));
    setTyped({ text: entered, value: right ? parsed : value });
    if (right) set(parsed);
  };
  return (
    <div class="field">
      <label for={id}>{label}</label>
      <span class="input">
        <input
          id={id}
          inputMode="decimal"
          autocomplete="off"
          value={text}
          aria-invalid={wrong || undefined}
          aria-describedby={wrong ? `${id}-wrong` : undefined}
          onInput={read}
        />
        {unit && <span class="unit">{unit}</span>}
      </span>
      {wrong && <span class="wrong" id={`${id}-wrong`}>{allowed(min, max, whole)}</span>}
    </div>
  );
}

function allowed(min: number, max: number, whole?: boolean): string {
  const kind = whole ? "a whole number" : "a number";
  if (Number.isFinite(min) && Number.isFinite(max)) return `${kind} from ${min} to ${max}`;
  return Number.isFinite(min) ? `${kind} from ${min}` : kind;
}

interface TextProps {
  label: string;
  value: string;
  set(value: string): void;
}

export function TextField({ label, value, set, kind = "text" }: TextProps & { kind?: "text" | "datetime-local" }) {
  const id = useId();
  return (
    <div class="field text-field">
      <label for={id}>{label}</label>
      <span class="input"><input id={id} type={kind} autocomplete="off" value={value} onInput={(event) => set(event.currentTarget.value)} /></span>
    </div>
  );
}

export function TextArea({ label, value, set, rows }: TextProps & { rows: number }) {
  const id = useId();
  return (
    <div class="area-field">
      <label for={id}>{label}</label>
      <textarea id={id} rows={rows} value={value} onInput={(event) => set(event.currentTarget.value)} />
    </div>
  );
}

export function CheckField({ label, checked, flip }: { label: string; checked: boolean; flip(): void }) {
  return (
    <label class="switch">
      <input type="checkbox" role="switch" checked={checked} onChange={flip} />
      <span>{label}</span>
    </label>
  );
}

interface SelectProps {
  label: string;
  value: string;
  set(value: string): void;
  options: { value: string; text?: string; hint?: string }[];
}

export function SelectField({ label, value, set, options }: SelectProps) {
  const id = useId();
  const hint = options.find((option) => option.value === value)?.hint;
  return (
    <div class="field">
      <label for={id}>{label}</label>
      <span class="input">
        <select id={id} value={value} title={hint} onChange={(event) => set(event.currentTarget.value)}>
          {options.map((option) => (
            <option value={option.value}>{option.text ?? words(option.value)}</option>
          ))}
        </select>
      </span>
    </div>
  );
}

/** A list, and the button that adds what it shows: by the keyboard one passes many entries on the way to one. */
export function AddField({ label, options, add }: Pick<SelectProps, "label" | "options"> & { add(value: string): void }) {
  const [value, setValue] = useState("");
  return (
    <>
      <SelectField label={label} value={value} set={setValue} options={[{ value: "", text: "–" }, ...options]} />
      <button type="button" class="wide" disabled={!value} onClick={() => { add(value); setValue(""); }}>Add the effect</button>
    </>
  );
}

interface ChoiceProps<T extends string> {
  label: string;
  value: T;
  set(value: T): void;
  options: { value: T; text: string }[];
}

/** One of a few, all in sight. */
export function Choice<T extends string>({ label, value, set, options }: ChoiceProps<T>) {
  const name = useId();
  return (
    <fieldset class="choice">
      <legend class="visually-hidden">{label}</legend>
      {options.map((option) => (
        <label>
          <input type="radio" name={name} checked={option.value === value} onChange={() => set(option.value)} />
          <span>{option.text}</span>
        </label>
      ))}
    </fieldset>
  );
}

interface StartProps {
  /** The work is under way: another press does nothing, and the button keeps the focus. */
  busy: boolean;
  disabled?: boolean;
  start(): void;
  children: string;
}

/** Start the work of a view. */
export function StartButton({ busy, disabled, start, children }: StartProps) {
  return (
    <button type="button" class="primary wide" disabled={disabled} aria-disabled={busy || undefined} onClick={() => busy || start()}>
      {children}
    </button>
  );
}
