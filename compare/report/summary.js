// The page of a batch.

function badge(pair) {
  const good = pair.pass && !pair.error;
  if (good && !data.judged) return make('span', { className: 'badge' }, 'measured');
  return make('span', { className: 'badge ' + (good ? 'good' : 'bad') }, pair.error ? 'error' : good ? 'pass' : 'fail');
}

function listPair(pair) {
  const title = pair.report ? make('a', { href: pair.report }, pair.name) : pair.name;
  const text = make('div', {}, make('h3', {}, title), make('p', {}, badge(pair)));
  if (pair.error) text.append(make('p', {}, pair.error));
  else text.append(make('p', {}, data.tiles.filter(name => pair.metrics[name] !== undefined).map(name => `${data.labels[name].label} ${shown(pair.metrics[name], data.labels[name].unit)}`).join(' · ')));
  if (pair.failed) text.append(make('p', { className: 'note' }, pair.failed));
  const pictures = make('div', { className: 'pictures' });
  for (const [name, source] of pair.pictures) {
    pictures.append(make('figure', {}, make('img', { src: source, alt: `${name} of ${pair.name}` }), make('figcaption', {}, name)));
  }
  const item = make('li', {}, text, pictures);
  item.dataset.fails = String(!pair.pass || Boolean(pair.error));
  return item;
}

const failed = data.pairs.filter(pair => !pair.pass || pair.error).length;
showNames([['Reference', data.reference], ['Test', data.test]]);
const pairs = data.pairs.length === 1 ? '1 pair' : data.pairs.length + ' pairs';
showVerdict(failed === 0, data.judged || failed > 0, failed > 0 ? `${failed} of ${pairs} ${data.judged ? 'fail' : 'cannot be compared'}.`
  : data.judged ? `${pairs} compared, none fails.` : `${pairs} compared. No thresholds were given.`);
showRemarks(data.remarks);
byId('pairs').append(...data.pairs.map(listPair));
byId('only-failed').addEventListener('change', event => {
  for (const item of byId('pairs').children) item.hidden = event.target.checked && item.dataset.fails === 'false';
});
