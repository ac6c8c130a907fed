/** Arrays of a page: base64 of a zlib stream, inflated once; views into it by the places that the description gives. */
export class Arrays {
  /** @param {ArrayBuffer} buffer */
  constructor(buffer) {
    this.buffer = buffer;
  }

  /** @param {string} text base64 */
  static async inflate(text) {
    const packed = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Arrays(await new Response(stream).arrayBuffer());
  }

  /** A view of an array. @param {{offset: number, length: number, type: string}} place */
  view(place) {
    const kinds = { f32: Float32Array, u32: Uint32Array, i16: Int16Array };
    return new kinds[place.type](this.buffer, place.offset, place.length);
  }
}
