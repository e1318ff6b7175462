# SPDX-License-Identifier: MIT OR Apache-2.0
"""The declarations of ctypes are those of ellgran.h, as a C compiler reads it; and what importing the package costs."""
import ctypes
import os
import subprocess
import sys
from pathlib import Path

import ellgran
from ellgran import _interface, _library

INCLUDE = os.environ.get("ELLGRAN_INCLUDE", str(Path(__file__).parents[2] / "include"))


def structs():
    return [kind for kind in vars(_interface).values() if isinstance(kind, type) and issubclass(kind, ctypes.Structure)]


def test_sizes_offsets_and_constants_are_those_of_the_compiler(tmp_path):
    lines, expected = [], []
    for kind in structs():
        lines.append(f'printf("%zu\\n", sizeof({kind.__name__}));')
        expected.append(ctypes.sizeof(kind))
        for name, _ in kind._fields_:
            lines.append(f'printf("%zu %zu\\n", offsetof({kind.__name__}, {name}), sizeof((({kind.__name__} *) 0)->{name}));')
            expected += [getattr(kind, name).offset, getattr(kind, name).size]
    for name, value in vars(_interface).items():
        if name.startswith("ELLGRAN_"):
            lines.append(f'printf("%d\\n", (int) {name});')
            expected.append(value)
    source = tmp_path / "layout.c"
    source.write_text(
        "#include <ellgran.h>\n#include <stdio.h>\nint main(void) {\n" + "\n".join(lines) + "\nreturn 0;\n}\n"
    )
    program = tmp_path / "layout"
    subprocess.run([os.environ.get("CC", "cc"), "-std=c99", "-I", INCLUDE, str(source), "-o", str(program)], check=True)
    said = subprocess.run([str(program)], check=True, stdout=subprocess.PIPE).stdout.split()
    assert len(structs()) > 10
    assert [int(word) for word in said] == expected


def test_every_declared_struct_begins_with_its_size():
    for kind in structs():
        assert kind._fields_[0] == ("size", ctypes.c_size_t)


def test_the_package_is_loaded_when_it_is_used():
    """LAMMPS imports it when it starts, for the folder of the plugin alone."""
    code = "import sys, ellgran; assert 'numpy' not in sys.modules; ellgran.Bodies; assert 'numpy' in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_all_names_are_there():
    for name in ellgran.__all__:
        assert getattr(ellgran, name).__doc__
    assert set(ellgran.__all__) <= set(dir(ellgran))
    try:
        ellgran.nothing
    except AttributeError as error:
        assert "nothing" in str(error)
    else:
        raise AssertionError("a name that is not there")


def test_a_missing_library_says_what_to_do():
    environment = dict(os.environ, ELLGRAN_LIBRARY="/no/libellgran.so")
    done = subprocess.run(
        [sys.executable, "-c", "import ellgran; ellgran.Law"], env=environment, stderr=subprocess.PIPE, text=True
    )
    assert done.returncode != 0
    assert "/no/libellgran.so" in done.stderr and "ELLGRAN_LIBRARY" in done.stderr


def test_versions_agree():
    assert ellgran.version() == ellgran.__version__
    assert _library.library_path().is_file()
