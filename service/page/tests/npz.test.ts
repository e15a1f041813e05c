import { expect, test } from "vitest";
import { column } from "../src/frf";
import { readNpz } from "../src/npz";

// numpy.savez of: freq [0, 2]; values [[1+2j, 3-4j], [5j, 6]] in Fortran order; outputs; averages 30; held_out; n.
const ARCHIVE =
  "UEsDBC0AAAAAAAAAIQD+2G5e//////////8IABQAZnJlcS5ucHkBABAAkAAAAAAAAACQAAAAAAAAAJNOVU1QWQEAdgB7J2Rlc2NyJzogJzxmOCcsICdmb3J0cmFuX29yZGVyJzogRmFsc2UsICdzaGFwZSc6ICgyLCksIH0gICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAKAAAAAAAAAAAAAAAAAAAAQFBLAwQtAAAAAAAAACEAyBBSS///////////CgAUAHZhbHVlcy5ucHkBABAAwAAAAAAAAADAAAAAAAAAAJNOVU1QWQEAdgB7J2Rlc2NyJzogJzxjMTYnLCAnZm9ydHJhbl9vcmRlcic6IFRydWUsICdzaGFwZSc6ICgyLCAyKSwgfSAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAKAAAAAAAA8D8AAAAAAAAAQAAAAAAAAAAAAAAAAAAAFEAAAAAAAAAIQAAAAAAAABDAAAAAAAAAGEAAAAAAAAAAAFBLAwQtAAAAAAAAACEA2J2Fmv//////////CwAUAG91dHB1dHMubnB5AQAQAKgAAAAAAAAAqAAAAAAAAACTTlVNUFkBAHYAeydkZXNjcic6ICc8VTUnLCAnZm9ydHJhbl9vcmRlcic6IEZhbHNlLCAnc2hhcGUnOiAoMiwpLCB9ICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgCjEAAAA6AAAAKwAAAFkAAAAAAAAAMQAAADEAAAA6AAAAKwAAAFkAAABQSwMELQAAAAAAAAAhACOSBA///////////wwAFABhdmVyYWdlcy5ucHkBABAAiAAAAAAAAACIAAAAAAAAAJNOVU1QWQEAdgB7J2Rlc2NyJzogJzxpOCcsICdmb3J0cmFuX29yZGVyJzogRmFsc2UsICdzaGFwZSc6ICgpLCB9ICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAKHgAAAAAAAABQSwMELQAAAAAAAAAhADkYpzP//////////wwAFABoZWxkX291dC5ucHkBABAAggAAAAAAAACCAAAAAAAAAJNOVU1QWQEAdgB7J2Rlc2NyJzogJ3xiMScsICdmb3J0cmFuX29yZGVyJzogRmFsc2UsICdzaGFwZSc6ICgyLCksIH0gICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAKAAFQSwMELQAAAAAAAAAhAOjQ06j//////////wUAFABuLm5weQEAEACQAAAAAAAAAJAAAAAAAAAAk05VTVBZAQB2AHsnZGVzY3InOiAnPGk4JywgJ2ZvcnRyYW5fb3JkZXInOiBGYWxzZSwgJ3NoYXBlJzogKDIsKSwgfSAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgICAgIAoDAAAAAAAAAAQAAAAAAAAAUEsBAi0DLQAAAAAAAAAhAP7Ybl6QAAAAkAAAAAgAAAAAAAAAAAAAAIABAAAAAGZyZXEubnB5UEsBAi0DLQAAAAAAAAAhAMgQUkvAAAAAwAAAAAoAAAAAAAAAAAAAAIABygAAAHZhbHVlcy5ucHlQSwECLQMtAAAAAAAAACEA2J2FmqgAAACoAAAACwAAAAAAAAAAAAAAgAHGAQAAb3V0cHV0cy5ucHlQSwECLQMtAAAAAAAAACEAI5IED4gAAACIAAAADAAAAAAAAAAAAAAAgAGrAgAAYXZlcmFnZXMubnB5UEsBAi0DLQAAAAAAAAAhADkYpzOCAAAAggAAAAwAAAAAAAAAAAAAAIABcQMAAGhlbGRfb3V0Lm5weVBLAQItAy0AAAAAAAAAIQDo0NOokAAAAJAAAAAFAAAAAAAAAAAAAACAATEEAABuLm5weVBLBQYAAAAABgAGAE4BAAD4BAAAAAA=";

const buffer = Uint8Array.from(atob(ARCHIVE), (c) => c.charCodeAt(0)).buffer;

test("an archive of numpy is read: numbers, complex numbers in Fortran order, text, truth values", () => {
  const arrays = readNpz(buffer);
  expect([...(arrays.freq.values as Float64Array)]).toEqual([0, 2]);
  expect(arrays.values.shape).toEqual([2, 2]);
  expect([...(arrays.values.values as Float64Array)]).toEqual([1, 2, 3, -4, 0, 5, 6, 0]);
  expect(arrays.outputs.values).toEqual(["1:+Y", "11:+Y"]);
  expect(arrays.averages.shape).toEqual([]);
  expect(arrays.averages.values[0]).toBe(30);
  expect([...(arrays.held_out.values as Uint8Array)]).toEqual([0, 1]);
  expect([...(arrays.n.values as Float64Array)]).toEqual([3, 4]);
});

test("a column of a complex array is its real and its imaginary part", () => {
  const [real, imaginary] = column(readNpz(buffer), "values", 1);
  expect([...real]).toEqual([3, 6]);
  expect([...imaginary]).toEqual([-4, 0]);
});

test("what is no archive is refused", () => {
  expect(() => readNpz(new ArrayBuffer(40))).toThrow("no zip file");
});
