// SPDX-License-Identifier: MIT
// statements.mjs ALIDADE CLOUD DATABASE FILE.parquet ROWS.sql SUMS.sql: the statements (random_statements.py) have the same answers in SQLite,
// loaded and in place, in DuckDB, and those of SUMS.sql in DataFusion, for which `alidade sql rewrite` writes them.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import { DuckDBInstance } from '@duckdb/node-api';
import { dataFusion } from './datafusion.mjs';

const [alidade, cloud, database, parquet, rowsFile, sumsFile] = process.argv.slice(2);
const run = (...words) => execFileSync(alidade, words, { maxBuffer: 1 << 28, stdio: ['ignore', 'pipe', 'ignore'] }).toString();
const lines = (text) => text.trim().split('\n').map((line) => line.replace(/;$/, ''));
// The arrays of statements stand one behind the other.
const answers = (file, place) =>
  JSON.parse(`[${run('sql', place, '--json', '-f', file).trim().replaceAll(/\]\s*\[/g, '],[')}]`).map((list) => list.map(Object.values));
const rewritten = (dialect, file, table) =>
  lines(run('sql', 'rewrite', '--dialect', dialect, '--bounds', cloud, '-f', file)).map((text) => text.replaceAll('FROM points', `FROM ${table}`));
const sorted = (rows) => rows.map((row) => JSON.stringify(row)).sort();

const statements = lines(fs.readFileSync(rowsFile, 'utf8'));
const expected = answers(rowsFile, database);
const inPlace = answers(rowsFile, cloud);
const connection = await (await DuckDBInstance.create()).connect();
let found = 0;
let scans = 0;
for (const [i, text] of rewritten('duckdb', rowsFile, `'${parquet}'`).entries()) {
  assert.deepEqual(sorted(inPlace[i]), sorted(expected[i]), `in place: ${statements[i]}`);
  const rows = (await connection.runAndReadAll(text)).getRows().map((row) => row.map(Number));
  assert.deepEqual(sorted(rows), sorted(expected[i]), `DuckDB: ${text}`);
  found += rows.length;
  scans += text.split('UNION ALL').length;
}
assert.equal(expected.length, statements.length);
assert.ok(found > 10000 && scans > 300, `${found} rows, ${scans} scans`);

const totals = answers(sumsFile, database);
const { query } = await dataFusion(parquet);
for (const [i, text] of rewritten('datafusion', sumsFile, 'p').entries()) {
  const [row] = await query(text);
  assert.deepEqual(row.map((cell) => (cell === '' ? null : Number(cell))), totals[i][0], `DataFusion: ${text}`);
}
console.log(`${statements.length} statements with ${found} rows in SQLite and DuckDB, ${totals.length} in DataFusion`);
