# SPDX-License-Identifier: MIT
"""Builds a wheel of the module (PEP 517): `python3 -m build --wheel --no-isolation`, or `pip wheel .`.

CMake compiles the module for the Python that runs this. Shared libraries that are not part of every Linux go into the wheel
beside it, found by an rpath (patchelf). Needed: what ./dev installs, and patchelf.
"""
import base64
import hashlib
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / f"wheel-{sys.version_info.major}.{sys.version_info.minor}"
# Of every Linux with the C++ library of GCC 12 or later.
EVERYWHERE = re.compile(r"(ld-linux|linux-vdso|libc\.|libm\.|libdl\.|librt\.|libpthread\.|libgcc_s\.|libstdc\+\+\.)")


def project():
    text = (ROOT / "pyproject.toml").read_text()
    facts = {key: re.search(rf'^{key} = "(.*)"', text, re.M)[1] for key in ("name", "version", "description", "requires-python")}
    return facts | {"dependencies": re.findall(r'"([^"]+)"', re.search(r"^dependencies = \[(.*)\]", text, re.M)[1])}


def metadata():
    facts = project()
    return (f"Metadata-Version: 2.1\nName: {facts['name']}\nVersion: {facts['version']}\nSummary: {facts['description']}\n"
            f"Requires-Python: {facts['requires-python']}\nLicense: MIT\n"
            + "".join(f"Requires-Dist: {name}\n" for name in facts["dependencies"]))


def libraries_of(file):
    """The files of the libraries that a file is linked with, directly or by others."""
    lines = subprocess.run(["ldd", file], check=True, capture_output=True, text=True).stdout.splitlines()
    absent = [line.split()[0] for line in lines if "not found" in line]
    if absent:
        sys.exit(f"wheel_backend: error: {file} needs {', '.join(absent)}; expected them installed")
    found = [line.split("=> ")[1].split(" (")[0] for line in lines if "=> /" in line]
    return [Path(path) for path in found if not EVERYWHERE.match(Path(path).name)]


def package(folder):
    """Makes the folder alidade/ of the wheel. Returns the libraries in it."""
    tools = {"g++": "g++", "cmake": "cmake", "ninja": "ninja-build", "patchelf": "patchelf", "strip": "binutils",
             "ldd": "libc-bin"}
    for tool, name in tools.items():
        if not shutil.which(tool):
            sys.exit(f"wheel_backend: error: {tool} is missing; expected the Debian package {name}")
    launcher = ["-DCMAKE_CXX_COMPILER_LAUNCHER=ccache"] if shutil.which("ccache") else []
    subprocess.run(["cmake", "-S", ROOT, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DALIDADE_BUILD_TESTS=OFF",
                    "-DALIDADE_UNITY=ON", f"-DALIDADE_PYTHON={sys.executable}", *launcher], check=True)
    subprocess.run(["cmake", "--build", BUILD, "--parallel", str(os.cpu_count()), "--target", "alidade_python"], check=True)
    shutil.copytree(BUILD / "python" / "alidade", folder, ignore=shutil.ignore_patterns("__pycache__"))
    (module,) = folder.glob("_alidade*.so")
    subprocess.run(["strip", "--strip-unneeded", module], check=True)
    libraries = libraries_of(module)
    for library in libraries:
        shutil.copy(library, folder / library.name)
    for file in [module, *(folder / library.name for library in libraries)]:
        subprocess.run(["patchelf", "--set-rpath", "$ORIGIN", file], check=True)
    return libraries


def licences(libraries):
    """The licences of the libraries in the wheel, from Debian's packages."""
    texts = {}
    for library in libraries:
        found = subprocess.run(["dpkg-query", "--search", library.resolve()], capture_output=True, text=True).stdout
        name = found.split(":")[0]
        copyright = Path("/usr/share/doc") / name / "copyright"
        if name and copyright.is_file():
            texts[f"LICENSE.{name}"] = copyright.read_bytes()
    return texts


def digest(data):
    return "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    facts = project()
    version = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{version}-{version}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
    info = f"{facts['name']}-{facts['version']}.dist-info"
    name = f"{facts['name']}-{facts['version']}-{tag}.whl"
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / facts["name"]
        libraries = package(folder)
        files = {f"{facts['name']}/{path.name}": path.read_bytes() for path in sorted(folder.iterdir())}
    files[f"{info}/METADATA"] = metadata().encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: alidade\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    files[f"{info}/LICENSE"] = (ROOT / "LICENSE").read_bytes()
    files |= {f"{info}/{name}": text for name, text in licences(libraries).items()}
    record = "".join(f"{path},{digest(data)},{len(data)}\n" for path, data in files.items())
    files[f"{info}/RECORD"] = (record + f"{info}/RECORD,,\n").encode()
    unfinished = Path(wheel_directory) / f".{name}.part"
    with zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED) as wheel:
        for path, data in files.items():
            wheel.writestr(path, data)
    unfinished.rename(Path(wheel_directory) / name)
    return name


def build_sdist(sdist_directory, config_settings=None):
    sys.exit("wheel_backend: error: source distributions are not made; expected 'python3 -m build --wheel', or a clone")
