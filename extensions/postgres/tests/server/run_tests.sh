#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Tests of the extension for PostgreSQL, on a server of their own: run_tests.sh EXTENSION_FOLDER PG_CONFIG [--accept]
# Each sql/NAME.sql runs in a database of its own and must print expected/NAME.out; --accept writes what it printed there.
set -euo pipefail
extension=$(realpath -- "$1")
cd -- "$(dirname -- "$0")"
source private_cluster.sh
export LC_ALL=C PGOPTIONS='' PGTZ=UTC
cluster_begin "$extension" "$2"
accept=${3:-}
cluster_start server
server="host=$cluster_folder/server user=postgres"
export binary_file=$cluster_folder/server/values.bin
failures=0

fail() {
  echo "FAILED: $1" >&2
  failures=$((failures + 1))
}

for file in sql/*.sql; do
  name=$(basename "$file" .sql)
  if [[ $name == site ]]; then continue; fi
  psql -q "$server dbname=postgres" -c "CREATE DATABASE $name"
  psql -X -q "$server dbname=$name" -f "$file" >"$cluster_folder/$name.out" 2>&1 || true
  if [[ $accept == --accept ]]; then cp "$cluster_folder/$name.out" "expected/$name.out"; fi
  diff -u "expected/$name.out" "$cluster_folder/$name.out" || fail "$file"
done

# A table with its indexes survives pg_dump.
pg_dump "$server dbname=nearest" >"$cluster_folder/dump.sql"
psql -q "$server dbname=postgres" -c "CREATE DATABASE restored"
psql -X -q -v ON_ERROR_STOP=1 "$server dbname=restored" -f "$cluster_folder/dump.sql" >/dev/null || fail "restoring a dump"
for database in nearest restored; do
  psql -X -A -t "$server dbname=$database" -c "ANALYZE points" -c "SELECT sum(id), count(*) FROM points WHERE dist_ray(0,100,1.5, 1,0.2,0, x,y,z) <= 1" \
    -c "EXPLAIN (COSTS OFF) SELECT * FROM points WHERE dist_ray(0,100,1.5, 1,0.2,0, x,y,z) <= 1" >"$cluster_folder/$database.rows"
done
grep -q 'Index Cond' "$cluster_folder/restored.rows" || fail "the index of a restored table"
diff "$cluster_folder/nearest.rows" "$cluster_folder/restored.rows" || fail "rows of a restored table"

psql -q "$server dbname=postgres" -c "CREATE DATABASE rays"
python3 -B random_rays.py "$server dbname=rays" || fail "random_rays.py"
psql -q "$server dbname=postgres" -c "CREATE DATABASE malformed"
python3 -B malformed_values.py "$server dbname=malformed" || fail "malformed_values.py"
if grep -E 'PANIC|terminated by signal' "$cluster_folder/server/server.log"; then fail "the server crashed"; fi
if ((failures > 0)); then exit 1; fi
echo "all as expected"
