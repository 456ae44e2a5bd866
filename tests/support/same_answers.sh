#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# same_answers.sh OLD NEW [SHARED_DATA]: runs a fixed list of commands with two builds of the program and compares exit
# codes, standard output and every file that is written, byte for byte. Messages (standard error) may differ: differences
# are shown, and count only with --messages as the first argument. Exits with 1 if anything else differs.
set -euo pipefail
messages=no
if [[ ${1:-} == --messages ]]; then messages=yes && shift; fi
if (($# < 2)); then echo "usage: same_answers.sh [--messages] OLD NEW [SHARED_DATA]" >&2 && exit 2; fi
old=$(readlink -f -- "$1")
new=$(readlink -f -- "$2")
data=${3:+$(readlink -f -- "$3")}
list=$(dirname -- "$(readlink -f -- "$0")")/same_answers.txt
scenes=$(dirname -- "$(readlink -f -- "$0")")/../../scenes
work=$(mktemp -d)
trap 'rm -rf -- "$work"' EXIT
export SCENES="$work/scenes" DATA="$data"
cp -r -- "$scenes" "$SCENES"

# run_all PROGRAM: every command of the list in $work/site, whose files then stay in there
run_all() {
  local number=0 command
  mkdir "$work/site" "$work/bin"
  ln -s "$1" "$work/bin/alidade"
  cd "$work/site"
  while IFS= read -r command; do
    number=$((number + 1))
    if [[ $command == *'$DATA'* && -z $data ]]; then continue; fi
    local code=0
    PATH="$work/bin:$PATH" bash -c "$command" >"out_$number.txt" 2>"messages_$number.txt" </dev/null || code=$?
    echo "$code" >"code_$number.txt"
  done < <(grep -v -e '^#' -e '^$' "$list")
  cd "$work"
  rm -r "$work/bin"
}

run_all "$old"
mv "$work/site" "$work/old"
run_all "$new"
mv "$work/site" "$work/new"

different=0 said=0 skipped=0 number=0
while IFS= read -r command; do
  number=$((number + 1))
  if [[ ! -f $work/old/code_$number.txt ]]; then skipped=$((skipped + 1)) && printf 'skipped  %s\n' "$command" && continue; fi
  result=same
  for part in code out; do
    cmp -s "$work/old/${part}_$number.txt" "$work/new/${part}_$number.txt" || result=DIFFERS
  done
  if [[ $result == DIFFERS ]]; then different=$((different + 1)); fi
  printf '%-8s %s  %s\n' "$result" "$(<"$work/old/code_$number.txt")" "$command"
  # Times differ between any two runs.
  for run in old new; do sed -E 's/[0-9.]+ m?s\b/TIME/g' "$work/$run/messages_$number.txt" >"$work/$run.messages"; done
  if ! diff "$work/old.messages" "$work/new.messages" >"$work/difference"; then
    said=$((said + 1))
    echo "         messages differ:"
    sed -n '1,6s/^/           /p' "$work/difference"
  fi
done < <(grep -v -e '^#' -e '^$' "$list")
while IFS= read -r file; do
  if ! cmp -s "$work/old/$file" "$work/new/$file"; then different=$((different + 1)) && echo "DIFFERS  file $file"; fi
done < <(cd "$work" && find old new -type f ! -name 'messages_*' ! -name 'out_*' ! -name 'code_*' | sed 's,^[^/]*/,,' | sort -u)
files=$(find "$work/old" -type f ! -name 'messages_*' ! -name 'out_*' ! -name 'code_*' | wc -l)
echo "$number commands, $skipped skipped, $files files written; $different differences, $said with other messages"
if ((different > 0)) || [[ $messages == yes && $said -gt 0 ]]; then exit 1; fi
