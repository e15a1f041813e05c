import { expect, test } from "vitest";
import { program } from "../src/python";

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
