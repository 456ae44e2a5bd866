# SPDX-License-Identifier: MIT
# Servers of PostgreSQL for tests and benchmarks, with the extension just built, which touch nothing outside a temporary
# folder. To be sourced.
#
#   cluster_begin EXTENSION_FOLDER PG_CONFIG   # EXTENSION_FOLDER has alidade_pg.so, alidade_pg.control and alidade_pg--*.sql
#   cluster_start NAME [SETTING=VALUE...]      # as many as needed; each listens only on a socket in $cluster_folder/NAME
#   psql $(cluster_of NAME) -c ...
#   cluster_stop NAME                          # at once, as if it had crashed
#
# When the shell ends all are stopped and the folder is removed. PostgreSQL refuses to run as root: then the servers run
# as nobody. Clients may run as anybody.

cluster_begin() {
  local extension=$1 pg_config=$2 bin lib share
  bin=$("$pg_config" --bindir)
  lib=$("$pg_config" --pkglibdir)
  share=$("$pg_config" --sharedir)
  cluster_folder=$(mktemp -d "${TMPDIR:-/tmp}/alidade_pg.XXXXXX")
  trap cluster_end EXIT
  PATH=$bin:$PATH

  # A server looks for its libraries and its extensions relative to where its program lies, so a copy of the programs
  # among links to all the rest has an installation of its own.
  local root=$cluster_folder/root
  cluster_bin=$root${bin#/usr}
  mkdir -p "$cluster_bin" "$root${lib#/usr}" "$root${share#/usr}/extension"
  cp "$bin"/{postgres,initdb,pg_ctl} "$cluster_bin"
  ln -s "$lib"/* "$root${lib#/usr}"
  ln -s "$share"/* "$root${share#/usr}" 2>/dev/null || true  # all but the folder extension, which exists
  ln -s "$share"/extension/* "$root${share#/usr}/extension"
  cp -f --remove-destination "$extension"/alidade_pg.so "$root${lib#/usr}"
  cp -f --remove-destination "$extension"/alidade_pg.control "$extension"/alidade_pg--*.sql "$root${share#/usr}/extension"
  chmod 711 "$cluster_folder"
  if ((EUID == 0)); then chown nobody "$cluster_folder"; fi
  cluster_as_user "$cluster_bin/initdb" --no-sync --auth=trust --username=postgres --encoding=UTF8 --locale=C \
    --pgdata "$cluster_folder/empty" >"$cluster_folder/initdb.log" || {
    cat "$cluster_folder/initdb.log" >&2
    return 1
  }
}

# cluster_as_user COMMAND...
cluster_as_user() {
  if ((EUID == 0)); then
    (cd "$cluster_folder" && setpriv --reuid=nobody --regid=nogroup --clear-groups "$@")
  else
    (cd "$cluster_folder" && "$@")
  fi
}

cluster_start() {
  local name=$1 data=$cluster_folder/$1 setting
  shift
  if [[ ! -d $data ]]; then
    cluster_as_user cp -r "$cluster_folder/empty" "$data"
    cluster_as_user tee -a "$data/postgresql.conf" >/dev/null <<TEXT
listen_addresses = ''
unix_socket_directories = '$data'
fsync = off
full_page_writes = off
max_connections = 20
autovacuum = off
jit = off
TEXT
    for setting in "$@"; do echo "$setting"; done | cluster_as_user tee -a "$data/postgresql.conf" >/dev/null
  fi
  cluster_as_user "$cluster_bin/pg_ctl" start --silent --wait --pgdata "$data" --log "$data/server.log" || {
    cat "$data/server.log" >&2
    return 1
  }
}

# cluster_of NAME: how clients name it
cluster_of() { echo "host=$cluster_folder/$1 user=postgres dbname=postgres"; }

cluster_stop() { cluster_as_user "$cluster_bin/pg_ctl" stop --silent --mode immediate --pgdata "$cluster_folder/$1"; }

cluster_end() {
  local data
  for data in "$cluster_folder"/*/postmaster.pid; do
    if [[ -e $data ]]; then cluster_stop "$(basename "$(dirname "$data")")" || true; fi
  done
  rm -rf "$cluster_folder"
}
