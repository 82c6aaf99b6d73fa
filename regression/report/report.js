// The report's page: filters and search, one exposure for all pictures, and the large view with its pixel inspector.
// Everything works on half floats from the table #floats; a picture without an entry there keeps its PNG.
'use strict';
(() => {
const $ = (selector, root = document) => root.querySelector(selector);
const $$ = (selector, root = document) => [...root.querySelectorAll(selector)];
document.documentElement.classList.add('js');

// ---- Pictures ------------------------------------------------------------------------------------------------------

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
const decoded = new Map();

// {w, h, c, data} or undefined.
function picture(id) {
  if (!id || !table[id]) return undefined;
  if (!decoded.has(id)) {
    const {w, h, c, scale, half} = table[id], bytes = atob(half), data = new Float32Array(w * h * c);
    for (let i = 0; i < data.length; ++i)
      data[i] = halves[bytes.charCodeAt(2 * i) | bytes.charCodeAt(2 * i + 1) << 8] * scale;
    decoded.set(id, {w, h, c, data});
  }
  return decoded.get(id);
}

const clamp01 = x => x > 0 ? Math.min(x, 1) : 0;
const srgb = l => l <= .0031308 ? 12.92 * l : 1.055 * l ** (1 / 2.4) - .055;
function aces(x) {  // as the report's PNGs, and FLIP
  x = Math.min(x, 1e9);
  return clamp01((.36 * 2.51 * x + .6 * .03) * x / ((.36 * 2.43 * x + .6 * .59) * x + .14));
}
const curve = Float32Array.from({length: 4097}, (_, i) => 255 * srgb(i / 4096));
const byte = x => curve[Math.round(4096 * x)];

// Draws an <img> of the page at `stops` more exposure onto a canvas of its own resolution.
function draw(img, canvas, stops) {
  const d = img.dataset, source = /radiance|difference/.test(d.show) && picture(d.floats);
  const context = canvas.getContext('2d');
  if (!source) {
    canvas.width = img.naturalWidth, canvas.height = img.naturalHeight;
    context.drawImage(img, 0, 0);
    return;
  }
  canvas.width = source.w, canvas.height = source.h;
  const out = context.createImageData(source.w, source.h), n = source.w * source.h;
  if (d.show === 'radiance') {
    const gain = 2 ** (Number(d.exposure) + stops);
    for (let p = 0; p < n; ++p) {
      const rgb = [0, 1, 2].map(c => source.data[3 * p + c] * gain);
      out.data.set(rgb.every(Number.isFinite) ? rgb.map(v => byte(aces(v))) : [255, 0, 255], 4 * p);
      out.data[4 * p + 3] = 255;
    }
  } else {
    const gain = Number(d.gain) * 2 ** stops;
    for (let p = 0; p < n; ++p) {
      let v = 0;
      for (let c = 0; c < 3; ++c) {
        const e = source.data[3 * p + c];
        if (!(Math.abs(e) <= Math.abs(v))) v = e;
        if (Number.isNaN(e)) break;
      }
      const t = Math.min(Math.abs(v * gain), 1), ramp = [Math.min(1, 2 * t), .8 * t, .5 * Math.max(0, 2 * t - 1)];
      if (v < 0) ramp.reverse();
      out.data.set(Number.isFinite(v) ? ramp.map(x => 255 * x) : [255, 0, 255], 4 * p);
      out.data[4 * p + 3] = 255;
    }
  }
  context.putImageData(out, 0, 0);
}

// ---- Exposure ------------------------------------------------------------------------------------------------------

let stops = 0, waiting = 0;
const pages = $$('.shot img');

function refresh() {  // pictures of open cases; others when they are opened
  const canvas = document.createElement('canvas');
  for (const img of pages) {
    if (Number(img.dataset.at || 0) === stops || !img.closest('.case').open) continue;
    img.dataset.at = stops;
    img.dataset.png ||= img.src;
    if (stops === 0 || !/radiance|difference/.test(img.dataset.show)) img.src = img.dataset.png;
    else draw(img, canvas, stops), img.src = canvas.toDataURL();
  }
}

function expose(value) {
  stops = Math.max(-8, Math.min(8, value));
  for (const label of $$('.exposure')) {
    $('input', label).value = stops;
    $('output', label).textContent = (stops < 0 ? '−' : '+') + Math.abs(stops);
  }
  clearTimeout(waiting);
  waiting = setTimeout(refresh, 120);
  if (viewer.open) paint();
}
for (const input of $$('.exposure input')) input.addEventListener('input', () => expose(Number(input.value)));

// ---- Cases, filters, search ----------------------------------------------------------------------------------------

const cases = $$('.case'), buttons = $$('.filters button');
let word = '';

for (const c of cases) {
  c.addEventListener('toggle', refresh);
  const first = $('.shot img', c);
  if (!first) continue;
  const thumb = new Image();
  thumb.src = first.src, thumb.alt = '';
  $('summary', c).prepend(thumb);
}

function filter() {
  const wanted = $('#search').value.trim().toLowerCase();
  let shown = 0;
  for (const c of cases) {
    const fits = (!word || c.dataset.words.split('|').includes(word)) &&
      (!wanted || (c.dataset.name + ' ' + $('.why', c).textContent + ' ' + $('.facts', c).textContent).toLowerCase().includes(wanted));
    c.hidden = !fits;
    shown += fits;
  }
  $('#nothing').hidden = shown > 0;
  for (const b of buttons) b.setAttribute('aria-pressed', b.dataset.word === word);
}
for (const b of buttons) b.addEventListener('click', () => { word = b.dataset.word === word ? '' : b.dataset.word; filter(); });
$('#search').addEventListener('input', filter);

function open_linked() {
  const linked = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (linked && linked.matches('.case')) linked.open = true, linked.scrollIntoView();
}
addEventListener('hashchange', open_linked);

// ---- Viewer --------------------------------------------------------------------------------------------------------

const viewer = $('#viewer'), canvas = $('#v-canvas'), stage = $('#v-stage');
let shots = [], current = 0, before = 0, here = null;  // here: {x, y} of the pixel under the cursor

function text(tag, content, parent) {
  const element = document.createElement(tag);
  element.textContent = content;
  parent.append(element);
  return element;
}

function show_case(of_case, index = 0) {
  shots = $$('.shot img', of_case);
  if (!shots.length) return;
  before = shots.length > 1 ? (index ? 0 : 1) : 0;
  $('#v-case').textContent = of_case.dataset.name;
  $('#v-badges').replaceChildren(...$$('summary > .badges > .badge', of_case).map(b => b.cloneNode(true)));
  $('#v-tabs').replaceChildren();
  shots.forEach((img, i) => {
    const button = document.createElement('button');
    button.type = 'button';
    text('kbd', i < 9 ? i + 1 : '', button);
    button.append(img.dataset.name);
    button.addEventListener('click', () => select(i));
    $('#v-tabs').append(button);
  });
  viewer.of_case = of_case, here = null;
  if (!viewer.open) viewer.showModal();
  canvas.focus();
  current = index;
  select(index);
}

function select(index) {
  if (index >= shots.length) return;
  if (index !== current) before = current;
  current = index;
  $$('#v-tabs button').forEach((b, i) => b.setAttribute('aria-pressed', i === index));
  paint();
}

function paint() {
  draw(shots[current], canvas, stops);
  inspect();  // first: its table takes room
  const fit = Math.min(stage.clientWidth / canvas.width, stage.clientHeight / canvas.height);
  const zoom = fit > 1 ? Math.floor(fit) : fit;
  canvas.style.width = canvas.width * zoom + 'px';
  canvas.style.height = canvas.height * zoom + 'px';
}

// The values of every picture of the case under the cursor.
function inspect() {
  const rows = $('#v-values');
  rows.replaceChildren();
  const title = text('tr', '', rows);
  text('td', here ? `pixel ${here.x}, ${here.y}` : 'point at a pixel', title);
  shots.forEach((img, i) => {
    const d = img.dataset, one = picture(d.floats);
    if (!one || one.w !== canvas.width || one.h !== canvas.height) return;
    const row = text('tr', '', rows);
    row.className = i === current ? 'current' : '';
    text('td', d.name, row);
    for (let c = 0; here && c < one.c; ++c)
      text('td', one.data[one.c * (here.y * one.w + here.x) + c].toPrecision(4), row);
  });
}

function neighbour(step) {
  const shown = cases.filter(c => !c.hidden && $('.shot', c));
  const place = shown.indexOf(viewer.of_case) + step;
  const name = shots[current].dataset.name;
  if (!shown[place]) return;
  // Stay on the picture of the same name if the next case has one.
  const same = $$('.shot img', shown[place]).findIndex(img => img.dataset.name === name);
  show_case(shown[place], Math.max(same, 0));
}

canvas.addEventListener('pointermove', event => {
  const box = canvas.getBoundingClientRect();
  here = {x: Math.min(canvas.width - 1, Math.max(0, Math.floor((event.clientX - box.left) / box.width * canvas.width))),
          y: Math.min(canvas.height - 1, Math.max(0, Math.floor((event.clientY - box.top) / box.height * canvas.height)))};
  inspect();
});
canvas.addEventListener('click', () => select(before));
addEventListener('resize', () => viewer.open && paint());
$('#v-close').addEventListener('click', () => viewer.close());
$('#v-previous').addEventListener('click', () => neighbour(-1));
$('#v-next').addEventListener('click', () => neighbour(1));
for (const img of pages)
  img.parentNode.addEventListener('click', () => {
    const of_case = img.closest('.case');
    show_case(of_case, $$('.shot img', of_case).indexOf(img));
  });

addEventListener('keydown', event => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const key = event.key;
  if (!viewer.open) {
    if (key === '/' && event.target.tagName !== 'INPUT') $('#search').focus(), event.preventDefault();
    return;
  }
  if (event.target.type === 'range' && key.startsWith('Arrow')) return;
  const actions = {ArrowLeft: () => neighbour(-1), ArrowRight: () => neighbour(1), ' ': () => select(before),
                   '+': () => expose(stops + .5), '=': () => expose(stops + .5), '-': () => expose(stops - .5)};
  if (key >= '1' && key <= '9') select(Number(key) - 1);
  else if (actions[key]) actions[key]();
  else return;
  event.preventDefault();
});

filter();
open_linked();
})();
