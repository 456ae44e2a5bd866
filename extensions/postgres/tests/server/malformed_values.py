# SPDX-License-Identifier: MIT
"""Texts and bytes that are no values, damaged at random: the server rejects them, or takes them and gives back the same.

malformed_values.py CONNECTION: exits with 1 if the server went down, or a value it took does not come back.
"""
import random
import struct
import subprocess
import sys

VALID = {
    "cloud_point": "(1.5,-2e3,NaN)",
    "cloud_ray": "(690000.5,5325000,0,1,0.2,-1e-200)",
    "cloud_plane": "(0,0,0,0,0,1)",
    "cloud_limit": "plane(1,2,3,4,5,6,-Infinity,7)",
    "cloud_box": "(0,0,0,1,1,1)",
    "cloud_distance": "0.125",
}
PIECES = ["(", ")", ",", " ", "-", "NaN", "Infinity", "1e400", "1e-400", "0x1", "ray", "plane", "\u00e9", "\t", "''", "9" * 400, "((((", ""]
# Number of doubles in a value's bytes, after as many others.
SIZES = {"cloud_point": (0, 3), "cloud_ray": (0, 6), "cloud_plane": (0, 6), "cloud_limit": (1, 8), "cloud_distance": (0, 1)}


def damaged(r, text):
    characters = list(text)
    for _ in range(r.randint(1, 4)):
        place = r.randrange(len(characters) + 1)
        kind = r.randrange(4)
        if kind == 0:
            characters[place:place] = r.choice(PIECES)
        elif kind == 1:
            del characters[place:place + r.randint(1, 4)]
        elif kind == 2 and place < len(characters):
            characters[place] = chr(r.randint(1, 126))
        else:
            characters = characters[:place]
    return "".join(characters)


def quoted(text):
    return "'" + text.replace("'", "''") + "'"


def psql(connection, script):
    run = subprocess.run(["psql", "-X", "-q", "-A", "-t", connection], input=script, text=True, capture_output=True)
    return run.stdout.splitlines(), run.stderr


def main(connection):
    r = random.Random(7)
    script = ["CREATE EXTENSION alidade_pg; SET standard_conforming_strings = on;",
              """CREATE FUNCTION verdict(type text, written text) RETURNS text LANGUAGE plpgsql AS $$
                 DECLARE once text; twice text;
                 BEGIN
                   EXECUTE format('SELECT %L::%I::text', written, type) INTO once;
                   EXECUTE format('SELECT %L::%I::text', once, type) INTO twice;
                   RETURN CASE WHEN once = twice THEN 'taken' ELSE 'changed: ' || written END;
                 EXCEPTION WHEN invalid_text_representation OR numeric_value_out_of_range OR invalid_parameter_value THEN
                   RETURN 'rejected';
                 END $$;"""]
    count = 0
    for type_name, text in VALID.items():
        for _ in range(500):
            script.append(f"SELECT verdict('{type_name}', {quoted(damaged(r, text))});")
            count += 1
    answers, errors = psql(connection, "\n".join(script))
    taken, rejected = answers.count("taken"), answers.count("rejected")
    wrong = [line for line in answers if line not in ("taken", "rejected")]
    print(f"texts: {count} damaged, {taken} taken, {rejected} rejected")
    if errors or wrong or taken + rejected != count or taken < 100 or rejected < 1000:
        print(errors[:1000], wrong[:5])
        return 1

    # The same with bytes, in COPY's binary form: a head, then rows of fields with their length.
    head = b"PGCOPY\n\xff\r\n\0" + struct.pack("!ii", 0, 0)
    down = 0
    results = {"taken": 0, "rejected": 0}
    for type_name, (bytes_before, doubles) in SIZES.items():
        for _ in range(20):
            value = bytearray(bytes([r.choice((1, 2, 0, 3, 255))] * bytes_before) + struct.pack(f"!{doubles}d", *[r.uniform(-9, 9)] * doubles))
            for _ in range(r.randrange(3)):
                value[r.randrange(len(value))] = r.randrange(256)
            if r.random() < 0.3:
                value = value[:r.randrange(len(value))]
            if r.random() < 0.1:
                value += b"more"
            data = head + struct.pack("!hi", 1, len(value)) + bytes(value) + struct.pack("!h", -1)
            run = subprocess.run(["psql", "-X", "-q", "-A", "-t", connection, "-c", f"CREATE TEMP TABLE t(v {type_name})",
                                  "-c", "COPY t FROM stdin (FORMAT binary)", "-c", "SELECT count(v::text) FROM t"],
                                 input=data, capture_output=True)
            said = run.stderr.decode(errors="replace")
            results["rejected" if "ERROR" in said else "taken"] += 1
            if "server closed" in said or "ERROR" not in said and run.stdout.strip() != b"1":
                down += 1
                print(type_name, bytes(value), said)
    print(f"bytes: {results['taken']} taken, {results['rejected']} rejected")
    return 0 if down == 0 and min(results.values()) > 10 else 1


sys.exit(main(sys.argv[1]))
