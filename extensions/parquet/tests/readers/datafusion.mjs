// SPDX-License-Identifier: MIT
// DataFusion in Node: the package datafusion-wasm, its object store answered from a local file.
import fs from 'node:fs';
import { createRequire } from 'node:module';

const wasm = createRequire(import.meta.url).resolve('datafusion-wasm/datafusion_wasm_bg.wasm');
const glue = await import(wasm.replace('.wasm', '.js'));
const compiled = await WebAssembly.compile(fs.readFileSync(wasm));
const imports = Object.fromEntries(WebAssembly.Module.imports(compiled).map(({ module }) => [module, glue]));
const instance = await WebAssembly.instantiate(compiled, imports);
glue.__wbg_set_wasm(instance.exports);
instance.exports.__wbindgen_start?.();

// Bodies must be streams of bytes, and responses must have their URL, or the module panics.
const stream = (bytes) =>
  new ReadableStream({
    type: 'bytes',
    start(controller) {
      if (bytes.length > 0) controller.enqueue(new Uint8Array(bytes));
      controller.close();
    },
  });

function answer(request, content, reads) {
  const about = { 'last-modified': 'Mon, 01 Jan 2024 00:00:00 GMT', etag: '"a"' };
  const range = request.headers.get('range')?.match(/bytes=(\d+)-(\d+)/);
  const [begin, end] = range ? [Number(range[1]), Number(range[2]) + 1] : [0, content.length];
  if (request.method !== 'HEAD') reads.push([begin, end]);
  const bytes = request.method === 'HEAD' ? [] : content.subarray(begin, end);
  const response = new Response(stream(bytes), {
    status: range ? 206 : 200,
    headers: { ...about, 'content-length': String(end - begin), 'content-range': `bytes ${begin}-${end - 1}/${content.length}` },
  });
  return Object.defineProperty(response, 'url', { value: request.url });
}

/// The table `p` of a file. `query(statement)`: its rows as texts. `reads`: ranges of bytes that were read, [first, end).
export async function dataFusion(file) {
  const content = fs.readFileSync(file);
  const reads = [];
  globalThis.fetch = async (request) => answer(request, content, reads);
  const context = glue.DataFusionContext.new();
  context.set_s3_config('/', 'b', 'us-east-1', 'k', 's');
  await context.execute_sql(`create external table p stored as parquet location 's3://b/p.parquet'`);
  return {
    reads,
    async query(statement) {
      const lines = (await context.execute_sql(statement)).split('\n').filter((line) => line.startsWith('|'));
      return lines.slice(1).map((line) => line.slice(1, -1).split('|').map((cell) => cell.trim()));
    },
  };
}
