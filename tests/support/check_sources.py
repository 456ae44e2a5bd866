#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that a reader who knows the name of a header knows the name of its source: a source has a header of its own name
beside it and defines nothing that another header declares. It reads the sources as clang-format leaves them: declarations
begin in the first column, those of classes are indented."""
import pathlib
import re
import sys

ROOMS = ("base cloud octree surface mesh geo image camera renderer visibility compare database simulation jobs tools python").split()

# Each extension is a room of its own.
ROOMS += sorted(str(folder) for folder in pathlib.Path("extensions").iterdir() if folder.is_dir())
# Sources of extensions whose functions the build calls: cmake/extensions.cpp.in.
CALLED_BY_BUILD = ("command.cpp", "hooks.cpp", "python.cpp")

# Sources without a header of their own name, with the header that names them and the reason.
WITHOUT_HEADER = {
    "camera/formats/colmap.cpp": "camera/formats/camera_file.h names all readers of camera files, one source for each format",
    "camera/formats/openmvg.cpp": "camera/formats/camera_file.h",
    "camera/formats/opensfm.cpp": "camera/formats/camera_file.h",
    "camera/formats/trajectory.cpp": "camera/formats/camera_file.h",
    "camera/formats/transforms.cpp": "camera/formats/camera_file.h",
    "extensions/duckdb/extension.cpp": "the function that DuckDB calls",
    "extensions/postgres/alidade_pg/indexes.cpp": "functions of SQL, declared in extensions/postgres/alidade_pg/alidade_pg--1.0.sql.in",
    "extensions/postgres/alidade_pg/planner_support.cpp": "functions of SQL, declared in extensions/postgres/alidade_pg/alidade_pg--1.0.sql.in",
    "extensions/postgres/alidade_pg/values.cpp": "functions of SQL, declared in extensions/postgres/alidade_pg/alidade_pg--1.0.sql.in",
    "database/sqlite/module.cpp": "the function that SQLite calls",
    "image/backend/openimageio.cpp": "the module that image/backend.cpp loads",
    "octree/simd/box_search.cpp": "search<Bounds> of octree/simd/search.h",
    "octree/simd/point_search.cpp": "search<glm::dvec3> of octree/simd/search.h",
    "octree/simd/ray_search.cpp": "search<Ray> of octree/simd/search.h",
    "python/module.cpp": "the function that Python calls",
    "surface/simd/near_spheres.cpp": "surface/surface_cloud.h: all SIMD code is in simd/, what users include is not",
    "python/python_images.cpp": "bindings, added by a function of python/python_cloud.h",
    "python/python_jobs.cpp": "python/python_cloud.h declares give()",
    "python/python_queries.cpp": "bindings, added by a function of python/python_cloud.h",
    "tools/main.cpp": "the program",
    "tools/cloud/clouds.cpp": "tools/command.h: the commands that make files of clouds",
}
# Headers that declare a function for each source of a kind: the beginnings of the function's and the source's name.
NAMED_BY_FUNCTION = {
    "tools/command.h": ("add_", ""),  # a command: add_NAME() is in NAME.cpp, add_FOLDER_NAME() in FOLDER/NAME.cpp
    "cloud/cloud_reader.h": ("open_", "read_"),  # a format of clouds: open_FORMAT() is in read_FORMAT.cpp
}

DEFINITION = re.compile(r"^(?=\S)(?!using|namespace|struct|class|enum|template|typedef|static_assert|extern|#|//|}|{|\)|HWY_|TEST|PG_)"
                        r"[^=;(]*?([A-Za-z_~][\w:~<>]*)\(", re.M)
CLASS = re.compile(r"^(?:class|struct)\s+(?:\w+\s+)*?(\w+)(?:\s+final)?\s*(?:[:{]|$)", re.M)
FUNCTION = re.compile(r"^(?=\S)(?!using|struct|class|enum|#|//|}|\s)[^=;(]*?\b([A-Za-z_]\w*)\(", re.M)


def code(text):
    """The text without comments, literals, unnamed namespaces, and those that Highway compiles for each instruction set,
    of which only a table of functions leaves the source."""
    text = re.sub(r"^namespace((?: HWY_NAMESPACE)?) \{\n(?:.|\n)*?^\}  // namespace\1$", "", text, flags=re.M)
    text = re.sub(r'R"(\w*)\((?:.|\n)*?\)\1"', '""', text)
    text = re.sub(r'"(?:[^"\\\n]|\\.)*"', '""', text)
    return re.sub(r"/\*(?:.|\n)*?\*/|//[^\n]*", "", text)


def is_definition(text, begin):
    """Whether the parameters that open at `begin` are followed by a body."""
    depth = 0
    for at in range(begin, len(text)):
        depth += {"(": 1, ")": -1}.get(text[at], 0)
        if depth == 0:
            after = re.match(r"[^;{]*[;{]", text[at + 1:])
            return bool(after) and after.group().endswith("{")
    return False


def declared(header):
    """Functions and classes that a header declares: in it a definition is inline, which is the header's own affair."""
    text = code(header.read_text())
    functions = {match.group(1) for match in FUNCTION.finditer(text) if not is_definition(text, match.end() - 1)}
    return functions, set(CLASS.findall(text))


def main():
    problems = []
    # Only headers of the same room and folder tree may declare what a source defines.
    for room in ROOMS:
        headers = {header: declared(header) for header in sorted(pathlib.Path(room).rglob("*.h"))}
        for source in sorted(pathlib.Path(room).rglob("*.cpp")):
            if room.startswith("extensions/") and (source.parent.name == "tests" or source.name in CALLED_BY_BUILD):
                continue
            own = [source.with_suffix(".h"), source.with_name(source.stem + "-inl.h")]
            own += map(pathlib.Path, re.findall(r"[\w/]+\.h\b", WITHOUT_HEADER.get(str(source), "")))
            named = {pathlib.Path(header): function for header, (function, name) in NAMED_BY_FUNCTION.items()
                     if header.startswith(f"{room}/") and source.stem.startswith(name) and
                     re.search(rf"\b{function}(\w+_)?{source.stem.removeprefix(name)}\(", source.read_text())}
            if not any(header.exists() for header in own) and str(source) not in WITHOUT_HEADER and not named:
                problems.append(f"{source}: has no header {own[0].name} beside it")
                continue
            text = code(source.read_text())
            for match in DEFINITION.finditer(text):
                if not is_definition(text, match.end() - 1):
                    continue
                owner, _, function = re.sub(r"<.*?>", "", match.group(1)).rpartition("::")
                owner = owner.split("::")[0]
                if owner:
                    where = [header for header in headers if owner in headers[header][1]]
                else:
                    where = [header for header in headers if function in headers[header][0]]
                where = [header for header in where if not (header in named and function.startswith(named[header]))]
                if where and not any(header in own for header in where):
                    problems.append(f"{source}: defines {match.group(1)}, which {where[0]} declares")
    for problem in problems:
        print(problem, file=sys.stderr)
    if problems:
        sys.exit(f"{len(problems)} sources or definitions stand where the name of their header does not lead")
    print("every source is named after its header")


if __name__ == "__main__":
    main()
