/** A WebAssembly module that gets little memory. */

/** The module with a memory that grows to so many bytes and no further. */
export function limited(module: Buffer, bytes: number): Buffer<ArrayBuffer> {
  const pages = Math.ceil(bytes / 65536);
  // Magic and version, then sections: number, length, content.
  for (let at = 8; at < module.length;) {
    const [id, start] = [module[at]!, at + 1];
    const [length, body] = number(module, start);
    if (id === 5) {
      // One memory: flags, least and maybe most pages.
      const [count, flags] = number(module, body);
      const [least] = number(module, flags + 1);
      if (count !== 1 || least > pages) throw new Error(`${count} memories, of ${least} pages at least`);
      const content = Buffer.from([1, 1, ...encoded(least), ...encoded(pages)]);
      return Buffer.concat([module.subarray(0, start), Buffer.from(encoded(content.length)), content, module.subarray(body + length)]);
    }
    at = body + length;
  }
  throw new Error("the module has no memory");
}

/** LEB128, and where it ends. */
function number(bytes: Buffer, at: number): [value: number, end: number] {
  let value = 0;
  for (let shift = 0; ; shift += 7) {
    const byte = bytes[at++]!;
    value += (byte & 127) * 2 ** shift;
    if (byte < 128) return [value, at];
  }
}

function encoded(value: number): number[] {
  return value < 128 ? [value] : [(value & 127) | 128, ...encoded(Math.floor(value / 128))];
}
