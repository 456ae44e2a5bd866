// Everything of the report beside the pictures.

const limitText = threshold => (threshold.fails_if === 'above' ? 'at most ' : 'at least ') + shown(threshold.limit);

function tellVerdict() {
  const failed = data.thresholds.filter(threshold => threshold.fails);
  const text = data.thresholds.length === 0 ? 'No thresholds were given.'
    : failed.length === 0 ? data.thresholds.length === 1 ? 'The threshold is kept.' : `All ${data.thresholds.length} thresholds are kept.`
    : failed.map(threshold => `${threshold.metric} is ${shown(threshold.value)}, allowed ${limitText(threshold)}`).join('; ') + '.';
  const warned = data.warnings.filter(threshold => threshold.fails)
    .map(threshold => `Warning: ${threshold.metric} is ${shown(threshold.value)}, wished ${limitText(threshold)}.`);
  showVerdict(data.pass, data.thresholds.length > 0, [text, ...warned].join(' '));
  const size = picture => `${picture.name} (${picture.size[0]} × ${picture.size[1]})`;
  showNames([['Reference', size(data.reference)], ['Test', size(data.test)]]);
  showRemarks(data.remarks);
}

const of = (thresholds, name) => thresholds.filter(threshold => threshold.metric === name);
const thresholdsOf = name => of(data.thresholds, name);

function fillTiles() {
  for (const name of data.tiles) {
    const row = data.rows.find(candidate => candidate.name === name);
    if (!row) continue;
    const fails = thresholdsOf(name).some(threshold => threshold.fails);
    byId('tiles').append(make('li', { className: fails ? 'bad' : '' },
      make('span', { className: 'name' }, row.full_label),
      make('span', { className: 'value' }, shown(row.value, row.unit, 3))));
  }
}

function fillMetrics() {
  const body = make('tbody');
  let group = '';
  for (const row of data.rows) {
    if (row.group !== group) {
      group = row.group;
      body.append(make('tr', { className: 'group' }, make('th', { colSpan: 3, scope: 'rowgroup' }, group)));
    }
    const thresholds = thresholdsOf(row.name);
    const limits = [...thresholds.map(threshold => limitText(threshold) + (threshold.fails ? ': fails' : ': kept')),
      ...of(data.warnings, row.name).map(threshold => limitText(threshold) + (threshold.fails ? ': warns' : ': kept'))];
    const value = make('td', { className: 'number' }, shown(row.value, row.unit));
    if (row.at) value.append(make('small', {}, `at ${row.at[0]}, ${row.at[1]}`));
    body.append(make('tr', { className: thresholds.some(threshold => threshold.fails) ? 'bad' : '' },
      make('th', { scope: 'row' }, row.label, make('small', {}, row.note)),
      value, make('td', {}, limits.join(', '))));
  }
  byId('metrics').append(make('thead', {}, make('tr', {}, make('th', { scope: 'col' }, 'Figure'),
    make('th', { scope: 'col', className: 'number' }, 'Value'), make('th', { scope: 'col' }, 'Threshold'))), body);
  byId('metrics-note').textContent = data.counted_note;
}

function fillHow() {
  for (const [name, text] of data.how) byId('how').append(make('dt', {}, name), make('dd', {}, text));
  byId('how-section').hidden = data.how.length === 0;
}

/** Long texts open on demand. */
function metadataCell(text, across = 1) {
  const cell = make('td', { colSpan: across });
  if (text !== undefined && text.length > 200) cell.append(make('details', {}, make('summary', {}, text.slice(0, 80).trim() + ' …'), text));
  else cell.append(text ?? '–');
  return cell;
}

function fillProvenance() {
  const first = new Map(data.reference.metadata), second = new Map(data.test.metadata);
  const body = make('tbody');
  for (const key of new Set([...first.keys(), ...second.keys()])) {
    const differs = first.get(key) !== second.get(key);
    body.append(make('tr', { className: differs ? 'differs' : '' }, make('th', { scope: 'row' }, key),
      ...(differs ? [metadataCell(first.get(key)), metadataCell(second.get(key))] : [metadataCell(first.get(key), 2)])));
  }
  if (!body.childElementCount) body.append(make('tr', {}, make('td', { colSpan: 3 }, 'Neither file says anything about itself.')));
  byId('provenance').append(make('thead', {}, make('tr', {}, make('th', { scope: 'col' }, 'Key'),
    make('th', { scope: 'col' }, 'Reference'), make('th', { scope: 'col' }, 'Test'))), body);
}

/** Bars of the first list, a line for the second one; heights are logarithmic, since rare values matter. */
function drawHistogram(histogram) {
  const width = 440, height = 150, bottom = 22, lists = [histogram.first, histogram.second].filter(Boolean);
  const most = Math.max(1, ...lists.flatMap(list => list.bins));
  const level = count => count > 0 ? (height - bottom - 4) * (0.04 + 0.96 * Math.log1p(count) / Math.log1p(most)) : 0;
  const step = width / histogram.first.bins.length, floor = height - bottom;
  const total = histogram.first.bins.reduce((sum, count) => sum + count, 0);
  const label = `${histogram.title}: ${total} pixels from ${shown(histogram.low)} to ${shown(histogram.high, histogram.unit)}`;
  const svg = drawn('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': label });
  histogram.first.bins.forEach((count, i) => {
    const tall = level(count);
    if (tall > 0) svg.append(drawn('rect', { class: 'first', x: i * step + 0.5, y: floor - tall, width: Math.max(step - 1, 0.5), height: tall }));
  });
  if (histogram.second) {
    const points = histogram.second.bins.map((count, i) => `${(i + 0.5) * step},${floor - level(count)}`).join(' ');
    svg.append(drawn('polyline', { class: 'second', points }));
  }
  svg.append(drawn('line', { class: 'axis', x1: 0, x2: width, y1: floor, y2: floor }));
  const ends = [[0, 'start', histogram.low], [width / 2, 'middle', (histogram.low + histogram.high) / 2], [width, 'end', histogram.high]];
  for (const [x, anchor, value] of ends) svg.append(drawn('text', { class: 'tick', x, y: height - 6, 'text-anchor': anchor }, shown(value, histogram.unit)));
  const names = histogram.second ? ` (bars: ${histogram.first.name}, line: ${histogram.second.name})` : '';
  return make('figure', {}, make('figcaption', {}, histogram.title + names + ', logarithmic'), svg);
}

tellVerdict();
fillTiles();
fillMetrics();
fillHow();
fillProvenance();
byId('histograms-section').hidden = data.histograms.length === 0;
for (const histogram of data.histograms) byId('histograms').append(drawHistogram(histogram));
