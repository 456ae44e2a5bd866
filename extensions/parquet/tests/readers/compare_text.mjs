// SPDX-License-Identifier: MIT
// compare_text.mjs FILE.parquet FILE.csv: positions, classes and times by id are those that `alidade convert` writes as text.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { asyncBufferFromFile, parquetReadObjects } from 'hyparquet';
import { compressors } from 'hyparquet-compressors';

const [file, csv] = process.argv.slice(2);
const [head, ...lines] = fs.readFileSync(csv, 'utf8').trimEnd().split('\n').map((line) => line.split(','));
const rows = await parquetReadObjects({ file: await asyncBufferFromFile(file), compressors });
assert.equal(rows.length, lines.length);
for (const row of rows) {
  const line = lines[Number(row.id)];
  for (const name of ['x', 'y', 'z', 'classification', 'gps_time', 'point_source_id']) {
    // Text has the decimals of the lattice.
    const text = Number(line[head.indexOf(name)]);
    if (!(Math.abs(row[name] - text) < 1e-8)) assert.fail(`${name} of row ${row.id} is ${row[name]}; expected ${text}`);
  }
}
