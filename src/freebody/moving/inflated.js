// Arrays of numbers as Python packed them: deflated, the bytes of equal weight together.
async function inflated(packed) {
  const bytes = Uint8Array.from(atob(packed), (c) => c.charCodeAt(0));
  return new Uint8Array(await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer());
}
async function numbers(packed, Kind) {
  const bytes = await inflated(packed), size = Kind.BYTES_PER_ELEMENT, count = bytes.length / size, sorted = new Uint8Array(bytes.length);
  for (let k = 0; k < count; k++) for (let b = 0; b < size; b++) sorted[k * size + b] = bytes[b * count + k];
  return new Kind(sorted.buffer);
}
