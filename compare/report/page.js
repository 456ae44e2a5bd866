'use strict';
// What both pages need. All text of users goes through textContent: nothing of it is ever read as HTML.

const data = JSON.parse(document.getElementById('comparison').textContent);

const byId = id => document.getElementById(id);

/** An element with properties and children; strings become text. */
function make(name, properties = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key in element && key !== 'list') element[key] = value; else element.setAttribute(key, value);
  }
  element.append(...children);
  return element;
}

/** An SVG element with attributes. */
function drawn(name, attributes = {}, text = '') {
  const element = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.textContent = text;
  return element;
}

/** A value as people read it; values that JSON cannot hold come as words. */
function shown(value, unit = '', digits = 5) {
  if (value === null || value === undefined) return '–';
  if (typeof value === 'string') return value === 'infinity' ? '∞' : value === '-infinity' ? '−∞' : 'not a number';
  const size = Math.abs(value);
  const text = Number.isInteger(value) && size < 1e9 ? String(value)
    : size >= 1e6 || size < 1e-4 ? value.toExponential(3)
    : String(Number(value.toPrecision(digits)));
  return text.replace(/^-/, '−') + (unit ? ' ' + unit : '');
}

function showVerdict(passes, judged, text) {
  const kind = judged ? (passes ? 'good' : 'bad') : '';
  byId('verdict').append(make('p', { className: 'verdict ' + kind }, make('strong', {}, !judged ? 'Measured' : passes ? 'Pass' : 'Fail'), make('span', {}, text)));
}

function showRemarks(remarks) {
  byId('remarks').hidden = remarks.length === 0;
  for (const remark of remarks) byId('remarks').append(make('li', {}, remark));
}

function showNames(entries) {
  for (const [name, text] of entries) byId('names').append(make('dt', {}, name), make('dd', {}, text));
}

byId('footer').textContent = 'Written by ' + data.generator + '. This page is one file and loads nothing from elsewhere.';
