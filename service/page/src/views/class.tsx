/** View 6: the instructor seals and marks, students measure and answer. */

import { Empty } from "../parts/notes";
import { ask, useSession } from "../session";
import type { State } from "../state";
import { InstructorView } from "./class-instructor";
import { StudentView } from "./class-student";

export function ClassView({ state }: { state: State }) {
  const { holder } = useSession();
  if (holder?.role === "student") return <StudentView key={holder.id} state={state} />;
  if (holder) return <InstructorView key={holder.id} state={state} />;
  return (
    <section class="stage">
      <Empty title="A class needs keys">
        <p>Sign in to see the assignments of your class. On a service without keys there are no classes.</p>
        <button type="button" class="primary" onClick={ask}>Sign in</button>
      </Empty>
    </section>
  );
}
