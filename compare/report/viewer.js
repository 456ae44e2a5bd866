// Swipe, blink, maps, zoom and regions.

const stage = byId('stage'), scene = byId('scene'), swipe = byId('swipe');
const [width, height] = data.reference.size;
const picture = id => byId('picture-' + id);
const isMap = view => view.kind === 'map';
const state = { view: null, zoom: 1, x: 0, y: 0, onTest: false, timer: 0, region: -1 };

/** Pixels of the screen per pixel of the picture when all of it is seen. */
const fitScale = () => stage.clientWidth / width;

function place() {
  state.x = Math.min(0, Math.max(stage.clientWidth * (1 - state.zoom), state.x));
  state.y = Math.min(0, Math.max(stage.clientHeight * (1 - state.zoom), state.y));
  scene.style.transform = `translate(${state.x}px, ${state.y}px) scale(${state.zoom})`;
  scene.classList.toggle('large', state.zoom * fitScale() > 2);
  stage.classList.toggle('zoomed', state.zoom > 1);
  byId('zoom').textContent = Math.round(100 * state.zoom * fitScale()) + ' %';
  const split = Number(swipe.value) / 100 * stage.clientWidth;
  byId('divider').style.left = split + 'px';
  const cut = Math.min(stage.clientWidth, Math.max(0, (split - state.x) / state.zoom));
  picture(data.views[0].over).style.clipPath = state.view.kind === 'swipe' ? `inset(0 0 0 ${cut}px)` : '';
  const box = byId('box'), region = data.regions[state.region];
  box.hidden = !region;
  if (!region) return;
  const unit = fitScale(), edge = 2 / state.zoom;
  Object.assign(box.style, {
    left: region.left * unit - edge + 'px', top: region.top * unit - edge + 'px', borderWidth: edge + 'px', outlineWidth: edge / 2 + 'px',
    width: (region.right - region.left) * unit + 2 * edge + 'px', height: (region.bottom - region.top) * unit + 2 * edge + 'px',
  });
}

function resize() {
  const wanted = Math.min(stage.parentElement.clientWidth, Math.max(240, window.innerHeight * 0.78) * width / height);
  const before = stage.clientWidth || wanted;
  stage.style.width = wanted + 'px';
  stage.style.height = wanted * height / width + 'px';
  state.x *= wanted / before;
  state.y *= wanted / before;
  place();
}

/** Zooms around a place of the stage. */
function zoomTo(zoom, x = stage.clientWidth / 2, y = stage.clientHeight / 2) {
  const most = Math.max(1, 16 / fitScale());
  const wanted = Math.min(most, Math.max(1, zoom));
  state.x = x - (x - state.x) * wanted / state.zoom;
  state.y = y - (y - state.y) * wanted / state.zoom;
  state.zoom = wanted;
  place();
}

/** Which pictures are seen: the last of the list on top. */
function show() {
  const view = state.view, strength = Number(byId('strength').value);
  const seen = view.kind === 'swipe' ? [view.under, view.over]
    : view.kind === 'blink' ? [state.onTest ? view.over : view.under]
    : isMap(view) ? ['reference', view.id] : [view.id];
  for (const image of scene.querySelectorAll('img')) image.classList.toggle('shown', seen.includes(image.id.slice('picture-'.length)));
  if (isMap(view)) picture(view.id).style.opacity = strength / 100;
  byId('tag-left').textContent = view.kind === 'swipe' ? view.left : view.kind === 'blink' ? (state.onTest ? view.right : view.left) : view.title;
  byId('tag-right').textContent = view.kind === 'swipe' ? view.right : '';
  place();
}

function stopBlinking() {
  clearInterval(state.timer);
  state.timer = 0;
  byId('blink-run').setAttribute('aria-pressed', 'false');
}

function switchOnce() {
  state.onTest = !state.onTest;
  show();
}

function startBlinking() {
  stopBlinking();
  state.timer = setInterval(switchOnce, 600);
  byId('blink-run').setAttribute('aria-pressed', 'true');
}

function choose(id) {
  stopBlinking();
  state.view = data.views.find(view => view.id === id);
  const view = state.view;
  for (const button of byId('views').children) button.setAttribute('aria-pressed', String(button.dataset.view === id));
  byId('divider').hidden = byId('swipe-control').hidden = view.kind !== 'swipe';
  byId('blink-control').hidden = view.kind !== 'blink';
  byId('heat-control').hidden = !isMap(view);
  byId('legend').hidden = !isMap(view) || Boolean(view.categories);
  byId('categories').hidden = !view.categories;
  stage.classList.toggle('still', view.kind !== 'swipe');
  stage.setAttribute('aria-label', view.note);
  byId('view-note').textContent = view.note;
  if (view.categories) {
    byId('categories').replaceChildren(...view.categories.map(({ label, color }) => {
      const swatch = make('span', {});
      swatch.style.background = color;
      return make('li', {}, swatch, label);
    }));
  } else if (isMap(view)) {
    byId('legend-low').textContent = view.low;
    byId('legend-high').textContent = view.high;
    byId('legend-bar').setAttribute('aria-label', `Colours from ${view.low} to ${view.high}`);
    byId('legend-bar').style.background = `linear-gradient(to right, ${view.colors.join(', ')})`;
  }
  show();
  if (view.kind === 'blink' && !window.matchMedia('(prefers-reduced-motion: reduce)').matches) startBlinking();
}

function moveDivider(percent) {
  swipe.value = Math.min(100, Math.max(0, percent));
  place();
}

/** Moves what is seen of a zoomed picture; says whether there was anything to move. */
function movePicture(x, y) {
  if (state.zoom === 1) return false;
  state.x -= x;
  state.y -= y;
  place();
  return true;
}

/** A piece of a picture, at least 48 pixels wide, as it is stored. */
function crop(id, title, region) {
  const margin = Math.max(8, Math.round(0.3 * Math.max(region.right - region.left, region.bottom - region.top)));
  const left = Math.max(0, region.left - margin), top = Math.max(0, region.top - margin);
  const right = Math.min(width, region.right + margin), bottom = Math.min(height, region.bottom + margin);
  const across = right - left, down = bottom - top;
  const canvas = make('canvas', { width: across, height: down, role: 'img', 'aria-label': `${title}, region from ${left}, ${top} to ${right}, ${bottom}` });
  canvas.getContext('2d').drawImage(picture(id), left, top, across, down, 0, 0, across, down);
  return make('figure', {}, canvas, make('figcaption', {}, title));
}

function goToRegion(index) {
  const region = data.regions[index];
  if (!region) return;
  state.region = index;
  for (const [i, item] of [...byId('regions').children].entries()) item.firstChild.setAttribute('aria-current', String(i === index));
  const unit = fitScale();
  zoomTo(1);
  const zoom = Math.min(16 / unit, 0.5 * stage.clientWidth / ((region.right - region.left) * unit), 0.5 * stage.clientHeight / ((region.bottom - region.top) * unit));
  state.zoom = Math.max(1, zoom);
  state.x = stage.clientWidth / 2 - state.zoom * unit * (region.left + region.right) / 2;
  state.y = stage.clientHeight / 2 - state.zoom * unit * (region.top + region.bottom) / 2;
  const pictures = data.views.filter(view => view.kind === 'picture' || isMap(view));
  byId('crops').replaceChildren(...pictures.map(view => crop(view.id, view.title, region)));
  byId('crops').hidden = false;
  place();
}

function listRegions() {
  byId('regions-section').hidden = !data.regions.length && !data.regions_note;
  byId('regions-note').textContent = data.regions_note;
  data.regions.forEach((region, index) => {
    const button = make('button', { type: 'button' }, `${index + 1}. ${region.right - region.left} × ${region.bottom - region.top} pixels`,
      make('small', {}, `from ${region.left}, ${region.top}; ${region.pixels} changed, strongest ${shown(region.strongest)}`));
    button.addEventListener('click', () => {
      goToRegion(index);
      byId('viewer').scrollIntoView({ block: 'start' });
    });
    byId('regions').append(make('li', {}, button));
  });
}

function onKey(event) {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const inControl = /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName), inButton = /^(BUTTON|SUMMARY)$/.test(event.target.tagName);
  const step = event.shiftKey ? 10 : 2, maps = data.views.filter(isMap);
  const turn = by => goToRegion((Math.max(state.region, by > 0 ? -1 : 0) + by + data.regions.length) % data.regions.length);
  const move = (x, y) => !inControl && movePicture(20 * step * x, 20 * step * y);
  const turnDivider = by => !inControl && state.view.kind === 'swipe' && moveDivider(Number(swipe.value) + by * step);
  const actions = {
    ArrowLeft: () => move(-1, 0) || turnDivider(-1), ArrowRight: () => move(1, 0) || turnDivider(1),
    ArrowUp: () => move(0, -1), ArrowDown: () => move(0, 1),
    s: () => choose('swipe'), r: () => choose('reference'), t: () => choose('test'),
    b: () => state.view.kind !== 'blink' ? choose('blink') : state.timer ? stopBlinking() : startBlinking(),
    ' ': () => !inControl && !inButton && state.view.kind === 'blink' && (stopBlinking(), switchOnce()),
    m: () => maps.length && choose(maps[(maps.indexOf(state.view) + 1) % maps.length].id),
    n: () => data.regions.length && turn(1), p: () => data.regions.length && turn(-1),
    '+': () => zoomTo(state.zoom * 1.5), '-': () => zoomTo(state.zoom / 1.5), 0: () => zoomTo(1),
  };
  const action = actions[event.key];
  if (action && action() !== false) event.preventDefault();
}

/** Drags the divider, or the picture where it is zoomed in and the divider is far. */
function onPointer(event) {
  if (event.button !== 0) return;
  const left = stage.getBoundingClientRect().left;
  const near = Math.abs(event.clientX - left - Number(swipe.value) / 100 * stage.clientWidth) < 24;
  const moves = state.view.kind === 'swipe' && (state.zoom === 1 || near);
  let { clientX: x, clientY: y } = event;
  const follow = next => {
    if (moves) return moveDivider(100 * (next.clientX - left) / stage.clientWidth);
    state.x += next.clientX - x;
    state.y += next.clientY - y;
    [x, y] = [next.clientX, next.clientY];
    place();
  };
  const end = () => {
    stage.removeEventListener('pointermove', follow);
    for (const name of ['pointerup', 'pointercancel']) stage.removeEventListener(name, end);
  };
  stage.setPointerCapture(event.pointerId);
  stage.addEventListener('pointermove', follow);
  for (const name of ['pointerup', 'pointercancel']) stage.addEventListener(name, end);
  follow(event);
}

for (const view of data.views) {
  const button = make('button', { type: 'button' }, view.title);
  button.dataset.view = view.id;
  button.addEventListener('click', () => choose(view.id));
  byId('views').append(button);
}
swipe.addEventListener('input', place);
byId('strength').addEventListener('input', show);
byId('blink-run').addEventListener('click', () => state.timer ? stopBlinking() : startBlinking());
byId('blink-once').addEventListener('click', () => (stopBlinking(), switchOnce()));
byId('zoom-in').addEventListener('click', () => zoomTo(state.zoom * 1.5));
byId('zoom-out').addEventListener('click', () => zoomTo(state.zoom / 1.5));
byId('zoom-fit').addEventListener('click', () => (state.region = -1, zoomTo(1)));
stage.addEventListener('pointerdown', onPointer);
stage.addEventListener('dblclick', event => zoomTo(state.zoom * 2, event.clientX - stage.getBoundingClientRect().left, event.clientY - stage.getBoundingClientRect().top));
document.addEventListener('keydown', onKey);
window.addEventListener('resize', resize);
listRegions();
choose('swipe');
resize();
