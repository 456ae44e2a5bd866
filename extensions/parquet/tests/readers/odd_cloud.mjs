// SPDX-License-Identifier: MIT
// odd_cloud.mjs FILE.las: a cloud with extra dimensions of all types, with scale, offset and marks for no value, extreme numbers,
// NaN, zeros of both signs, undocumented bytes, and names that need quotes.
import fs from 'node:fs';

// Types of LAS 1.4, table "extra bytes descriptor": number, bytes, how a value is put.
const types = {
  uint8: [1, 1, 'setUint8'], int8: [2, 1, 'setInt8'], uint16: [3, 2, 'setUint16'], int16: [4, 2, 'setInt16'],
  uint32: [5, 4, 'setUint32'], int32: [6, 4, 'setInt32'], uint64: [7, 8, 'setBigUint64'], int64: [8, 8, 'setBigInt64'],
  float: [9, 4, 'setFloat32'], double: [10, 8, 'setFloat64'],
};
const cycle = (values) => (row) => values[row % values.length];
const dimensions = [
  { name: 'u8', type: 'uint8', value: (row) => row & 255 },
  { name: 'i8', type: 'int8', value: cycle([-128, 127, 0, -1]) },
  { name: 'u16', type: 'uint16', value: (row) => (row * 40503) & 65535 },
  { name: 'i16', type: 'int16', value: cycle([-32768, 32767, 5]) },
  { name: 'u32', type: 'uint32', value: cycle([4294967295, 0, 2147483648, 7]) },
  { name: 'i32', type: 'int32', value: cycle([-2147483648, 2147483647, 1, -1, 0]) },
  { name: 'u64', type: 'uint64', value: cycle([18446744073709551615n, 0n, 9007199254740993n]) },
  { name: 'i64', type: 'int64', value: cycle([-9223372036854775808n, 9223372036854775807n, 9007199254740993n]) },
  { name: 'i64 rising', type: 'int64', value: (row) => BigInt(row) * 1000003n - 5n },
  { name: 'f', type: 'float', value: cycle([0.1, -0, 0, 1e-30, -3.5e38]) },
  { name: 'd', type: 'double', value: (row) => Math.sin(row) * 1e6 },
  { name: 'zeros', type: 'double', value: cycle([0, 0, -0]) },
  { name: 'negative zero', type: 'float', value: () => -0 },
  { name: 'NaN', type: 'float', value: (row) => (row % 1000 === 7 ? NaN : row / 3) },
  { name: 'scaled', type: 'int32', scale: 0.01, offset: 100, value: (row) => row * 7 - 900 },
  { name: 'no value', type: 'int16', noData: -9999, value: (row) => (row % 5 === 0 ? -9999 : row & 1023) },
  { name: 'no scaled', type: 'uint16', scale: 0.5, noData: 65535, value: (row) => (row < 40000 ? 65535 : row & 4095) },
  { name: 'no NaN', type: 'double', noData: NaN, value: (row) => (row % 3 === 0 ? NaN : row * 0.1) },
  { name: 'nothing', type: 'uint8', noData: 255, value: () => 255 },
  { name: 'quote " and \' é 点', type: 'uint8', value: (row) => row % 3 },
  { name: 'CLASSIFICATION', type: 'uint8', value: (row) => row % 7 },
  { name: 'raw', bytes: 3, value: (row) => [row & 255, 0, row >> 8 & 255] },
];

const count = 70000;
const head = 375, record = 30, descriptor = 192;
const extra = dimensions.reduce((sum, { type, bytes }) => sum + (bytes ?? types[type][1]), 0);
const points = head + 54 + descriptor * dimensions.length;
const file = new DataView(new ArrayBuffer(points + count * (record + extra)));
const text = (at, characters) => Buffer.from(file.buffer).write(characters, at, 'utf8');
text(0, 'LASF');
file.setUint16(6, 0, true);
file.setUint8(24, 1);
file.setUint8(25, 4);
file.setUint16(94, head, true);
file.setUint32(96, points, true);
file.setUint32(100, 1, true);
file.setUint8(104, 6);
file.setUint16(105, record + extra, true);
for (let axis = 0; axis < 3; ++axis) {
  file.setFloat64(131 + 8 * axis, 0.001, true);
  file.setFloat64(155 + 8 * axis, [500000, 5000000, 0][axis], true);
}
file.setBigUint64(247, BigInt(count), true);
text(head + 2, 'LASF_Spec');
file.setUint16(head + 18, 4, true);
file.setUint16(head + 20, descriptor * dimensions.length, true);
dimensions.forEach(({ name, type, bytes, scale, offset, noData }, number) => {
  const at = head + 54 + descriptor * number;
  const put = { int16: 'setBigInt64', uint8: 'setBigUint64', uint16: 'setBigUint64', double: 'setFloat64' }[type];
  file.setUint8(at + 2, bytes === undefined ? types[type][0] : 0);
  file.setUint8(at + 3, bytes ?? (noData !== undefined ? 1 : 0) + (scale ? 8 : 0) + (offset ? 16 : 0));
  text(at + 4, name);
  if (noData !== undefined) file[put](at + 40, put === 'setFloat64' ? noData : BigInt(noData), true);
  if (scale) file.setFloat64(at + 112, scale, true);
  if (offset) file.setFloat64(at + 136, offset, true);
});
// Header: box of the points, which lie on a grid of 300 columns.
const last = Math.floor((count - 1) / 300);
[[299 * 0.01 + 500000, 500000], [last * 0.01 + 5000000, 5000000], [0.099, 0]].forEach(([greatest, least], axis) => {
  file.setFloat64(179 + 16 * axis, greatest, true);
  file.setFloat64(187 + 16 * axis, least, true);
});
for (let row = 0; row < count; ++row) {
  let at = points + row * (record + extra);
  file.setInt32(at, 10 * (row % 300), true);
  file.setInt32(at + 4, 10 * Math.floor(row / 300), true);
  file.setInt32(at + 8, row % 100, true);
  file.setUint8(at + 14, 0x11);
  file.setUint8(at + 16, 2);
  file.setFloat64(at + 22, row / 1024, true);
  at += record;
  for (const { type, bytes, value } of dimensions) {
    if (bytes !== undefined) value(row).forEach((byte, i) => file.setUint8(at + i, byte));
    else file[types[type][2]](at, value(row), true);
    at += bytes ?? types[type][1];
  }
}
fs.writeFileSync(process.argv[2], new Uint8Array(file.buffer));
