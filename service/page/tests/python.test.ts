import { expect, test } from "vitest";
import { answerLines, assignmentLines, marksLines, program, trialLines } from "../src/python";

const LAB = "http://lab.example:8000";

test("copied code without keys is a connection around its lines", () => {
  expect(program(["print(lab)"], LAB, false)).toBe(
    `from modallab_client import ModalLab\n\nwith ModalLab("${LAB}") as lab:\n    print(lab)\n`,
  );
});

test("copied code of somebody signed in names the environment variable of the key", () => {
  const lines = program(["print(lab)"], LAB, true).split("\n");
  expect(lines[2]).toBe("# Your key is read from the environment variable MODALLAB_KEY.");
  expect(lines.slice(3).join("\n")).toBe(`with ModalLab("${LAB}") as lab:\n    print(lab)\n`);
});

test("an assignment is the call that makes it, without what is left as it is", () => {
  const body = { class_id: "c", title: "Find it", structure: "s", hidden: [{ kind: "extra_mass", at: { one_of: ["3:+Y"] } }], deadline: null };
  expect(assignmentLines(body)).toEqual([
    "assignment = lab.assignments.create(",
    '    "c",',
    '    "Find it",',
    '    structure="s",',
    '    hidden=[{"kind": "extra_mass", "at": {"one_of": ["3:+Y"]}}],',
    ")",
    "print(assignment.id)",
  ]);
});

test("a test, an answer and marks of an assignment are calls of the client", () => {
  expect(trialLines("a", { rig: { analyser: { averages: 20 } } })[0]).toMatch(/measure\("a", \{"analyser": \{"averages": 20\}\}\)\.result\(\)/);
  expect(trialLines("a", { rig: {}, route: "expected" })[0]).toContain('measure("a", {}, route="expected")');
  expect(answerLines("a", { effects: [], coefficients: {}, words: 'so "seen"' })[0]).toBe('answer = lab.assignments.submit("a", [], coefficients={}, words="so \\"seen\\"")');
  expect(marksLines("a")[0]).toBe('for row in lab.assignments.marks("a"):');
});
