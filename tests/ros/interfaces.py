"""Makes packages of ROS interfaces usable in the Python that runs this: ``python interfaces.py BUILD PACKAGE…``, where
each PACKAGE is a folder with ``msg``, ``srv`` and ``action``. It needs the generators of rosidl beside this Python, and
gcc and g++; it does what ament_cmake would, without cmake.

All of one package goes into one library, which has the names of those that ROS looks for. That leaves out what only C++
nodes use. A package may use types of itself, of wheels, and of packages that were built before it.
"""

from __future__ import annotations

import contextlib
import io
import json
import os
import subprocess
import sys
import sysconfig
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from rosidl_adapter import convert_to_idl  # type: ignore[import-not-found]
from rosidl_generator_c import generate_c  # type: ignore[import-not-found]
from rosidl_generator_py import generate_py  # type: ignore[import-not-found]
from rosidl_generator_type_description import generate_type_hash  # type: ignore[import-not-found]
from rosidl_typesupport_c import generate_c as generate_typesupport_c  # type: ignore[import-not-found]
from rosidl_typesupport_fastrtps_c import generate_typesupport_fastrtps_c  # type: ignore[import-not-found]
from rosidl_typesupport_introspection_c import (  # type: ignore[import-not-found]
    generate_c as generate_introspection_c,
)

KINDS: Final = ("msg", "srv", "action")
PREFIX: Final = Path(sys.prefix)
SHARE: Final = PREFIX / "share"
LIBRARIES: Final = PREFIX / "lib"
TYPESUPPORT: Final = "rosidl_typesupport_c"
IMPLEMENTATIONS: Final = ("rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c")
"""Fast DDS sends by the first one, and tells the peers of a topic its type by the second."""


@dataclass(frozen=True, slots=True)
class _Arguments:
    """What every generator is told, but for its templates."""

    package: str
    output: Path
    idl: list[str]
    sources: list[str]

    def file(self, generator: str, *, apart: bool = False) -> str:
        """Write them where the generator reads them. ``apart``: its files have the names of another one's."""
        known: dict[str, Any] = {
            "package_name": self.package,
            "output_dir": str(self.output.parent / "apart" / self.package if apart else self.output),
            "template_dir": str(SHARE / generator / "resource"),
            "idl_tuples": [f"{self.output}:{path}" for path in self.idl],
            "ros_interface_files": self.sources,
            "ros_interface_dependencies": [],
            "target_dependencies": [],
            "include_paths": [f"{path.name}:{path}" for path in SHARE.iterdir() if path.is_dir()],
            "type_description_tuples": [f"{p}:{self.output / Path(p).with_suffix('.json')}" for p in self.idl],
        }
        path = self.output / f"{generator}.json"
        path.write_text(json.dumps(known))
        return str(path)


def generate(package: Path, output: Path) -> None:
    """Write the sources of one package."""
    idl, sources = [], []
    for kind in KINDS:
        for path in sorted((package / kind).glob(f"*.{kind}")):
            with contextlib.redirect_stdout(io.StringIO()):
                convert_to_idl(package.resolve(), package.name, path.relative_to(package), output)
            idl.append(f"{kind}/{path.stem}.idl")
            sources.append(str(path.resolve()))
    told = _Arguments(package.name, output, idl, sources)
    generate_type_hash(told.file("rosidl_generator_type_description"))
    generate_c(told.file("rosidl_generator_c"))
    generate_typesupport_fastrtps_c(told.file("rosidl_typesupport_fastrtps_c"))
    generate_introspection_c(told.file("rosidl_typesupport_introspection_c", apart=True))
    generate_typesupport_c(told.file("rosidl_typesupport_c"), list(IMPLEMENTATIONS))
    generate_py(told.file("rosidl_generator_py"), [TYPESUPPORT])
    for generator in ("rosidl_generator_c", *IMPLEMENTATIONS):
        name = f"{generator}__visibility_control.h"
        text = (SHARE / generator / "resource" / f"{name}.in").read_text()
        text = text.replace("@PROJECT_NAME@", package.name).replace("@PROJECT_NAME_UPPER@", package.name.upper())
        (output / "msg").mkdir(exist_ok=True)
        (output / "msg" / name).write_text(text)


def build(package: Path, work: Path, pool: ThreadPoolExecutor) -> None:
    """Generate, compile and install one package."""
    name = package.name
    output = work / name
    output.mkdir(parents=True, exist_ok=True)
    generate(package, output)
    made = (*output.rglob("*"), *(work / "apart" / name).rglob("*"))
    sources = [path for path in made if path.suffix in (".c", ".cpp")]
    objects = dict(zip(sources, pool.map(lambda source: _compile(source, work), sources), strict=True))
    installed = Path(sysconfig.get_path("purelib")) / name
    for path in output.rglob("*.py"):
        to = installed / path.relative_to(output)
        to.parent.mkdir(parents=True, exist_ok=True)
        to.write_text(path.read_text())
    (installed / "__init__.py").touch()
    of_python = [made for source, made in objects.items() if source.name.endswith(f".ep.{TYPESUPPORT}.c")]
    library = LIBRARIES / f"lib{name}__rosidl_generator_c.so"
    _link(library, [made for made in objects.values() if made not in of_python])
    for alias in (TYPESUPPORT, *IMPLEMENTATIONS, "rosidl_generator_py"):
        link = LIBRARIES / f"lib{name}__{alias}.so"
        link.unlink(missing_ok=True)
        link.symlink_to(library.name)
    _link(installed / f"{name}_s__{TYPESUPPORT}.so", of_python)
    for path in output.rglob("*.json"):
        if path.parent.name in KINDS:
            to = SHARE / name / path.relative_to(output)
            to.parent.mkdir(parents=True, exist_ok=True)
            to.write_text(path.read_text())


def _compile(source: Path, work: Path) -> Path:
    includes = [f"-I{path}" for path in (PREFIX / "include").iterdir()]
    includes += [f"-I{PREFIX / 'include'}", f"-I{work}", f"-I{work / 'apart'}"]
    includes += [f"-I{sysconfig.get_path('include')}", f"-I{_numpy()}"]
    language = ["g++", "-std=c++17"] if source.suffix == ".cpp" else ["gcc", "-std=c11"]
    target = source.with_name(source.name + ".o")
    _run(*language, "-O1", "-fPIC", "-w", "-c", source, "-o", target, *includes)
    return target


def _link(target: Path, objects: list[Path]) -> None:
    """With whatever it needs of all that is there."""
    known = [path.name for path in sorted(LIBRARIES.glob("lib*.so")) if path != target and not path.is_symlink()]
    _run(
        "g++", "-shared", "-Wl,--as-needed", "-o", target, *objects, f"-L{LIBRARIES}", *(f"-l:{name}" for name in known)
    )


def _numpy() -> str:
    import numpy

    return str(numpy.get_include())


def _run(*command: str | Path) -> None:
    subprocess.run([str(part) for part in command], check=True)


def main(work: Path, packages: list[Path]) -> None:
    """Build them all."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for package in packages:
            build(package, work, pool)


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve(), [Path(path) for path in sys.argv[2:]])
