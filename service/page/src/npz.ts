/** NumPy archives: an uncompressed zip of npy files. */

export interface NumpyArray {
  shape: number[];
  /** Numbers in C order; complex as pairs of real and imaginary part. */
  values: Float64Array | Float32Array | Int32Array | Uint8Array | string[];
  complex: boolean;
}

export type Arrays = Record<string, NumpyArray>;

const CENTRAL = 0x02014b50;
const END = 0x06054b50;

export function readNpz(buffer: ArrayBuffer): Arrays {
  const view = new DataView(buffer);
  const text = new TextDecoder();
  let at = endRecord(view);
  const count = view.getUint16(at + 10, true);
  at = view.getUint32(at + 16, true);
  const arrays: Arrays = {};
  for (let i = 0; i < count; i++) {
    if (view.getUint32(at, true) !== CENTRAL) throw new Error("this is no zip file");
    const [nameLength, extra, comment] = [28, 30, 32].map((offset) => view.getUint16(at + offset, true));
    const name = text.decode(new Uint8Array(buffer, at + 46, nameLength));
    const local = view.getUint32(at + 42, true);
    const start = local + 30 + view.getUint16(local + 26, true) + view.getUint16(local + 28, true);
    if (view.getUint16(at + 10, true) !== 0) throw new Error(`${name} is compressed`);
    arrays[name.replace(/\.npy$/, "")] = readNpy(buffer, start);
    at += 46 + nameLength + extra + comment;
  }
  return arrays;
}

function endRecord(view: DataView): number {
  for (let at = view.byteLength - 22; at >= 0; at--) {
    if (view.getUint32(at, true) === END) return at;
  }
  throw new Error("this is no zip file");
}

function readNpy(buffer: ArrayBuffer, start: number): NumpyArray {
  const view = new DataView(buffer, start);
  const wide = view.getUint8(6) > 1;
  const length = wide ? view.getUint32(8, true) : view.getUint16(8, true);
  const begin = (wide ? 12 : 10) + length;
  const header = new TextDecoder("latin1").decode(new Uint8Array(buffer, start + begin - length, length));
  const kind = /'descr':\s*'([^']+)'/.exec(header)![1];
  const fortran = /'fortran_order':\s*True/.test(header);
  const inside = /'shape':\s*\(([^)]*)\)/.exec(header)![1];
  const shape = inside.split(",").filter((part) => part.trim()).map(Number);
  const size = shape.reduce((product, n) => product * n, 1);
  const array = { shape, values: valuesOf(buffer, start + begin, kind, size), complex: kind.includes("c") };
  return fortran && shape.length > 1 ? inCOrder(array) : array;
}

function valuesOf(buffer: ArrayBuffer, at: number, kind: string, size: number): NumpyArray["values"] {
  const bytes = Number(kind.slice(2));
  // Copies: an entry of a zip need not be aligned.
  const cut = (n: number) => buffer.slice(at, at + n);
  switch (kind.slice(0, 2)) {
    case "<f":
      return bytes === 4 ? new Float32Array(cut(4 * size)) : new Float64Array(cut(8 * size));
    case "<c":
      return bytes === 8 ? new Float32Array(cut(8 * size)) : new Float64Array(cut(16 * size));
    case "<i":
      return bytes === 8
        ? Float64Array.from(new BigInt64Array(cut(8 * size)), Number)
        : new Int32Array(cut(4 * size));
    case "|b":
      return new Uint8Array(cut(size));
    case "<U": {
      const codes = new Uint32Array(cut(4 * (bytes || 0) * size));
      const width = bytes || 0;
      return Array.from({ length: size }, (_, i) =>
        String.fromCodePoint(...codes.subarray(i * width, (i + 1) * width)).replace(/\0+$/, ""),
      );
    }
    default:
      throw new Error(`arrays of ${kind} are not read here`);
  }
}

function inCOrder(array: NumpyArray): NumpyArray {
  const { shape } = array;
  const width = array.complex ? 2 : 1;
  const source = array.values as Float64Array;
  const values = source.slice();
  const size = source.length / width;
  for (let c = 0; c < size; c++) {
    let rest = c;
    let f = 0;
    for (let axis = shape.length - 1; axis >= 0; axis--) {
      const index = rest % shape[axis];
      rest = (rest - index) / shape[axis];
      f += index * shape.slice(0, axis).reduce((product, n) => product * n, 1);
    }
    for (let k = 0; k < width; k++) values[c * width + k] = source[f * width + k];
  }
  return { ...array, values };
}
