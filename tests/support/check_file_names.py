#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Fails where a comment, a CMake file, a script or a page names a source, header or script that is not in the tree.

check_file_names.py [FOLDER]: of the tree that FOLDER is in (default: this file's)."""

import pathlib
import re
import subprocess
import sys

NAME = re.compile(r"(?<![\w/.<$*}-])((?:[\w-]+/)*[\w-]+\.(?:h|cpp|cmake|sh|py))(?![\w*(/-])")
# In sources only what stands in comments counts: strings are messages, and the compiler checks #include.
COMMENT = re.compile(r"(?:^|\s)//.*|^\s*#(?!include).*")
# Files of other projects, files that the build makes, and files that whoever reads a page or a test writes.
OTHERS = {"xxhash.h", "zstd.h", "libpq-fe.h", "libnova/libnova.h", "read_write_dense.py", "gdal_edit.py", "gdal_fillnodata.py"}
MADE = {"page_parts.cpp", "report/page_parts.cpp", "compare/report/page_parts.cpp", "manuals.cpp"}
WRITTEN = {"NAME.cpp", "hooks.cpp", "script.py", "a_test.cpp", "b_test.cpp", "render_parts.sh"}


def tracked(folder):
    listed = subprocess.run(["git", "ls-files"], cwd=folder, check=True, capture_output=True, text=True)
    return [pathlib.PurePosixPath(path) for path in listed.stdout.splitlines()]


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else __file__).resolve()
    folder = pathlib.Path(subprocess.run(["git", "rev-parse", "--show-toplevel"], cwd=folder if folder.is_dir() else folder.parent,
                                         check=True, capture_output=True, text=True).stdout.strip())
    paths = tracked(folder)
    known = OTHERS | MADE | WRITTEN | {"/".join(path.parts[-length:]) for path in paths for length in range(1, len(path.parts) + 1)}
    is_well = True
    for path in paths:
        is_source = path.suffix in (".h", ".cpp")
        if not (is_source or path.suffix in (".cmake", ".md", ".sh") or path.name in ("CMakeLists.txt", "dev")):
            continue
        if path.name == "CHANGELOG.md" or path.parts[0] == "packaging":
            continue  # of releases and of other trees
        for number, line in enumerate((folder / path).read_text(encoding="utf-8").splitlines(), 1):
            text = " ".join(COMMENT.findall(line)) if is_source else line
            for name in NAME.findall(text):
                if name in known:
                    continue
                print(f"{path}:{number}: names {name}, which is not in the tree", file=sys.stderr)
                is_well = False
    sys.exit(0 if is_well else 1)


if __name__ == "__main__":
    main()
