/** View 6: the instructor seals and marks, students measure and answer. */

import { catalogue } from "../model";
import { Empty } from "../parts/notes";
import { useSession } from "../session";
import type { State } from "../state";
import { useLoaded } from "../use";
import { InstructorView } from "./class-instructor";
import { StudentView } from "./class-student";

export function ClassView({ state }: { state: State }) {
  const { holder } = useSession();
  if (holder?.role === "student") return <StudentView key={holder.id} state={state} />;
  if (holder) return <InstructorView key={holder.id} state={state} />;
  return <Nobody />;
}

function Nobody() {
  useLoaded("catalogue/structures", () => catalogue("structures")); // a service with keys asks for one then
  return (
    <section class="stage">
      <Empty title="A class needs keys">
        <p>Who signs in with a key sees the assignments of the class. On a service without keys there are no classes.</p>
      </Empty>
    </section>
  );
}
