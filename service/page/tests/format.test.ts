import { expect, test } from "vitest";
import { percent, placeText, short, withError } from "../src/format";

test("a value is rounded to its standard error", () => {
  expect(withError(0.010618734, 0.0000071)).toBe("0.010619(7)");
  expect(withError(23.0644864, 0.0014488)).toBe("23.0645(14)");
  expect(withError(-1.5, 0.2)).toBe("−1.5(2)");
  expect(withError(199.96, 0.0997)).toBe("199.96(10)");
});

test("without an error there are five digits; great errors are written out", () => {
  expect(withError(123.456789, null)).toBe("123.46");
  expect(withError(36292074513.62, 4e7)).toBe("3.629·10¹⁰ ± 4·10⁷");
});

test("numbers are short and have a true minus", () => {
  expect(short(-0.0123456)).toBe("−0.01235");
  expect(short(0)).toBe("0");
  expect(short(null)).toBe("–");
  expect(short(-2.5e-7, 2)).toBe("−2.5·10⁻⁷");
  expect(percent(0.99985)).toBe("> 99.9 %");
});

test("places are told in words", () => {
  expect(placeText(null)).toBe("everywhere");
  expect(placeText({ channels: ["1:+Y", "2:+Y", "3:+Y", "4:+Y", "5:+Y"] })).toBe("5 channels, 1:+Y to 5:+Y");
  expect(placeText({ members: [3, 4] })).toBe("members 3, 4");
  expect(placeText({ channels: ["5:+Y"] })).toBe("channel 5:+Y");
});
