// Pictures of the report: half floats from the table #floats, inflated when first wanted, and how each kind is shown.
// A picture without floats keeps its PNG. Everything is drawn at its own resolution; the style sheet enlarges it.

const $ = (selector, root = document) => root.querySelector(selector);
const $$ = (selector, root = document) => [...root.querySelectorAll(selector)];

const halves = (() => {  // the value of each of the 65536 halves
  const out = new Float32Array(65536);
  for (let i = 0; i < 65536; ++i) {
    const exponent = i >> 10 & 31, mantissa = i & 1023;
    const size = exponent === 0 ? mantissa * 2 ** -24
      : exponent === 31 ? (mantissa ? NaN : Infinity) : (1024 + mantissa) * 2 ** (exponent - 25);
    out[i] = i & 0x8000 ? -size : size;
  }
  return out;
})();

const table = JSON.parse($('#floats').textContent);
const magma = table.magma.match(/../g).map(digits => parseInt(digits, 16));  // 256 colours
const decoded = new Map();

// A promise of {w, h, c, data}, data interleaved. The stored order is: high bytes of all values, then low bytes; values
// channel by channel. zlib finds more in it that way.
function floats(id) {
  if (!decoded.has(id)) decoded.set(id, (async () => {
    const {w, h, c, scale, z} = table[id];
    const packed = Uint8Array.from(atob(z), letter => letter.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
    const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
    const n = w * h, data = new Float32Array(n * c);
    for (let k = 0; k < c; ++k)
      for (let p = 0; p < n; ++p)
        data[c * p + k] = halves[bytes[n * k + p] << 8 | bytes[n * (c + k) + p]] * scale;
    return {w, h, c, data};
  })());
  return decoded.get(id);
}

const clamp = (x, low, high) => Math.min(high, Math.max(low, x));
const srgb = l => l <= .0031308 ? 12.92 * l : 1.055 * l ** (1 / 2.4) - .055;
function aces(x) {  // Narkowicz's fit with Hill's scale, as FLIP tone maps and the PNGs are made
  x = Math.min(x, 1e9);
  return clamp((.36 * 2.51 * x + .6 * .03) * x / ((.36 * 2.43 * x + .6 * .59) * x + .14), 0, 1);
}
const curve = Float32Array.from({length: 4097}, (_, i) => 255 * srgb(i / 4096));
const not_finite = [255, 0, 255];

// From black to light orange at +1, to light blue at -1.
function signed_colour(v) {
  const t = Math.min(Math.abs(v), 1), ramp = [Math.min(1, 2 * t), .8 * t, .5 * Math.max(0, 2 * t - 1)];
  if (v < 0) ramp.reverse();
  return ramp.map(x => 255 * x);
}

// One picture of the page. `name`, `group` and `role` are what people call it; `show` is how it is coloured.
class Shot {
  constructor(button) {
    const d = button.dataset;
    Object.assign(this, {button, name: d.name, group: d.group, role: d.role, show: d.show, id: d.floats,
                         w: Number(d.w), h: Number(d.h)});
    this.tiles = d.tiles ? JSON.parse(d.tiles) : null;
    this.canvas = document.createElement('canvas');
    this.canvas.width = this.w, this.canvas.height = this.h;
    this.at = null;  // the stops it was last drawn at
    this.values = null;
  }

  get exposed() { return Boolean(this.id) && /radiance|difference/.test(this.show); }

  async load() {
    if (this.id) this.values = await floats(this.id);
    else if (!this.tiles) await $('img', this.button).decode();
    return this;
  }

  // A canvas of the picture's own resolution; load() first.
  view(stops) {
    const wanted = this.exposed ? stops : 0;
    if (this.at === wanted) return this.canvas;
    this.at = wanted;
    const context = this.canvas.getContext('2d', {willReadFrequently: !this.id});  // a PNG's inspector reads it
    if (!this.id && !this.tiles) {
      context.drawImage($('img', this.button), 0, 0);
      return this.canvas;
    }
    const out = context.createImageData(this.w, this.h), paint = this.painter(wanted);
    for (let p = 0; p < this.w * this.h; ++p) {
      out.data.set(paint(p), 4 * p);
      out.data[4 * p + 3] = 255;
    }
    context.putImageData(out, 0, 0);
    return this.canvas;
  }

  // The colour of pixel p, 0 to 255.
  painter(stops) {
    const d = this.button.dataset;
    if (this.tiles) {
      const t = new Float32Array(this.w * this.h);
      for (const tile of this.tiles)
        for (let y = tile.y; y < Math.min(this.h, tile.y + tile.height); ++y)
          t.fill(tile.t ?? NaN, y * this.w + tile.x, y * this.w + Math.min(this.w, tile.x + tile.width));
      return p => Number.isFinite(t[p]) ? signed_colour(t[p] / Number(d.full)) : not_finite;
    }
    const {c, data} = this.values;
    const finite = p => { for (let k = 0; k < c; ++k) if (!Number.isFinite(data[c * p + k])) return false; return true; };
    switch (this.show) {
      case 'radiance': {
        const gain = 2 ** (Number(d.exposure) + stops), byte = v => curve[Math.round(4096 * aces(v * gain))];
        return p => finite(p) ? [byte(data[3 * p]), byte(data[3 * p + 1]), byte(data[3 * p + 2])] : not_finite;
      }
      case 'difference': {  // of the channel with the largest one
        const gain = Number(d.gain) * 2 ** stops;
        return p => {
          if (!finite(p)) return not_finite;
          let v = 0;
          for (let k = 0; k < c; ++k) if (Math.abs(data[c * p + k]) > Math.abs(v)) v = data[c * p + k];
          return signed_colour(v * gain);
        };
      }
      case 'vectors': {
        const low = Number(d.low), range = Number(d.high) - low, byte = v => 255 * (v - low) / range;
        return p => finite(p) ? [byte(data[3 * p]), byte(data[3 * p + 1]), byte(data[3 * p + 2])] : not_finite;
      }
      default: {  // a map of one channel
        const white = Number(d.white);
        return p => {
          if (!finite(p)) return not_finite;
          const i = 3 * Math.round(255 * clamp(data[p] / white, 0, 1));
          return [magma[i], magma[i + 1], magma[i + 2]];
        };
      }
    }
  }

  // The numbers at a pixel, for people.
  at_pixel(x, y) {
    if (x >= this.w || y >= this.h) return ['–'];
    if (this.tiles) {
      const tile = this.tile_at(x, y);
      return [tile && tile.t !== null ? 't ' + number_text(tile.t) : '–'];
    }
    if (this.values)
      return Array.from({length: this.values.c}, (_, k) => number_text(this.values.data[this.values.c * (y * this.w + x) + k]));
    const [r, g, b] = this.view(0).getContext('2d').getImageData(x, y, 1, 1).data;
    return [r, g, b].map(v => v + '/255');
  }

  tile_at(x, y) {
    return this.tiles.find(t => x >= t.x && y >= t.y && x < t.x + t.width && y < t.y + t.height);
  }
}

// Four significant digits, which is what a half float has.
function number_text(v) {
  if (!Number.isFinite(v)) return String(v);
  if (v === 0) return '0';
  const size = Math.abs(v);
  return (size >= 1e-3 && size < 1e5 ? String(Number(v.toPrecision(4))) : v.toExponential(3)).replace('-', '−');
}
