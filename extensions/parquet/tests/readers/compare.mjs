// SPDX-License-Identifier: MIT
// compare.mjs FILE.parquet...: every value that hyparquet, DuckDB and DataFusion read is that of FILE.csv, which `alidade sql` wrote by
// rising ids; statistics and metadata are true.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { DuckDBInstance } from '@duckdb/node-api';
import { asyncBufferFromFile, parquetMetadataAsync, parquetReadObjects } from 'hyparquet';
import { compressors } from 'hyparquet-compressors';
import { dataFusion } from './datafusion.mjs';

/// Rows of fields; those in quotes may have commas, quotes and line ends.
function parseCsv(text) {
  const rows = [[]];
  const field = /("(?:[^"]|"")*"|[^",\n]*)(,|\n|$)/gy;
  for (let match; field.lastIndex < text.length && (match = field.exec(text)); ) {
    rows.at(-1).push(match[1].startsWith('"') ? match[1].slice(1, -1).replaceAll('""', '"') : match[1]);
    if (match[2] === '\n') rows.push([]);
  }
  if (rows.at(-1).length === 0) rows.pop();
  return rows;
}

/// What SQLite makes of a value: it has no NaN, and text shows bytes as hexadecimal digits.
function asText(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return '';
  if (value instanceof Uint8Array) return Buffer.from(value).toString('hex');
  return value;
}
function same(value, text) {
  const own = asText(value);
  if (typeof own === 'number') return text !== '' && own === Number(text.replace('inf', 'Infinity'));
  // SQLite has no whole numbers above 2^63.
  if (typeof own === 'bigint') return String(own) === text || (own >= 1n << 63n && Number(own) === Number(text));
  return own.toLowerCase() === text.toLowerCase();
}
const isNumber = (value) => typeof value === 'bigint' || (typeof value === 'number' && !Number.isNaN(value));
const quoted = (name) => `"${name.replaceAll('"', '""')}"`;
const least = (values) => values.reduce((a, b) => (b < a ? b : a));
const greatest = (values) => values.reduce((a, b) => (b > a ? b : a));

async function compareFile(file) {
  const [names, ...rows] = parseCsv(fs.readFileSync(file.replace(/parquet$/, 'csv'), 'utf8'));
  const buffer = await asyncBufferFromFile(file);
  const metadata = await parquetMetadataAsync(buffer);
  const elements = metadata.schema.slice(1);
  const hasGeometry = elements.at(-1).name === 'geometry';
  const columns = elements.map((element) => element.name).slice(0, hasGeometry ? -1 : undefined);
  assert.deepEqual(columns, names);
  assert.equal(Number(metadata.num_rows), rows.length);

  function compare(reader, valueOf) {
    columns.forEach((name, column) => {
      rows.forEach((row, id) => {
        const value = valueOf(id, column);
        if (!same(value, row[column])) assert.fail(`${reader}: ${name} of row ${id} is ${value}; expected ${row[column]}`);
      });
    });
  }

  // hyparquet, by row group, with the statistics of each.
  const byId = new Array(rows.length);
  let first = 0;
  for (const [number, group] of metadata.row_groups.entries()) {
    const count = Number(group.num_rows);
    const values = await parquetReadObjects({ file: buffer, metadata, compressors, rowStart: first, rowEnd: first + count, utf8: false });
    first += count;
    assert.equal(values.length, count);
    assert.ok(count === 65536 || number === metadata.row_groups.length - 1);
    for (const value of values) byId[Number(value.id)] = value;
    for (const column of group.columns) {
      const { path_in_schema: [name], statistics, type } = column.meta_data;
      const all = values.map((value) => value[name]);
      const there = all.filter((value) => value !== null && value !== undefined);
      assert.equal(Number(statistics.null_count), all.length - there.length, name);
      if (type.endsWith('BYTE_ARRAY') || there.length === 0 || there.some(Number.isNaN)) {
        assert.equal(statistics.min_value, undefined, name);
        continue;
      }
      assert.ok(statistics.min_value == least(there), `${name}: at least ${statistics.min_value}; expected ${least(there)}`);
      assert.ok(statistics.max_value == greatest(there), `${name}: at most ${statistics.max_value}; expected ${greatest(there)}`);
      // Of zeros the lower bound is the negative one, the upper bound the positive one.
      if (type === 'FLOAT' || type === 'DOUBLE')
        assert.ok(!Object.is(statistics.min_value, 0) && !Object.is(statistics.max_value, -0), name);
    }
  }
  assert.equal(first, rows.length);
  compare('hyparquet', (id, column) => byId[id][columns[column]]);
  // DataFusion takes -0 for another number than 0.
  assert.ok(!byId.some((value) => columns.some((name) => Object.is(value[name], -0))));

  // The metadata, and with it GeoParquet's.
  const keys = Object.fromEntries((metadata.key_value_metadata ?? []).map(({ key, value }) => [key, value]));
  const system = keys.crs?.startsWith('{') ? JSON.parse(keys.crs) : null;
  assert.equal('geo' in keys, hasGeometry);
  if (hasGeometry) {
    const geo = JSON.parse(keys.geo);
    assert.equal(geo.version, '1.1.0');
    const { encoding, geometry_types, crs, bbox } = geo.columns[geo.primary_column];
    assert.deepEqual([geo.primary_column, encoding, geometry_types], ['geometry', 'WKB', ['Point Z']]);
    assert.deepEqual(crs, system);
    const axes = ['x', 'y', 'z'].map((axis) => byId.map((value) => value[axis]));
    assert.deepEqual(bbox, [...axes.map(least), ...axes.map(greatest)]);
    for (const { id, x, y, z, geometry } of byId)
      if (geometry.coordinates.join() !== [x, y, z].join()) assert.fail(`the geometry of row ${id} is ${geometry.coordinates}`);
  }

  // DuckDB.
  const connection = await (await DuckDBInstance.create()).connect();
  const reader = await connection.runAndReadAll(`SELECT ${columns.map(quoted).join()} FROM '${file}' ORDER BY id`);
  const read = reader.getColumns();
  compare('DuckDB', (id, column) => {
    const value = read[column][id];
    return value?.bytes ?? value;
  });

  // DataFusion: least and greatest value of each column of numbers. Its package loses its memory over statements that are not ASCII.
  const numeric = columns.filter((name) => /^[ -~]+$/.test(name) && rows.length > 0 && byId.every((value) => isNumber(value[name])));
  const { query } = await dataFusion(file);
  assert.equal(Number((await query('SELECT count(*) FROM p'))[0][0]), rows.length);
  if (numeric.length > 0) {
    // The condition keeps it from answering by the statistics.
    const wanted = numeric.flatMap((name) => [`min(${quoted(name)})`, `max(${quoted(name)})`]);
    const [found] = await query(`SELECT ${wanted.join()} FROM p WHERE id >= 0`);
    // It has the fewest digits that give the number again, of float those for float.
    const isSame = (text, value) =>
      typeof value === 'bigint' ? BigInt(text) === value : Number(text) === value || Math.fround(text) === value;
    numeric.forEach((name, i) => {
      const all = byId.map((value) => value[name]);
      [least(all), greatest(all)].forEach((value, end) => {
        assert.ok(isSame(found[2 * i + end].replace('inf', 'Infinity'), value), `DataFusion: ${name}: ${found[2 * i + end]}; expected ${value}`);
      });
    });
  }
}

for (const file of process.argv.slice(2)) {
  console.log(file);
  await compareFile(file);
}
