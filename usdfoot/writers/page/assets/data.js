"use strict";
/** Everything of the page hangs here, one entry a file. */
const page = {};

/** The data block: writers/page/block.py put it together. */
page.data = (() => {
  const TYPES = {
    float32: Float32Array,
    int16: Int16Array,
    int32: Int32Array,
    uint8: Uint8Array,
    uint16: Uint16Array,
    uint32: Uint32Array,
  };

  /** Header and arrays by name. */
  async function load() {
    const header = JSON.parse(document.getElementById("header").textContent);
    const block = document.getElementById("block");
    const bytes = await inflated(fromBase64(block.textContent));
    block.remove();
    const arrays = {};
    let offset = 0;
    for (const { name, type, count } of header.arrays) {
      const size = count * TYPES[type].BYTES_PER_ELEMENT;
      arrays[name] = joined(bytes.subarray(offset, offset + size), TYPES[type], count);
      offset += size;
    }
    return { header, arrays };
  }

  function fromBase64(text) {
    const characters = atob(text);
    const bytes = new Uint8Array(characters.length);
    for (let i = 0; i < bytes.length; i++) bytes[i] = characters.charCodeAt(i);
    return bytes;
  }

  async function inflated(bytes) {
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }

  /** Numbers from their bytes, which stand by significance; whole numbers are differences that wrap around. */
  function joined(bytes, Kind, count) {
    const size = Kind.BYTES_PER_ELEMENT;
    const together = new Uint8Array(bytes.length);
    for (let place = 0; place < size; place++) {
      const start = place * count;
      for (let i = 0; i < count; i++) together[i * size + place] = bytes[start + i];
    }
    const values = new Kind(together.buffer);
    if (Kind !== Float32Array) for (let i = 1; i < count; i++) values[i] += values[i - 1];
    return values;
  }

  return { load };
})();
