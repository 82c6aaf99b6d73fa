// The list of cases: thumbnails, pictures of open cases, filters with counts, search, copying commands, keys.

const cases = $$('.case'), filter_buttons = $$('.filters button[data-word]');
const shots_of = new Map(cases.map(c => [c, $$('.shot', c).map(button => new Shot(button))]));
let stops = 0;

// ---- Pictures of the list ------------------------------------------------------------------------------------------

async function draw_case(of_case) {
  for (const shot of shots_of.get(of_case)) {
    const canvas = $('canvas', shot.button);
    if (!canvas) continue;
    await shot.load();
    const view = shot.view(stops);
    canvas.width = shot.w, canvas.height = shot.h;
    canvas.getContext('2d').drawImage(view, 0, 0);
    canvas.dataset.stops = shot.exposed ? stops : 0;
  }
}

async function draw_thumbnails() {
  for (const c of cases) {
    const shot = shots_of.get(c)[0], thumb = $('summary canvas', c);
    if (!shot) continue;
    await shot.load();
    const side = Math.min(shot.w, shot.h), context = thumb.getContext('2d');
    context.imageSmoothingQuality = 'high';
    context.drawImage(shot.view(0), (shot.w - side) / 2, (shot.h - side) / 2, side, side, 0, 0, thumb.width, thumb.height);
    thumb.dataset.drawn = 1;
  }
}

let drawing = 0;
function expose(value) {
  stops = clamp(value, -8, 8);
  for (const label of $$('.exposure')) {
    $('input', label).value = stops;
    $('output', label).textContent = (stops < 0 ? '−' : '+') + Math.abs(stops);
  }
  if (viewer.open) paint();
  cancelAnimationFrame(drawing);
  drawing = requestAnimationFrame(() => cases.filter(c => c.open && !c.hidden).forEach(draw_case));
}
for (const input of $$('.exposure input')) input.addEventListener('input', () => expose(Number(input.value)));

// ---- Filters -------------------------------------------------------------------------------------------------------

const chosen = new Map();  // group to word: one of each group, and all of them must fit
const words_of = new Map(cases.map(c => [c, new Set(c.dataset.words.split('|'))]));
const plain = text => text.toLowerCase().replaceAll('-', '');  // so that povray finds POV-Ray
const text_of = new Map(cases.map(c => [c, plain(c.dataset.name + ' ' + $$('.why, .facts, .badges, .reason', c).map(e => e.textContent).join(' '))]));

function filter() {
  const wanted = plain($('#search').value.trim()).split(/\s+/);
  const found = cases.filter(c => wanted.every(w => text_of.get(c).includes(w)));
  const fits = (c, choice) => [...choice.values()].every(w => words_of.get(c).has(w));
  let shown = 0;
  for (const c of cases) {
    c.hidden = !found.includes(c) || !fits(c, chosen);
    shown += !c.hidden;
  }
  // A button says how many cases there would be with it and what is chosen in the other groups.
  for (const b of filter_buttons) {
    const {group, word} = b.dataset, count = found.filter(c => fits(c, new Map(chosen).set(group, word))).length;
    $('b', b).textContent = count;
    b.classList.toggle('none', count === 0);
    b.setAttribute('aria-pressed', chosen.get(group) === word);
  }
  $('#count').textContent = `${shown} of ${cases.length} cases`;
  $('#clear').disabled = !chosen.size && !$('#search').value;
  $('#nothing').hidden = shown > 0;
}

for (const b of filter_buttons) b.addEventListener('click', () => {
  const {group, word} = b.dataset;
  if (chosen.get(group) === word) chosen.delete(group);
  else chosen.set(group, word);
  filter();
});
$('#search').addEventListener('input', filter);
function clear_filters() {
  chosen.clear();
  $('#search').value = '';
  filter();
}
$('#clear').addEventListener('click', clear_filters);

// ---- Copying -------------------------------------------------------------------------------------------------------

for (const button of $$('.copy')) button.addEventListener('click', async () => {
  const code = $('code', button.parentNode);
  try {
    await navigator.clipboard.writeText(code.textContent);
  } catch {  // not allowed here: select it, so that one key copies it
    getSelection().selectAllChildren(code);
    button.textContent = 'Selected';
    return;
  }
  button.textContent = 'Copied';
});

// ---- Moving about --------------------------------------------------------------------------------------------------

// What is scrolled to must not lie below the filters.
new ResizeObserver(() => document.documentElement.style.setProperty('--bar', $('.filters').offsetHeight + 'px')).observe($('.filters'));

const visible = () => cases.filter(c => !c.hidden);

function open_linked() {
  const linked = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!linked?.matches('.case')) return;
  if (linked.hidden) clear_filters();
  linked.open = true;
  linked.scrollIntoView();
  $('summary', linked).focus({preventScroll: true});
}
addEventListener('hashchange', open_linked);

function step_case(step) {
  const shown = visible(), focused = document.activeElement?.closest('.case');
  const at = shown.indexOf(focused), to = shown[at < 0 ? (step > 0 ? 0 : shown.length - 1) : clamp(at + step, 0, shown.length - 1)];
  if (to) $('summary', to).focus();
}

function list_key(key) {
  const focused = document.activeElement?.closest('.case');
  switch (key) {
    case '/': $('#search').focus(); return true;
    case 'j': step_case(1); return true;
    case 'k': step_case(-1); return true;
    case 'v': show_case(focused ?? visible()[0]); return true;
    case '[': expose(stops - .5); return true;
    case ']': expose(stops + .5); return true;
    case '\\': expose(0); return true;
  }
  return false;
}

for (const c of cases) {
  c.addEventListener('toggle', () => { if (c.open) draw_case(c); });
  if (c.open) draw_case(c);
}
