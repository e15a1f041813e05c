/** Marks of an answer with their reasons, and the table of a class. */

import { short, timeText, words } from "../format";
import { file } from "../api";
import { type Assignment, type StudentMarks, type Submission } from "../class";
import { Actions } from "../parts/actions";
import { marksLines, program } from "../python";

export function MarksOf({ submission }: { submission: Submission }) {
  const { marks, points, maximum } = submission.marks;
  return (
    <section class="marks" aria-labelledby="marks-title">
      <h2 id="marks-title">{`Marks: ${short(points, 3)} of ${short(maximum, 3)} points`}</h2>
      <p class="hint">For answer {submission.number}, {timeText(submission.created)}.</p>
      <dl>
        {marks.map((mark) => (
          <div>
            <dt>{`${words(mark.criterion)}: ${mark.points === null ? "open" : short(mark.points, 3)} of ${short(mark.maximum, 3)}`}</dt>
            {mark.reasons.map((reason) => <dd>{reason}</dd>)}
          </div>
        ))}
      </dl>
    </section>
  );
}

export function MarksTable({ assignment, rows }: { assignment: Assignment; rows: StudentMarks[] }) {
  const criteria = (["kind", "place", "size", "coefficients", "words"] as const).filter((name) => rows.some((row) => pointsOf(row, name) !== undefined));
  const submitted = rows.filter((row) => row.submission).length;
  return (
    <>
      <p class="facts" role="status">{`${rows.filter((row) => row.measurements).length} of ${rows.length} have measured, ${submitted} ${submitted === 1 ? "has" : "have"} submitted.`}</p>
      <div class="scroll" tabIndex={0} role="region" aria-label="Table of marks">
        <table>
          <caption>Of the last answer of each student</caption>
          <thead>
            <tr>
              <th scope="col" class="text">Student</th>
              <th scope="col">Tests</th>
              <th scope="col">Submitted</th>
              {criteria.map((name) => <th scope="col">{words(name)}</th>)}
              <th scope="col">Points</th>
            </tr>
          </thead>
          <tbody>
            {rows.map((row) => (
              <tr>
                <td class="text">{row.name}</td>
                <td>{row.measurements} of {assignment.quota}</td>
                <td>{row.submission ? timeText(row.submission.created) : "–"}</td>
                {criteria.map((name) => <td>{pointsText(pointsOf(row, name))}</td>)}
                <td>{row.submission ? `${short(row.submission.marks.points, 3)} of ${short(row.submission.marks.maximum, 3)}` : "–"}</td>
              </tr>
            ))}
          </tbody>
        </table>
      </div>
      <Actions downloads={[{ text: "Marks, CSV", name: "marks.csv", from: () => file(`/assignments/${assignment.id}/marks`, "text/csv") }]} python={() => program(marksLines(assignment.id))} />
    </>
  );
}

/** Return the points of a criterion: null where the instructor gives them, undefined where it is not judged. */
function pointsOf(row: StudentMarks, criterion: string): number | null | undefined {
  return row.submission?.marks.marks.find((mark) => mark.criterion === criterion)?.points;
}

const pointsText = (points: number | null | undefined) => (points === undefined ? "–" : points === null ? "open" : short(points, 3));
