// Pictures: from the bytes of the page to numbers, and from numbers to colours.

/** Undoes base64 and zlib. */
async function bytesOf(id) {
  const holder = document.getElementById(id);
  const text = atob(holder.textContent);
  holder.remove();
  const packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) packed[i] = text.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** What the 65536 half floats are. */
const HALF = (() => {
  const table = new Float32Array(65536);
  for (let bits = 0; bits < 65536; bits++) {
    const exponent = (bits >> 10) & 31;
    const fraction = bits & 1023;
    let value = exponent === 31 ? (fraction ? NaN : Infinity)
      : exponent === 0 ? fraction * 2 ** -24 : (1 + fraction / 1024) * 2 ** (exponent - 15);
    table[bits] = bits & 0x8000 ? -value : value;
  }
  return table;
})();

/** Planes of 16 bits, each channel less the one before, become red, green and blue of each pixel. */
function radianceOf(bytes, pixels, scale) {
  const rgb = new Float32Array(3 * pixels);
  for (let i = 0; i < pixels; i++) {
    let bits = 0;
    for (let c = 0; c < 3; c++) {
      const at = 2 * c * pixels + i;
      bits = (bits + (bytes[at] << 8) + bytes[at + pixels]) & 0xffff;
      rgb[3 * i + c] = HALF[bits] * scale;
    }
  }
  return rgb;
}

async function loadPictures() {
  return Promise.all(data.pictures.map(async (about, i) => {
    const pixels = about.width * about.height;
    const rgb = radianceOf(await bytesOf(`picture-${i}`), pixels, about.scale);
    const flip = about.flip ? await bytesOf(`flip-${i}`) : null;
    return { ...about, rgb, flip, index: i };
  }));
}

const luminance = (r, g, b) => 0.2126 * r + 0.7152 * g + 0.0722 * b;

/** Squared error over squared reference, the mean of three channels, as relMSE has it. */
function relativeSquare(rgb, ref, i) {
  let sum = 0;
  for (let c = 3 * i; c < 3 * i + 3; c++) {
    const error = rgb[c] - ref[c];
    sum += (error * error) / (ref[c] * ref[c] + data.rel_mse_epsilon);
  }
  return sum / 3;
}

/** Difference of luminance over that of the reference, kept from dividing by 0 as relMSE is. */
function relativeError(rgb, ref, i) {
  const at = 3 * i;
  const y = luminance(rgb[at], rgb[at + 1], rgb[at + 2]);
  const expected = luminance(ref[at], ref[at + 1], ref[at + 2]);
  return (y - expected) / Math.sqrt(expected * expected + data.rel_mse_epsilon);
}

// Tone curves, from exposed linear values to linear values of the screen.
const SHOULDER = 0.8;
const TONES = [
  { name: "shoulder, as our PNG", of: (v) => (v <= SHOULDER ? v : 1 - (1 - SHOULDER) * Math.exp(-(v - SHOULDER) / (1 - SHOULDER))) },
  { name: "sRGB, clipped", of: (v) => Math.min(v, 1) },
  { name: "Reinhard, v / (1 + v)", of: (v) => v / (1 + v) },
  { name: "filmic (ACES, as HDR-FLIP)", of: (v) => Math.min(1, ((0.9036 * v + 0.018) * v) / ((0.8748 * v + 0.354) * v + 0.14)) },
  { name: "linear, no sRGB curve", of: (v) => Math.min(v, 1), linear: true },
];

const encode = (v) => (v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);

/** Bytes of a tone curve by the upper 16 bits of a 32-bit float, which is exact to a two-hundredth of a value. */
function toneTable(tone, factor) {
  const bits = new Uint32Array(1);
  const value = new Float32Array(bits.buffer);
  const bytes = new Uint8ClampedArray(65536);
  for (let i = 0; i < 0x8000; i++) {
    // The middle of what has these bits.
    bits[0] = (i << 16) | 0x8000;
    const v = tone.of(value[0] * factor);
    bytes[i] = Number.isNaN(v) ? 255 : Math.round(255 * (tone.linear ? v : encode(v)));
  }
  return bytes;
}

// False colours: a few colours of a scale, straight between them. The first two are viridis and inferno, sampled.
const VIRIDIS = [[68, 1, 84], [72, 40, 120], [62, 74, 137], [49, 104, 142], [38, 130, 142], [31, 158, 137], [53, 183, 121], [110, 206, 88], [181, 222, 43], [253, 231, 37]];
const INFERNO = [[0, 0, 4], [27, 12, 65], [74, 12, 107], [120, 28, 109], [165, 44, 96], [207, 68, 70], [237, 105, 37], [251, 155, 6], [247, 209, 61], [252, 255, 164]];
const SIGNED = [[5, 48, 97], [33, 102, 172], [67, 147, 195], [146, 197, 222], [247, 247, 247], [244, 165, 130], [214, 96, 77], [178, 24, 43], [103, 0, 31]];

/** The colour at a share from 0 to 1 of a scale. */
function colorAt(scale, share) {
  if (Number.isNaN(share)) return [255, 0, 255];
  const place = Math.min(Math.max(share, 0), 1) * (scale.length - 1);
  const low = Math.min(Math.floor(place), scale.length - 2);
  return [0, 1, 2].map((c) => Math.round(scale[low][c] + (place - low) * (scale[low + 1][c] - scale[low][c])));
}

/**
 * What can be shown of a picture. Maps have a scale of colours, the share of it for a pixel, and what its ends mean.
 * Errors need a reference.
 */
const VIEWS = [
  { name: "picture" },
  {
    name: "luminance, false colour", scale: VIRIDIS,
    of: (p, ref, i, factor) => Math.log2(luminance(p.rgb[3 * i], p.rgb[3 * i + 1], p.rgb[3 * i + 2]) * factor) / 12 + 10 / 12,
    ends: (factor) => [short(2 ** -10 / factor), short(2 ** -4 / factor), short(4 / factor)],
    unit: "radiance, logarithmic; the exposure moves it",
  },
  {
    name: "relative error, signed", scale: SIGNED, error: true,
    of: (p, ref, i) => 0.5 + 0.5 * Math.max(-1, Math.min(1, relativeError(p.rgb, ref.rgb, i))),
    ends: () => ["−100 %: too dark", "0", "+100 %: too bright"],
    unit: "difference of luminance over the reference's",
  },
  {
    name: "squared relative error", scale: INFERNO, error: true,
    of: (p, ref, i) => (Math.log10(relativeSquare(p.rgb, ref.rgb, i)) + 5) / 6,
    ends: () => ["1e−5", "0.01", "10"],
    unit: "the term of relMSE, logarithmic",
  },
  {
    name: "FLIP", scale: INFERNO, error: true,
    of: (p, ref, i) => (p.flip ? p.flip[i] / 255 : 0),
    ends: () => ["0: looks the same", "0.5", "1"],
    unit: "visible difference (Andersson et al. 2020, 2021)",
  },
];

/** Draws a picture into bytes of a screen. */
function develop(picture, reference, view, tone, factor, target) {
  const out = target.data;
  const { rgb } = picture;
  if (!view.scale) {
    const bytes = toneTable(tone, factor);
    const halves = new Uint32Array(rgb.buffer);
    for (let i = 0, j = 0; i < rgb.length; i += 3, j += 4) {
      out[j] = bytes[halves[i] >>> 16];
      out[j + 1] = bytes[halves[i + 1] >>> 16];
      out[j + 2] = bytes[halves[i + 2] >>> 16];
      out[j + 3] = 255;
    }
    return;
  }
  const colors = Array.from({ length: 257 }, (_, i) => colorAt(view.scale, i / 256));
  const wrong = colorAt(view.scale, NaN);
  for (let i = 0, j = 0; 3 * i < rgb.length; i++, j += 4) {
    const share = view.of(picture, reference, i, factor);
    const color = Number.isNaN(share) ? wrong : colors[Math.round(256 * Math.min(Math.max(share, 0), 1))];
    out[j] = color[0];
    out[j + 1] = color[1];
    out[j + 2] = color[2];
    out[j + 3] = 255;
  }
}
