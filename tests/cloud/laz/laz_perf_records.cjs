// SPDX-License-Identifier: MIT
// node laz_perf_records.cjs PACKAGE (LAZ RECORDS)...: unpacks the points of LAZ files with laz-perf, whose
// folder is PACKAGE, and writes their point data records to files.
const fs = require('fs');
const {createLazPerf} = require(process.argv[2]);

async function main() {
  const lazPerf = await createLazPerf();
  for (let i = 3; i + 1 < process.argv.length; i += 2) {
    const bytes = fs.readFileSync(process.argv[i]);
    const file = lazPerf._malloc(bytes.length);
    lazPerf.HEAPU8.set(bytes, file);
    const points = new lazPerf.LASZip();
    points.open(file, bytes.length);
    const size = points.getPointLength(), count = points.getCount();
    const record = lazPerf._malloc(size);
    const records = Buffer.alloc(size * count);
    for (let row = 0; row < count; ++row) {
      points.getPoint(record);
      // Memory may have moved meanwhile, so it is looked up each time.
      records.set(lazPerf.HEAPU8.subarray(record, record + size), row * size);
    }
    fs.writeFileSync(process.argv[i + 1], records);
    points.delete();
    lazPerf._free(record);
    lazPerf._free(file);
  }
}

main();
