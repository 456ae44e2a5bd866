#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# A cloud on three servers of its own, and one that asks them: run_shards.sh EXTENSION_FOLDER PG_CONFIG PROGRAM
# What is typed is what the plan's README.txt says.
set -euo pipefail
extension=$(realpath -- "$1") program=$(realpath -- "$3")
cd -- "$(dirname -- "$0")"
source private_cluster.sh
source expect.sh
export LC_ALL=C PGOPTIONS='' PGUSER=postgres
cluster_begin "$extension" "$2"

# expect_part NAME PATTERN COUNT TEXT: the pattern stands in so many lines
expect_part() { expect "$1: $2" "$3" "$(grep -c -E -e "$2" <<<"$4" || true)"; }

read -r -a ports < <(python3 -c '
import socket
sockets = [socket.create_server(("127.0.0.1", 0)) for _ in range(3)]
print(*[one.getsockname()[1] for one in sockets])')
shards=()
for i in 1 2 3; do
  cluster_start "shard_$i" "listen_addresses = '127.0.0.1'" "port = ${ports[i - 1]}"
  shards+=("127.0.0.1:${ports[i - 1]}/postgres")
done
cluster_start coordinator
coordinator=$(cluster_of coordinator)
ask() { psql -X -A -t -q "$coordinator" -c "$1" 2>&1; }
on_shard() { psql -X -A -t -q -h 127.0.0.1 -p "${ports[$1 - 1]}" -d postgres -c "$2" 2>&1; }

folder=$cluster_folder/work
mkdir "$folder"
cd "$folder"
"$program" generate courtyard --points 60000 --seed 3 -o yard.las -q
"$program" sql shard-plan yard.las --shard "${shards[@]}" -o plan -q
cd plan
grep -q -- "psql -h 127.0.0.1 -p ${ports[2]} -d postgres -f shard_3.sql" README.txt || expect 'README.txt' 'a command for each shard' "$(cat README.txt)"
for i in 1 2 3; do psql -X -h 127.0.0.1 -p "${ports[i - 1]}" -d postgres -f "shard_$i.sql"; done
psql -X "$coordinator" -f coordinator.sql
# The same points in one table, which nothing is pruned of.
for i in 1 2 3; do
  if ((i == 1)); then ask 'CREATE TABLE whole (LIKE points)'; fi
  psql -X -q "$coordinator" -c "\\copy whole FROM 'shard_$i.copy' (FORMAT binary)"
done

for i in 1 2 3; do expect "rows of shard $i" 20000 "$(on_shard "$i" 'SELECT count(*) FROM points')"; done
expect 'all points, each once' '60000|0|59999|60000' "$(ask 'SELECT count(*), min(id), max(id), count(DISTINCT id) FROM points')"
expect 'points as the file has them' '' \
  "$(ask 'SELECT * FROM whole EXCEPT SELECT * FROM points')"

line='690010,5325010,602, 1,0.3,0, x,y,z'
near="dist_ray($line) <= 1"
plan=$(ask "EXPLAIN (VERBOSE, COSTS OFF) SELECT * FROM points WHERE $near")
expect_part 'shards work at the same time' 'Async Foreign Scan' 3 "$plan"
expect_part 'conditions are for the shards' 'Remote SQL: .* WHERE .*<@' 3 "$plan"
expect_part 'they use their indexes' 'Bitmap Index Scan' 1 "$(on_shard 1 "EXPLAIN SELECT * FROM points WHERE $near")"
expect 'not every point' t "$(ask "SELECT count(*) BETWEEN 30 AND 6000 FROM points WHERE $near")"
same() { expect "$1" "$(ask "SELECT $2 FROM whole $3")" "$(ask "SELECT $2 FROM points $3")"; }
rows='count(*), sum(id), sum(intensity), sum(gps_time::numeric), min(x), max(z)'
same 'ray' "$rows" "WHERE $near"
same 'half-line' "$rows" "WHERE $near AND dist_plane($line) >= 0"
same 'slab' "$rows" "WHERE dist_plane($line) BETWEEN -1 AND 2.5"
same 'two rays' "$rows" "WHERE $near OR dist_ray(690000,5325000,700, 0,0.1,-1, x,y,z) < 1"
same 'not' "$rows" "WHERE NOT ($near)"
same 'nearest' 'id' "ORDER BY dist_ray($line), id LIMIT 10"
rays="(SELECT 689950 + 10 * i AS ox, 5324980 + 7 * i AS oy, 601 + i AS oz, sin(i) AS dx, cos(i) AS dy, 0.01 * i AS dz
       FROM generate_series(1, 10) AS i) AS r ON dist_ray(r.ox,r.oy,r.oz, r.dx,r.dy,r.dz, x,y,z) <= 1"
same 'join with rays' "$rows" "AS p JOIN $rays"
expect 'join has rows' t "$(ask "SELECT count(*) > 100 FROM points AS p JOIN $rays")"

# Each shard adds up its own points where a statement names it, and sends one row.
by_shard=''
for i in 1 2 3; do
  by_shard+="${by_shard:+ UNION ALL }SELECT count(*) AS points, sum(intensity) AS sum FROM points_shard_$i WHERE $near"
done
plan=$(ask "EXPLAIN (VERBOSE, COSTS OFF) SELECT sum(points) FROM ($by_shard) AS shards")
expect_part 'shards add up' 'Remote SQL: SELECT count\(\*\).*<@' 3 "$plan"
expect 'sums of shards' "$(ask "SELECT count(*), sum(intensity) FROM whole WHERE $near")" \
  "$(ask "SELECT sum(points), sum(sum) FROM ($by_shard) AS shards")"

# The table over all shards is a cloud of the program, as the file is.
cloud="postgresql://postgres@/postgres?host=$cluster_folder/coordinator&table=points"
"$program" convert "$cloud" -o ../again.las -q
expect 'the same file again' '' "$(cmp ../yard.las ../again.las 2>&1)"
query() { "$program" query "$1" --ray 690000,5325000,601,1,0.2,0 --radius 1 -q; }
expect 'the same answers' "$(query ../yard.las)" "$(query "$cloud")"

# Each shard says when it began and ended; all must have begun before any ended.
for i in 1 2 3; do
  on_shard "$i" 'CREATE VIEW slow AS SELECT began, clock_timestamp() AS ended FROM
    (SELECT clock_timestamp() AS began, pg_sleep(1.5) OFFSET 0) AS work'
  ask "CREATE FOREIGN TABLE slow_$i(began timestamptz, ended timestamptz) SERVER points_shard_$i OPTIONS (table_name 'slow')"
done
expect 'shards overlap in time' t "$(ask 'SELECT max(began) < min(ended) FROM (SELECT * FROM slow_1 UNION ALL SELECT * FROM slow_2 UNION ALL SELECT * FROM slow_3) AS s')"

# Rows do not go astray, and a shard takes no points of another.
expect_part 'the parent keeps no rows' 'violates check constraint "no_rows_here"' 1 "$(ask 'INSERT INTO points SELECT * FROM whole LIMIT 1')"
expect_part 'a shard keeps its box' 'violates check constraint "box"' 1 \
  "$(on_shard 1 'INSERT INTO points(id, x, y, z) VALUES(1, 0, 0, 0)')"
expect_part 'scripts run as a whole or not at all' 'already exists' 1 \
  "$(psql -X -h 127.0.0.1 -p "${ports[0]}" -d postgres -f shard_1.sql 2>&1 || true)"
expect 'a shard is filled once' 20000 "$(on_shard 1 'SELECT count(*) FROM points')"

# Whatever attributes are called, and however the client reads letters, a script does what it says.
printf 'x,y,z,name\xc3\x81,\\! touch pwned #\n1,2,3,4,5\n2,3,4,5,6\n' >names.csv
"$program" sql shard-plan names.csv --table names --shard "${shards[0]}" -o names -q
(cd names && PGCLIENTENCODING=SJIS psql -X -q -h 127.0.0.1 -p "${ports[0]}" -d postgres -f shard_1.sql)
expect 'a name that looks like a command' '' "$(find . -name pwned)"
expect 'names of columns' "id x y z nameÁ \\! touch pwned #" \
  "$(PGCLIENTENCODING=UTF8 on_shard 1 "SELECT string_agg(attname, ' ' ORDER BY attnum) FROM pg_attribute WHERE attrelid = 'names'::regclass AND attnum > 0")"

cluster_stop shard_3
broken=$(ask "SELECT count(*) FROM points WHERE $near" || true)
expect_part 'a shard that is down' 'could not connect to server "points_shard_3"' 1 "$broken"
expect 'the other shards' 20000 "$(on_shard 2 'SELECT count(*) FROM points')"
third=$(grep -o "y >= '[^']*'" shard_3.sql | tr -d "y >='")
# Places that the third shard's CHECK excludes need it not.
same "places that only others have" "$rows" "WHERE y < $third"
expect "there are such places" t "$(ask "SELECT count(*) > 100 FROM points WHERE y < $third")"
cluster_start shard_3
same 'a shard that is there again' "$rows" "WHERE $near"

if ((failures > 0)); then exit 1; fi
echo "all as expected"
