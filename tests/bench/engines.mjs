// SPDX-License-Identifier: MIT
// engines.mjs ALIDADE CLOUD FILE.parquet REPETITIONS: what DuckDB and DataFusion read of a Parquet file for the paper's statements, with the
// conditions that `alidade sql rewrite` adds and without. Prints JSON. Modules beside it: those of extensions/parquet/tests/readers.
import { execFileSync } from 'node:child_process';
import { asyncBufferFromFile, parquetMetadataAsync } from 'hyparquet';
import { DuckDBInstance } from '@duckdb/node-api';
import { dataFusion } from './datafusion.mjs';

const [alidade, cloud, parquet, repetitions] = process.argv.slice(2);
const questions = [
  ['ray along the ground, r = 1 m', 'dist_ray(690000,5325000,601.5, 1,0.2,0, x,y,z) <= 1'],
  ['the same, r = 0.1 m', 'dist_ray(690000,5325000,601.5, 1,0.2,0, x,y,z) <= 0.1'],
  ['diagonal ray, r = 1 m', 'dist_ray(690000,5325000,601.5, 1,1,0, x,y,z) <= 1'],
  ['its half-line', 'dist_ray(690000,5325000,601.5, 1,1,0, x,y,z) <= 1 AND dist_plane(690000,5325000,601.5, 1,1,0, x,y,z) >= 0'],
  ['plumb line, r = 1 m', 'dist_ray(690010,5325010,640, 0,0,-1, x,y,z) <= 1'],
  ['oblique slab of 0.1 m', 'dist_plane(690000,5325000,600, 1,0.3,0.1, x,y,z) BETWEEN 0 AND 0.1'],
];
const rewrite = (dialect, table, condition, ...options) =>
  execFileSync(alidade, ['sql', 'rewrite', '--dialect', dialect, '-q', ...options, `SELECT count(*) FROM ${table} WHERE ${condition}`])
    .toString().trim().slice(0, -1);

const metadata = await parquetMetadataAsync(await asyncBufferFromFile(parquet));
const offsets = metadata.row_groups.map((group) => {
  const { dictionary_page_offset: dictionary, data_page_offset: data } = group.columns[0].meta_data;
  return Number(dictionary ?? data);
});

const connection = await (await DuckDBInstance.create()).connect();
await connection.run('SET threads = 1');
async function askDuckDB(statement) {
  const times = [];
  let rows;
  for (let i = 0; i < Number(repetitions); ++i) {
    const begin = process.hrtime.bigint();
    rows = Number((await connection.runAndReadAll(statement)).getRows()[0][0]);
    times.push(Number(process.hrtime.bigint() - begin) / 1e6);
  }
  const plan = (await connection.runAndReadAll(`EXPLAIN (ANALYZE, FORMAT json) ${statement}`)).getRows()[0][1];
  let emitted = 0;
  const visit = (operator) => {
    if (/SCAN/.test(operator.operator_name ?? '')) emitted += operator.operator_cardinality;
    (operator.children ?? []).forEach(visit);
  };
  visit(JSON.parse(plan));
  return { rows, ms: times.sort((a, b) => a - b)[times.length >> 1], emitted };
}

const { query, reads } = await dataFusion(parquet);
async function askDataFusion(statement) {
  await query(statement);
  reads.length = 0;
  const begin = process.hrtime.bigint();
  const rows = Number((await query(statement))[0][0]);
  const ms = Number(process.hrtime.bigint() - begin) / 1e6;
  const bytes = reads.reduce((sum, [first, end]) => sum + end - first, 0);
  // By where their first column begins: ranges may be joined.
  const groups = offsets.filter((offset, number) =>
    reads.some(([first, end]) => first <= (offsets[number + 1] ?? metadata.metadata_offset ?? Infinity) - 1 && end > offset)).length;
  return { rows, ms, bytes, groups };
}

const answers = [];
for (const [name, condition] of questions) {
  const answer = { name, condition, duckdb: {}, datafusion: {} };
  for (const [form, options] of [['plain', []], ['pruned', ['--bounds', cloud]]]) {
    answer.duckdb[form] = await askDuckDB(rewrite('duckdb', `'${parquet}'`, condition, ...options));
    answer.datafusion[form] = await askDataFusion(rewrite('datafusion', 'p', condition, ...options));
  }
  answers.push(answer);
}
console.log(JSON.stringify({ points: Number(metadata.num_rows), groups: metadata.row_groups.length, bytes: (await asyncBufferFromFile(parquet)).byteLength, answers }));
