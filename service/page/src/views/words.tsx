/** The words of a class: the instructor reads them, and gives points with a comment. */

import { useState } from "preact/hooks";
import { short } from "../format";
import { type Assignment, type Mark, type StudentMarks, gradeWords } from "../class";
import { NumberField, TextField } from "../parts/fields";
import { ProblemNote } from "../parts/notes";
import { useActions } from "../use";

/** All answers that have words to mark; nothing where the rubric gives no points for them. */
export function WordsOf({ assignment, rows, marked }: { assignment: Assignment; rows: StudentMarks[]; marked(): void }) {
  const worded = rows.flatMap((row) => {
    const mark = row.submission?.marks.marks.find(({ criterion }) => criterion === "words");
    return mark ? [{ row, mark }] : [];
  });
  if (!worded.length) return null;
  const open = worded.filter(({ mark }) => mark.points === null).length;
  return (
    <section class="worded" aria-labelledby="words-title">
      <h3 id="words-title">Words</h3>
      <p class="hint">{open ? `${open} of ${worded.length} without points.` : "All have points."}</p>
      {worded.map(({ row, mark }) => <Worded key={`${row.student}/${row.submission!.number}`} assignment={assignment} row={row} mark={mark} marked={marked} />)}
    </section>
  );
}

function Worded({ assignment, row, mark, marked }: { assignment: Assignment; row: StudentMarks; mark: Mark; marked(): void }) {
  const given = mark.points !== null;
  const [points, setPoints] = useState(mark.points ?? (row.submission!.words ? mark.maximum : 0));
  const [comment, setComment] = useState(given ? (mark.reasons[0] ?? "") : "");
  const { run, busy, problem } = useActions(undefined, marked);
  const send = (event: Event) => {
    event.preventDefault();
    run(() => gradeWords(assignment.id, row.student, points, comment.trim()));
  };
  return (
    <details open={!given}>
      <summary>{row.name}: {given ? `${short(mark.points, 3)} of ${short(mark.maximum, 3)}` : "open"}</summary>
      <form onSubmit={send} aria-label={`Words of ${row.name}`}>
        <blockquote>{row.submission!.words || "No words."}</blockquote>
        <NumberField label={`Points, of ${short(mark.maximum, 3)}`} value={points} set={setPoints} min={0} max={mark.maximum} />
        <TextField label="Comment" value={comment} set={setComment} />
        <button type="submit" disabled={busy}>{given ? "Change the points" : "Give the points"}</button>
        {problem && <ProblemNote problem={problem} />}
      </form>
    </details>
  );
}
