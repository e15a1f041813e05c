/** Links that sign the students of a class in once. */

import { useState } from "preact/hooks";
import { get, post } from "../api";
import type { ClassEntry } from "../class";
import { csv, save } from "../parts/actions";
import { Group } from "../parts/fields";
import { ProblemNote } from "../parts/notes";
import { origin } from "../python";
import { useActions } from "../use";

interface Member {
  id: string;
  name: string;
  revoked: string | null;
}

/** Make a link for each student, and return them as a table. */
async function linksOf(entered: ClassEntry): Promise<{ count: number; table: Blob }> {
  const { members } = await get<{ members: Member[] }>(`/classes/${entered.id}`);
  const students = members.filter((member) => member.revoked === null).reverse(); // as they came
  const link: string[] = [];
  for (const { id } of students) link.push(origin() + (await post<{ link: string }>(`/keys/${id}/links`, undefined)).link);
  return { count: link.length, table: csv({ name: students.map(({ name }) => name), link }) };
}

/** Links are told once: they go into a file and never into the page. */
export function LinksOf({ entered }: { entered: ClassEntry }) {
  const [made, setMade] = useState<{ count: number; table: Blob } | null>(null);
  const { run, busy, problem } = useActions();
  const make = async () => {
    const links = await linksOf(entered);
    setMade(links);
    if (links.count) save(links.table, "links.csv");
  };
  return (
    <Group title="Links">
      <p class="hint">A link signs its student in once, within a week. The keys count as before.</p>
      <button type="button" class="wide" disabled={busy} onClick={() => run(make)}>Make a link for each student</button>
      {made && <p class="hint" role="status">{made.count ? `${made.count} links are in links.csv. They are told once: keep the file.` : "The class has no students yet."}</p>}
      {made && made.count > 0 && <button type="button" class="wide" onClick={() => save(made.table, "links.csv")}>Save links.csv again</button>}
      {problem && <ProblemNote problem={problem} />}
    </Group>
  );
}
