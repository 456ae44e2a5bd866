#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Tables of a server of its own as clouds: run_server_clouds.sh EXTENSION_FOLDER PG_CONFIG PROGRAM
set -euo pipefail
extension=$(realpath -- "$1") program=$(realpath -- "$3")
statements=$(realpath -- "$(dirname -- "$0")/../../../../tests/support/random_statements.py")
cd -- "$(dirname -- "$0")"
source private_cluster.sh
source expect.sh
export LC_ALL=C PGOPTIONS='' PGUSER=postgres PGPASSFILE=/nowhere
unset PGPASSWORD PGHOST PGPORT PGDATABASE
cluster_begin "$extension" "$2"

# expect_part NAME TEXT FOUND: the text stands in it
expect_part() {
  if [[ $3 != *"$2"* ]]; then
    printf 'FAILED: %s\nexpected: ...%s...\nfound:    %s\n' "$1" "$2" "$3" >&2
    failures=$((failures + 1))
  fi
}

# rejected NAME TEXT WORD...: the program ends with 2 and says that
rejected() {
  local name=$1 text=$2 said code=0
  shift 2
  said=$("$program" "$@" 2>&1) || code=$?
  expect "$name: exit code" 2 "$code"
  expect_part "$name" "$text" "$said"
}

cluster_start one
sql() { psql -X -A -t -q "$(cluster_of one)" -v ON_ERROR_STOP=1 -c "$1" 2>&1; }
# table NAME: how the program calls it
table() { echo "postgresql:///postgres?host=$cluster_folder/one&table=$1"; }

folder=$cluster_folder/work
mkdir "$folder"
cd "$folder"
"$program" generate courtyard --points 20000 --seed 3 -o yard.las -q
"$program" sql load yard.las "$(table points)" -q
# A catalog is the files that it lists.
"$program" query yard.las --box -1e9,-1e9,-1e9,690000,1e9,1e9 -o west.las -q
"$program" catalog west.las yard.las -o both.catalog.json -q
"$program" sql load both.catalog.json "$(table of_catalog)" -q
expect 'rows of a catalog' "$("$program" sql both.catalog.json 'SELECT count(*), sum(id) FROM points' --csv -q | tail -1)" \
  "$(sql 'SELECT count(*), sum(id) FROM of_catalog' | tr '|' ,)"

# Of the same points: the file, and the table whether memory holds them or not.
answers() { "$program" query "$1" --ray 690000,5325000,650,0.01,0,-1 --radius 3 --class 2 -q; }
expect 'there are answers' t "$([[ $(answers yard.las | wc -l) -gt 10 ]] && echo t)"
expect 'answers' "$(answers yard.las)" "$(answers "$(table points)")"
# What targets do not need stays on the server, and answers are the same to the last digit.
box=689990,5324990,600,690010,5325010,605
plane="690000,5325000,601,0.3,1,0.1"
for target in '--ray 690000,5325000,650,0.01,0,-1 --radius 1' '--ray 690000,5325000,601,1,0.2,0,-5,20 --radius 0.5' \
  '--ray 690000,5325000,601,1e-200,0,0 --ray 690000,5325000,601,0,0,-1 --radius 2' '--cone 690000,5325000,602,1,0,0,2' \
  "--box $box" "--plane $plane --plane 690000,5325000,601,-1,0,0" '--point 690003.25,5325004,600 --radius 4' \
  '--vertex 690000,5325000,601 --vertex 690020,5325010,602 --vertex 690020,5325000,602 --radius 1' \
  '--ray 0,0,0,0,0,1 --radius 1' '--box 0,0,0,1,1,1'; do
  read -r -a words <<<"$target"
  expect "$target" "$("$program" query yard.las "${words[@]}" -q)" "$("$program" query "$(table points)" "${words[@]}" -q)"
  read -r _ _ read_count < <("$program" query "$(table points)" "${words[@]}" --explain 2>&1 >/dev/null | grep '^points read')
  expect "$target: few points are read" t "$([[ ${read_count:-20000} -lt 12000 ]] && echo t)"
done
many=()
for i in {1..70}; do many+=(--point "$((689960 + i)),5325000,600"); done
expect 'more targets than conditions' "$("$program" query yard.las "${many[@]}" --radius 2 -q)" \
  "$("$program" query "$(table points)" "${many[@]}" --radius 2 -q)"
# The paper's statements have the answers that SQLite gives.
"$program" sql load yard.las yard.db -q
"$statements" sums 200 >sums.sql
rounded() { awk -F, '{ for (i = 1; i <= NF; ++i) printf "%s ", $i == "" ? "" : sprintf("%.12g", $i); print "" }'; }
expect 'random statements' "$("$program" sql yard.db --csv -f sums.sql | grep -v '^n,' | rounded)" \
  "$(psql -X -A -t -q -F, "$(cluster_of one)" -v ON_ERROR_STOP=1 -f sums.sql 2>&1 | rounded)"
"$program" sql rewrite --dialect postgres --bounds yard.las -f sums.sql -q >plain.sql
expect 'no function of ours is left' 0 "$(grep -c dist_ plain.sql)"
expect 'rewritten statements' "$(psql -X -A -t -q -F, "$(cluster_of one)" -f sums.sql)" \
  "$(psql -X -A -t -q -F, "$(cluster_of one)" -v ON_ERROR_STOP=1 -f plain.sql 2>&1)"
cat >camera.json <<'TEXT'
{"version": 1, "model": "pinhole", "width": 60, "height": 40, "intrinsics": {"horizontal_fov": 40},
 "pose": {"look_at": {"eye": [689975, 5324975, 603], "target": [689985, 5324985, 601]}}}
TEXT
view() {
  "$program" render --cloud "$(table points)" --camera camera.json --radius 0.2 --color rgb --samples 2 --mode flat \
    -o "$1.png" -q "${@:2}"
}
view whole
view part --in-view
expect_part 'what the camera sees' '"max_abs": 0.0' "$("$program" compare whole.png part.png --json -q)"
"$program" convert "$(table points)" -o server.las -q
expect 'the same file again' '' "$(cmp yard.las server.las 2>&1)"
"$program" sql load "$(table points)" server.db --memory 1M -q
"$program" convert server.db -o pieces.las -q
expect 'the same file from pieces' '' "$(cmp yard.las pieces.las 2>&1)"
picture() { "$program" render --cloud "$1" --size 40x30 --samples 1 -o "$2.png" -q && "$program" compare "$2.png" file.png -q >/dev/null; }
"$program" render --cloud yard.las --size 40x30 --samples 1 -o file.png -q
expect 'the same picture' yes "$(picture "$(table points)" server && echo yes)"
# A scene file names a server as it is, and not a file beside it.
cat >scene.json <<TEXT
{"version": 1, "cloud": {"file": "$(table points)"}}
TEXT
"$program" render scene.json --camera camera.json --radius 0.2 --samples 1 -o scene.png -q
"$program" info "$(table points)" >info.txt
for text in "points      20000" "CRS         WGS 84 / UTM zone 32N" "PostgreSQL 1"; do expect_part info "$text" "$(cat info.txt)"; done
expect 'the index' 1 "$(sql "SELECT count(*) FROM pg_indexes WHERE tablename = 'points' AND indexdef LIKE '%brin (cloud_point(x, y, z))%'")"

# A table is there as a whole or not at all, and only clouds are replaced.
rejected 'a table that is there' 'the table points exists' sql load yard.las "$(table points)"
"$program" sql load yard.las "$(table points)" --overwrite -q
expect 'it was replaced' 20000 "$(sql 'SELECT count(*) FROM points')"
sql 'CREATE TABLE wages(x int)'
rejected 'a table that is no cloud' 'expected a cloud with the table' sql load yard.las "$(table wages)" --overwrite
expect 'it stays' wages "$(sql "SELECT relname FROM pg_class WHERE relname = 'wages'")"
"$program" generate courtyard --points 400000 --seed 3 -o large.las -q
# The server is slow, so that there is time to end the program while it stores.
cluster_tables() { sql "SELECT count(*) FROM pg_class WHERE relname LIKE 'large%'"; }
for signal in INT KILL; do
  "$program" sql load large.las "$(table large)" -q 2>said.txt &
  loader=$!
  until [[ $(sql "SELECT count(*) FROM pg_stat_activity WHERE query LIKE 'COPY%FROM STDIN%' AND pid <> pg_backend_pid()") != 0 ]]; do
    if ! kill -0 "$loader" 2>/dev/null; then break; fi
  done
  kill -"$signal" "$loader" 2>/dev/null || true
  code=0
  wait "$loader" 2>/dev/null || code=$?
  if [[ $signal == INT ]]; then expect 'exit code of Ctrl-C' 130 "$code"; else expect 'exit code of KILL' 137 "$code"; fi
  until [[ $(sql "SELECT count(*) FROM pg_stat_activity WHERE application_name = 'alidade'") == 0 ]]; do sleep 0.05; done
  expect "nothing is left after $signal" 0 "$(cluster_tables)"
done

# Tables of other people.
sql 'CREATE TABLE "Mixed Case"("x" real, y int, z numeric(8,2), intensity int, class text, height int, share real);
     INSERT INTO "Mixed Case" SELECT i, i * 2, i / 4.0, i, $$a$$, CASE WHEN i % 2 = 0 THEN i END, i / 8.0 FROM generate_series(1, 9) AS i;
     INSERT INTO "Mixed Case" VALUES ($$NaN$$, 1, 1), (1, NULL, 1), ($$Infinity$$, 1, 1)'
"$program" sql load "$(table 'Mixed%20Case')" mixed.db 2>said.txt
expect_part 'rows without places' 'skipped 3 points without finite coordinates' "$(cat said.txt)"
expect_part 'texts' 'skipped columns that are not numeric: class' "$(cat said.txt)"
expect 'numbers of all types, and none' $'x,y,z,intensity,height,share\n1.0,2.0,0.25,1,,0.125\n2.0,4.0,0.5,2,2,0.25' \
  "$("$program" sql mixed.db 'SELECT x, y, z, intensity, height, share FROM points ORDER BY id LIMIT 2' --csv)"
expect 'all rows with a place' 9 "$("$program" sql mixed.db 'SELECT count(*) FROM points' --csv | tail -1)"
expect_part 'attributes' 'attributes  intensity' "$("$program" info "$(table 'Mixed%20Case')" 2>/dev/null)"

# Rows are in the order of ids only where these number them.
sql 'CREATE TABLE shuffled AS SELECT * FROM points ORDER BY md5(id::text);
     CREATE TABLE shifted AS SELECT id + 1 AS id, x, y, z FROM points;
     CREATE TABLE twice AS SELECT CASE WHEN id = 5 THEN 6 ELSE id END AS id, x, y, z FROM points'
expect 'rows by their ids' "$(answers yard.las | cut -d, -f1)" "$(answers "$(table shuffled)" | cut -d, -f1)"
for other in shifted twice; do
  expect_part "$other: ids are a dimension" 'id' "$("$program" info "$(table "$other")" 2>/dev/null | grep '^extra')"
done

# Names are names, whatever is in them.
evil="a'; DROP TABLE points; --\""
"$program" sql load yard.las "$(table "a'; DROP TABLE points; --%22")" -q
expect 'an evil name' 20000 "$(psql -X -A -t -q "$(cluster_of one)" -v name="$evil" <<<'SELECT count(*) FROM :"name"')"
expect 'its points' "$(answers yard.las)" "$(answers "$(table "a'; DROP TABLE points; --%22")")"
expect 'nothing was dropped' 20000 "$(sql 'SELECT count(*) FROM points')"
sql 'CREATE SCHEMA "other schema"'
"$program" sql load yard.las "$(table points)&schema=other%20schema" -q
expect 'a schema' 20000 "$(sql 'SELECT count(*) FROM "other schema".points')"
rejected 'a schema that is not there' 'unknown table' info "$(table points)&schema=nowhere"

# What cannot be read is said.
rejected 'unknown table' 'unknown table; found' info "$(table nothing)"
rejected 'no table is named' 'ambiguous table' info "postgresql:///postgres?host=$cluster_folder/one"
rejected 'no such database' 'database "nothing" does not exist' info "postgresql:///nothing?host=$cluster_folder/one&table=points"
rejected 'no server' 'cannot connect to the server' info 'postgresql://127.0.0.1:1/postgres?table=points'
rejected 'no coordinates' 'missing numeric column y; expected x, y and z, found x' info "$(table wages)"
sql "CREATE TABLE words(x text, y text, z text); CREATE TABLE bright AS SELECT 1 AS x, 2 AS y, 3 AS z, 70000 AS intensity"
rejected 'a table of texts' 'missing numeric column x' info "$(table words)"
rejected 'a value that cannot be' 'row 1: intensity out of range for the attribute; expected 0 to 65535, found 70000' \
  convert "$(table bright)" -o bright.las
rejected 'a view that fails' 'division by zero' info "$(sql 'CREATE VIEW broken AS SELECT x, y, z / 0 AS z FROM bright'; table broken)"
sql 'INSERT INTO points SELECT * FROM points WHERE id = 1'
rejected 'more points than there were' 'expected 20000, found 20001' convert "$(table points)" -o more.las
sql 'CREATE TABLE empty(x real, y real, z real)'
expect_part 'no points' 'points      0' "$("$program" info "$(table empty)" 2>&1)"

# Passwords are asked of files and the environment only, and never told.
for name in 'postgresql://me:geheim@127.0.0.1:1/db?table=points' 'postgresql:///db?table=points&password=geheim' \
  'postgresql:///db?table=points&p%61ssword=geheim' 'postgresql://me%3Ageheim@h/db?table=points' \
  'postgresql:///db?sslpassword=geheim&table=points' 'postgresql://me:ge?heim@h/db?table=points'; do
  for words in "info $name" "$name" "render --cloud=$name -o a.png" "sql load yard.las $name" "info --nothing $name"; do
    read -r -a all <<<"$words"
    said=$("$program" "${all[@]}" 2>&1) && code=0 || code=$?
    expect "$words: exit code" 2 "$code"
    if [[ $said == *heim* ]]; then expect "$words" 'no password' "$said"; fi
  done
done
rejected 'a password in a name' 'expected the password in ~/.pgpass, PGPASSFILE or PGPASSWORD' info 'postgresql://me:geheim@h/db?table=points'

cluster_stop one
rejected 'a server that is down' 'cannot connect to the server' info "$(table points)"

if ((failures > 0)); then exit 1; fi
echo "all as expected"
