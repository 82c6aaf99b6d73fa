// The large view: two pictures of a case, the current and the other, seen alone, by wipe, side by side or blended, with
// one zoom and one inspected pixel for both.

const viewer = $('#viewer'), stage = $('#v-stage'), help = $('#help');
const under = $('#v-canvas'), over = $('#v-over'), beside = $('#v-beside'), handle = $('#v-handle');
let of_case = null, shots = [], current = 0, other = 0, mode = 'one', mix = .5;
let zoom = 0, centre = null;           // screen pixels per pixel, 0: fit; the picture's point in the middle of a pane
let here = null, pinned = false;       // the inspected pixel

function text(tag, content, parent) {
  const element = document.createElement(tag);
  element.textContent = content;
  parent.append(element);
  return element;
}

// ---- What is shown -------------------------------------------------------------------------------------------------

const with_role = (role, group) => shots.findIndex(s => s.role === role && (!group || s.group === group));

// What a picture is compared with when nobody has said it: ours with theirs, everything else with ours.
function counterpart(index) {
  const {role, group} = shots[index];
  const places = role === 'ours' ? [with_role('theirs', group), with_role('theirs')] : [with_role('ours', group), with_role('ours')];
  return places.find(i => i >= 0) ?? (index === 0 && shots.length > 1 ? 1 : 0);
}

async function show_case(wanted, index = 0) {
  if (!wanted || !shots_of.get(wanted).length) return;
  const loading = shots_of.get(wanted);
  await Promise.all(loading.map(s => s.load()));
  of_case = wanted, shots = loading, current = index, other = counterpart(index);
  zoom = 0, here = null, pinned = false;
  $('#v-case').textContent = of_case.dataset.name;
  $('#v-badges').replaceChildren(...$$('summary > .badges > .badge', of_case).map(b => b.cloneNode(true)));
  const tabs = $('#v-tabs');
  tabs.replaceChildren();
  let group = null;
  shots.forEach((shot, i) => {
    if (!group || group.dataset.group !== shot.group) {
      group = text('span', '', tabs);
      group.className = 'group', group.dataset.group = shot.group;
      group.setAttribute('role', 'group'), group.setAttribute('aria-label', shot.group);
      text('i', shot.group, group);
    }
    const button = text('button', '', group);
    button.type = 'button';
    if (i < 9) text('kbd', i + 1, button);
    button.append(shot.name);
    // After a mouse click the keys belong to the stage again; who came by keyboard stays on the button.
    button.addEventListener('click', event => { select(i); if (event.detail) stage.focus(); });
  });
  if (!viewer.open) viewer.showModal();
  stage.focus();
  paint();
}

function select(index) {
  if (!shots[index] || index === current) return;
  other = current, current = index;
  paint();
}

function swap() {
  [current, other] = [other, current];
  paint();
}

function set_mode(value) {
  mode = mode === value ? 'one' : value;
  paint();
}

function set_mix(value) {
  mix = clamp(value, 0, 1);
  $('#v-mix').value = Math.round(100 * mix);
  $('output', $('#v-mix-label')).textContent = Math.round(100 * mix) + ' %';
  layout();
}

function copy(shot, canvas) {
  canvas.width = shot.w, canvas.height = shot.h;
  canvas.getContext('2d').drawImage(shot.view(stops), 0, 0);
}

function paint() {
  const a = shots[current], b = shots[other];
  viewer.dataset.mode = mode;
  copy(a, under), copy(b, over), copy(b, beside);
  $$('#v-tabs button').forEach((button, i) => {
    button.setAttribute('aria-pressed', i === current);
    button.classList.toggle('other', i === other && i !== current);
  });
  for (const button of $$('.modes button')) button.setAttribute('aria-pressed', button.dataset.mode === mode);
  $('#v-mix-label').hidden = mode !== 'wipe' && mode !== 'blend';
  const title = s => s.role === 'ours' || s.name.includes(s.group) ? s.name : `${s.name} · ${s.group}`;
  const [left, right, second] = $$('#v-stage .label');
  left.textContent = title(a);
  right.textContent = second.textContent = title(b);
  right.hidden = mode !== 'wipe' && mode !== 'blend';
  const dull = !a.exposed && stops ? ' (not exposed)' : '';
  $('#v-said').textContent = mode === 'one' ? title(a) + dull : `${mode}: ${title(a)}, ${title(b)}`;
  layout();
  inspect();
}

// ---- Where it is shown ---------------------------------------------------------------------------------------------

const first_pane = under.parentNode;

function fitting() {
  const pad = 8, w = first_pane.clientWidth - pad, h = first_pane.clientHeight - pad, shot = shots[current];
  const fit = Math.min(w / shot.w, h / shot.h);
  return fit > 1 ? Math.floor(fit) : fit;
}

// Left and top of the picture in a pane, and its scale.
function placed() {
  const shot = shots[current], scale = zoom || fitting();
  const middle = zoom && centre ? centre : {x: shot.w / 2, y: shot.h / 2};
  return {scale, left: Math.round(first_pane.clientWidth / 2 - middle.x * scale), top: Math.round(first_pane.clientHeight / 2 - middle.y * scale)};
}

function layout() {
  if (!shots.length) return;
  const shot = shots[current], {scale, left, top} = placed();
  for (const canvas of [under, over, beside]) {
    canvas.style.left = left + 'px', canvas.style.top = top + 'px';
    canvas.style.width = shot.w * scale + 'px', canvas.style.height = shot.h * scale + 'px';
  }
  over.style.clipPath = mode === 'wipe' ? `inset(0 0 0 ${100 * mix}%)` : '';
  over.style.opacity = mode === 'blend' ? mix : '';
  handle.style.left = clamp(left + mix * shot.w * scale, 0, first_pane.clientWidth) + 'px';
  for (const mark of $$('#v-stage .mark')) {
    mark.hidden = !here;
    if (here) {
      mark.style.left = left + here.x * scale + 'px', mark.style.top = top + here.y * scale + 'px';
      mark.style.width = mark.style.height = scale + 'px';
    }
  }
  viewer.dataset.zoom = scale;
}

// The picture's point under a place on the screen, of either pane.
function point_at(event) {
  const pane = mode === 'side' && event.clientX >= $('#v-second').getBoundingClientRect().left ? $('#v-second') : first_pane;
  const box = pane.getBoundingClientRect(), {scale, left, top} = placed();
  return {x: (event.clientX - box.left - left) / scale, y: (event.clientY - box.top - top) / scale};
}

// Zooms and keeps the point where it is on the screen.
function zoom_to(scale, point) {
  const before = placed(), shot = shots[current], smallest = Math.min(1, fitting());
  const wanted = clamp(scale, smallest, 64);
  const keep = point ?? (here && pinned ? {x: here.x + .5, y: here.y + .5} : {x: shot.w / 2, y: shot.h / 2});
  const middle = {x: (first_pane.clientWidth / 2 - before.left) / before.scale, y: (first_pane.clientHeight / 2 - before.top) / before.scale};
  centre = {x: keep.x + (middle.x - keep.x) * before.scale / wanted, y: keep.y + (middle.y - keep.y) * before.scale / wanted};
  zoom = wanted;
  layout();
}

function zoom_by(steps, point) {
  const scale = placed().scale, levels = [.25, .5, 1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64];
  const next = steps > 0 ? levels.find(l => l > scale * 1.001) : levels.findLast(l => l < scale * .999);
  if (next) zoom_to(next, point);
}

// ---- Inspector -----------------------------------------------------------------------------------------------------

const loupe_pixels = 7, loupe_scale = 6;

function inspect() {
  const rows = $('#v-values');
  rows.replaceChildren();
  $('#v-where').textContent = here ? `pixel ${here.x}, ${here.y}${pinned ? ' · pinned' : ''}` : 'Point at a pixel, or use the arrow keys.';
  $('#v-tile').textContent = '';
  if (!here) return layout();
  shots.forEach((shot, i) => {
    const row = text('tr', '', rows);
    row.className = i === current ? 'current' : '';
    const loupe = text('canvas', '', text('td', '', row));
    loupe.width = loupe.height = loupe_pixels * loupe_scale;
    const context = loupe.getContext('2d'), half = loupe_pixels >> 1;
    context.imageSmoothingEnabled = false;
    context.drawImage(shot.view(stops), here.x - half, here.y - half, loupe_pixels, loupe_pixels, 0, 0, loupe.width, loupe.height);
    context.strokeStyle = '#fff';
    context.strokeRect(half * loupe_scale - .5, half * loupe_scale - .5, loupe_scale + 1, loupe_scale + 1);
    const cell = text('td', '', row);
    text('b', shot.role === 'ours' || shot.name.includes(shot.group) ? shot.name : `${shot.name}, ${shot.group}`, cell);
    const values = text('span', '', cell);
    for (const value of shot.at_pixel(here.x, here.y)) text('span', value, values);
    if (shot.tiles && (shot.group === shots[current].group || !$('#v-tile').textContent)) {
      const tile = shot.tile_at(here.x, here.y), percent = x => (x > 0 ? '+' : '') + number_text(100 * x) + ' %';
      if (tile)
        $('#v-tile').textContent = `tile ${tile.x}, ${tile.y} (${shot.group}): ` +
          (tile.relative === null ? '' : `luminance ${percent(tile.relative)}` +
            (Number.isFinite(tile.low) && Number.isFinite(tile.high) ? ` [${percent(tile.low)}, ${percent(tile.high)}]` : '') + ', ') +
          (tile.t === null ? 'no t' : `t ${number_text(tile.t)}`) + (tile.significant ? ', significant' : '');
    }
  });
  layout();
}

function look_at(x, y) {
  const shot = shots[current];
  here = {x: clamp(Math.floor(x), 0, shot.w - 1), y: clamp(Math.floor(y), 0, shot.h - 1)};
  inspect();
}

function move_pixel(dx, dy) {
  const start = here ?? {x: shots[current].w >> 1, y: shots[current].h >> 1};
  pinned = true;
  look_at(start.x + dx, start.y + dy);
}

// ---- Pointer -------------------------------------------------------------------------------------------------------

let drag = null;  // {x, y, centre, moved, wipe}

stage.addEventListener('pointerdown', event => {
  const wipe = mode === 'wipe' && Math.abs(event.clientX - handle.getBoundingClientRect().left) < 16;
  const {scale, left, top} = placed();
  drag = {x: event.clientX, y: event.clientY, moved: false, wipe,
          centre: {x: (first_pane.clientWidth / 2 - left) / scale, y: (first_pane.clientHeight / 2 - top) / scale}};
  stage.setPointerCapture(event.pointerId);
});
stage.addEventListener('pointermove', event => {
  const point = point_at(event), shot = shots[current];
  if (drag?.wipe) return set_mix(point.x / shot.w);
  if (drag) {
    const dx = event.clientX - drag.x, dy = event.clientY - drag.y, {scale} = placed();
    drag.moved ||= Math.hypot(dx, dy) > 4;
    if (!drag.moved) return;
    zoom = scale, centre = {x: drag.centre.x - dx / scale, y: drag.centre.y - dy / scale};
    return layout();
  }
  if (!pinned && point.x >= 0 && point.y >= 0 && point.x < shot.w && point.y < shot.h) look_at(point.x, point.y);
});
stage.addEventListener('pointerup', event => {
  const point = point_at(event), shot = shots[current];
  if (drag && !drag.moved && !drag.wipe && point.x >= 0 && point.y >= 0 && point.x < shot.w && point.y < shot.h) {
    // The pinned pixel clicked again is free again.
    pinned = !(pinned && here.x === Math.floor(point.x) && here.y === Math.floor(point.y));
    look_at(point.x, point.y);
  }
  drag = null;
});
stage.addEventListener('wheel', event => {
  event.preventDefault();
  zoom_by(-Math.sign(event.deltaY), point_at(event));
}, {passive: false});
addEventListener('resize', () => viewer.open && layout());

// ---- Buttons and keys ----------------------------------------------------------------------------------------------

function neighbour(step) {
  const shown = visible().filter(c => shots_of.get(c).length), next = shown[shown.indexOf(of_case) + step];
  if (!next) return;
  const {name, group} = shots[current];  // stay on the picture of that name if the next case has one
  const same = shots_of.get(next).findIndex(s => s.name === name && s.group === group);
  show_case(next, Math.max(same, 0));
}

function go_to(role) {
  const index = [with_role(role, shots[current].group), with_role(role)].find(i => i >= 0);
  if (index !== undefined) select(index);
}

const arrows = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};
const keys = {
  x: swap, o: () => set_mode('one'), w: () => set_mode('wipe'), s: () => set_mode('side'), b: () => set_mode('blend'),
  ',': () => set_mix(mix - .05), '.': () => set_mix(mix + .05),
  r: () => go_to('ours'), g: () => go_to('theirs'), d: () => go_to('difference'), f: () => go_to('map'), m: () => go_to('tiles'),
  p: () => { if (here) pinned = !pinned, inspect(); },
  '+': () => zoom_by(1), '=': () => zoom_by(1), '-': () => zoom_by(-1), '0': () => { zoom = 0; layout(); },
  '[': () => expose(stops - .5), ']': () => expose(stops + .5), '\\': () => expose(0),
  j: () => neighbour(1), k: () => neighbour(-1),
};

addEventListener('keydown', event => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const {key, target} = event, writes = target.matches?.('input[type=search]');
  if (help.open || writes) return;
  let done = true;
  if (key === '?') help.showModal();
  else if (!viewer.open) done = list_key(key);
  else if (arrows[key] && target.type !== 'range') move_pixel(...arrows[key].map(v => v * (event.shiftKey ? 8 : 1)));
  else if (key === ' ' && target.tagName !== 'BUTTON') swap();
  else if (key >= '1' && key <= '9') select(Number(key) - 1);
  else if (keys[key]) keys[key]();
  else done = false;
  if (done) event.preventDefault();
});

for (const button of $$('.modes button')) button.addEventListener('click', () => { mode = 'one'; set_mode(button.dataset.mode); });
$('#v-swap').addEventListener('click', swap);
$('.v-bar').addEventListener('click', event => { if (event.detail && event.target.closest('button')) stage.focus(); });
$('#v-mix').addEventListener('input', event => set_mix(Number(event.target.value) / 100));
$('#v-out').addEventListener('click', () => zoom_by(-1));
$('#v-in').addEventListener('click', () => zoom_by(1));
$('#v-fit').addEventListener('click', keys['0']);
$('#v-close').addEventListener('click', () => viewer.close());
$('#v-previous').addEventListener('click', () => neighbour(-1));
$('#v-next').addEventListener('click', () => neighbour(1));
for (const button of $$('.help')) button.addEventListener('click', () => help.showModal());
$('#help-close').addEventListener('click', () => help.close());
viewer.addEventListener('close', () => {  // back to the picture that was looked at, not to where it began
  of_case.open = true;
  shots[current].button.focus();
});
for (const c of cases) {
  for (const button of $$('.pixel', c)) button.addEventListener('click', async () => {
    await show_case(c);
    const x = Number(button.dataset.x), y = Number(button.dataset.y);
    if (!viewer.open) return;
    pinned = true;
    look_at(x, y);
    zoom_to(16);
  });
  shots_of.get(c).forEach((shot, i) => shot.button.addEventListener('click', () => show_case(c, i)));
}

filter();
open_linked();
draw_thumbnails();
