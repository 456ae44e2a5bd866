// SPDX-License-Identifier: MIT
// extension.mjs ALIDADE EXTENSION CLOUD DATABASE: DuckDB's table functions over a cloud file have the rows that SQLite has for the database.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import { DuckDBInstance } from '@duckdb/node-api';

const [alidade, extension, cloud, database] = process.argv.slice(2);
const instance = await DuckDBInstance.create(':memory:', { allow_unsigned_extensions: 'true' });
const connection = await instance.connect();
await connection.run(`LOAD '${extension}'`);
const ask = async (statement) =>
  (await connection.runAndReadAll(statement)).getRows().map((row) => row.map((value) => (value === null ? null : Number(value))));
const askSqlite = (statement) =>
  JSON.parse(execFileSync(alidade, ['sql', database, statement, '--json'], { maxBuffer: 1 << 28, stdio: ['ignore', 'pipe', 'ignore'] })).map(Object.values);
const sorted = (rows) => rows.map((row) => JSON.stringify(row)).sort();

const columns = 'id, x, y, z, red, intensity, classification, gps_time, scan_angle';
const same = async (from, condition, more = '') => {
  const rows = await ask(`SELECT ${columns}${more} FROM ${from}`);
  assert.deepEqual(sorted(rows), sorted(askSqlite(`SELECT ${columns}${more} FROM points${condition}`)), from);
  return rows.length;
};
assert.equal(await same(`alidade_points('${cloud}')`, ''), 20000);
let found = 0;
for (const ray of ['690000,5325000,640, 0,0,-1', '690000,5325000,601.5, 1,0.2,0', '689950.5,5325001,600, 1e-3,-1,0.02']) {
  for (const radius of [0, 0.1, 1, 30])
    found += await same(`alidade_ray('${cloud}', ${ray}, ${radius})`, `(${ray}) WHERE dist <= ${radius}`, ', dist, t');
  found += await same(`alidade_plane('${cloud}', ${ray}, -0.3, 0.2)`, ` WHERE dist_plane(${ray}, x,y,z) BETWEEN -0.3 AND 0.2`);
}
assert.ok(found > 10000);
// Only what is wanted, joins of two scans, and as much as fits no single vector of rows.
assert.deepEqual(await ask(`SELECT count(*) FROM alidade_points('${cloud}')`), [[20000]]);
const ray = `alidade_ray('${cloud}', 690000,5325000,640, 0,0,-1, 5)`;
const [[own]] = await ask(`SELECT count(*) FROM ${ray}`);
assert.deepEqual(await ask(`SELECT count(*) FROM ${ray} a JOIN ${ray} b USING (id) JOIN alidade_points('${cloud}') c USING (id)`), [[own]]);

const rejected = (from, message) => assert.rejects(ask(`SELECT * FROM ${from}`), message, from);
await rejected(`alidade_ray('${cloud}', 0,0,0, 0,0,0, 1)`, /ray direction is zero/);
await rejected(`alidade_ray('${cloud}', 0,0,0, 0,0,1, NULL)`, /argument 8 is NULL/);
await rejected(`alidade_points(NULL)`, /missing file name/);
await rejected(`alidade_points('nothing.las')`, /nothing\.las: cannot open the file/);
await rejected(`alidade_ray('${cloud}', 1)`, /alidade_ray/);
const copy = `${cloud}.copy.las`;
fs.copyFileSync(cloud, copy);
assert.deepEqual(await ask(`SELECT count(*) FROM alidade_points('${copy}')`), [[20000]]);
const prepared = await connection.prepare(`SELECT count(*) FROM alidade_points('${copy}')`);
fs.writeFileSync(copy, 'no cloud');
await assert.rejects(prepared.runAndReadAll(), /has changed since it was opened/);
await rejected(`alidade_points('${copy}')`, /copy\.las/);
console.log(`the extension has ${found} rows that SQLite has`);
