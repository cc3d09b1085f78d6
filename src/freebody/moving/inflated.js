// Arrays of numbers as Python packed them: deflated, the bytes of equal weight together, of bits from
// which the one `stride` before was taken, twice.
async function inflated(packed) {
  const bytes = Uint8Array.from(atob(packed), (c) => c.charCodeAt(0));
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer());
}
async function numbers(packed, Kind, stride = 1) {
  const bytes = await inflated(packed), size = Kind.BYTES_PER_ELEMENT, count = bytes.length / size, sorted = new Uint8Array(bytes.length);
  for (let k = 0; k < count; k++) for (let b = 0; b < size; b++) sorted[k * size + b] = bytes[b * count + k];
  const bits = new (size === 8 ? BigUint64Array : Uint32Array)(sorted.buffer);
  for (let round = 0; round < 2; round++) for (let k = stride; k < count; k++) bits[k] += bits[k - stride];
  return new Kind(sorted.buffer);
}
